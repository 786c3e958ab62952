"""What measurements are named after that may be of any channel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

_QUANTITIES: Final[Mapping[str, str]] = {"omega_m": "speed", "torque_transducer": "transducer_torque"}


def named_after(channel: str) -> str:
    """Return the quantity whose name measurements of a channel begin with: mostly that of the channel."""
    return _QUANTITIES.get(channel, channel)
