"""Orders that a machine may be expected to have, by its pole pairs and slots."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

MACHINE_ORDERS: Final = ("1p", "2p", "6p", "12p", "slots", "cogging")
"""The orders that a machine may be expected to have, as the names of measurements call them."""


def machine_orders(pole_pairs: int | None, slots: int | None) -> Mapping[str, int | None]:
    """Return the order behind each of `MACHINE_ORDERS`; None where pole pairs or slots are not known."""
    multiples = {key: int(key[:-1]) for key in MACHINE_ORDERS if key.endswith("p")}
    of_poles = {key: None if pole_pairs is None else k * pole_pairs for key, k in multiples.items()}
    cogging = None if pole_pairs is None or slots is None else math.lcm(slots, 2 * pole_pairs)
    return {**of_poles, "slots": slots, "cogging": cogging}


def order_meaning(order: int, pole_pairs: int | None = None, slots: int | None = None) -> str:
    """Return the cause of an order in a machine with these pole pairs and slots; empty if there is none.

    Cogging is at multiples of the least common multiple of slots and poles (Hanselman, Brushless Permanent
    Magnet Motor Design); ripple of the phase harmonics 6m - 1 and 6m + 1 at 6m times the pole pairs.
    """
    meanings = []
    if pole_pairs is not None and order % pole_pairs == 0:
        multiple = order // pole_pairs
        if multiple == 1:
            meanings.append("electrical fundamental, p")
        elif multiple % 6 == 0:
            meanings.append(f"{multiple}p, phase harmonics {multiple - 1} and {multiple + 1}")
        else:
            meanings.append(f"{multiple}p, electrical harmonic")
    if slots is not None and pole_pairs is not None and order % (lcm := math.lcm(slots, 2 * pole_pairs)) == 0:
        meanings.append(f"{_times(order // lcm)}cogging, lcm of {slots} slots and {2 * pole_pairs} poles")
    elif slots is not None and order % slots == 0:
        meanings.append(f"{_times(order // slots)}slots")
    if order == 1 and not meanings:
        meanings.append("once per revolution")
    return "; ".join(meanings)


def _times(multiple: int) -> str:
    return "" if multiple == 1 else f"{multiple} x "
