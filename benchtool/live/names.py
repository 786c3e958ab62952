"""Where things are in a recording: entities, names of series, timelines and colours.

A Block becomes one entity for each quantity it holds, `/stream/torque`, `/stream/current` and so on, each
with all its channels side by side: that costs less than an entity for each channel, and suits plots of one
unit. Components of vectors are quantities of their own, `/stream/current_vector`, as they are not plotted
with phases and magnitudes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from benchtool.block import Channel

TICK: Final = "drive_tick"
"""Control periods since power-up of the drive, an integer."""

DRIVE_TIME: Final = "drive_time"
"""`drive_tick` times the control period, as a duration."""

WALL_TIME: Final = "wall_time"
"""Wall time of the first row received plus the drive time since then, as a timestamp."""

STREAM: Final = "/stream"
CAPTURE: Final = "/capture"
TRANSDUCER: Final = "/bench/transducer"
"""Drawn below the others, which is what the order of names decides."""
TORQUE_BAND: Final = "/limits/torque"
CAPTURE_BAND: Final = "/limits/capture"
LOCUS: Final = "/locus"
SPECTRUM: Final = "/spectrum"
EVENTS: Final = "/drive/events"
ERROR: Final = "/drive/markers/error"
WARNING: Final = "/drive/markers/warning"
TRIGGER: Final = "/drive/markers/trigger"
STATE: Final = "/drive/state"
QUALITY: Final = "/quality/losses"
RECEPTION: Final = "/quality/received"
"""Counters of received rows are far larger than those of lost ones, and would flatten them in one plot."""
COUNTERS: Final = "/documents/quality"
RESULTS: Final = "/documents/results"
PARAMETERS: Final = "/documents/parameters"
KEY: Final = "/documents/key"
"""What the colours of the plots mean, in place of legends, which would cover the data."""

_QUANTITIES: Final = {
    "Nm": "torque",
    "A": "current",
    "Wb": "flux",
    "rad/s": "speed",
    "V": "voltage",
    "rad": "angle",
    "": "counts",
}
_OTHER: Final = "other"
_VECTORS: Final = {
    **dict.fromkeys(("i_d", "i_q", "i_alpha", "i_beta"), "current_vector"),
    **dict.fromkeys(("psi_alpha", "psi_beta"), "flux_vector"),
}
_SOURCES: Final = {STREAM: "", CAPTURE: ", capture", TRANSDUCER: ""}
_COLOURS: Final = {  # Okabe and Ito (Color Universal Design, 2008), on the dark ground of the viewer
    "i_a": (86, 180, 233),
    "i_b": (230, 159, 0),
    "i_c": (0, 158, 115),
    "torque": (86, 180, 233),
    "torque_reference": (240, 228, 66),
    "torque_transducer": (120, 120, 120),
    "psi_s": (230, 159, 0),
    "psi_s_reference": (240, 228, 66),
    "omega_m": (0, 158, 115),
}
_CYCLE: Final = ((86, 180, 233), (230, 159, 0), (0, 158, 115), (204, 121, 167), (213, 94, 0), (240, 228, 66))
_WORDS: Final = {
    (86, 180, 233): "blue",
    (230, 159, 0): "orange",
    (0, 158, 115): "green",
    (240, 228, 66): "yellow",
    (120, 120, 120): "grey",
    (204, 121, 167): "pink",
    (213, 94, 0): "red",
    (204, 204, 204): "white",
}

Colour = tuple[int, int, int]


def quantity(channel: Channel) -> str:
    """Return the last part of the entity that holds a channel."""
    return _VECTORS.get(channel.name) or _QUANTITIES.get(channel.unit, _OTHER)


def columns_by_quantity(channels: Sequence[Channel]) -> dict[str, tuple[int, ...]]:
    """Return the columns of a Block by quantity, in their order."""
    groups: dict[str, list[int]] = {}
    for column, channel in enumerate(channels):
        groups.setdefault(quantity(channel), []).append(column)
    return {name: tuple(columns) for name, columns in groups.items()}


def label(channel: Channel, source: str) -> str:
    """Return name of a series: `torque (Nm)`, with its source if that is not the slow stream."""
    unit = f" ({channel.unit})" if channel.unit else ""
    return f"{channel.name}{unit}{_SOURCES[source]}"


def colour(channel: Channel, place: int, source: str) -> Colour:
    """Return colour of a series; that of a slow stream is lighter than the same channel's in a capture."""
    red, green, blue = base_colour(channel, place)
    if source != STREAM:
        return red, green, blue
    return (red + 255) // 2, (green + 255) // 2, (blue + 255) // 2


def base_colour(channel: Channel, place: int) -> Colour:
    """Return the colour of a series in a capture; `place` is its own among those of its quantity."""
    return _COLOURS.get(channel.name, _CYCLE[place % len(_CYCLE)])


def in_words(colour_: Colour) -> str:
    """Return a colour of a series, as the key of the plots calls it."""
    return _WORDS[colour_]
