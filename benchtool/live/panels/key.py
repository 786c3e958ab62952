"""The key of the plots: which colour is which series, in words and outside of the plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import rerun as rr

from benchtool.block import Channel
from benchtool.live import names
from benchtool.live.panels.band import BAND_KEY


def key_document(sources: Mapping[str, Sequence[Channel]]) -> rr.TextDocument:
    """Return series by plot, each with its colour; those of the slow stream have a lighter tone of the same.

    Args:
        sources: channels by source (`names.STREAM` ...).
    """
    series: dict[str, dict[str, str]] = {}
    for channels in sources.values():
        for quantity, columns in names.columns_by_quantity(channels).items():
            for place, column in enumerate(columns):
                channel = channels[column]
                tone = names.in_words(names.base_colour(channel, place))
                series.setdefault(quantity, {}).setdefault(channel.name, tone)
    if "torque" in series:
        series["torque"] |= BAND_KEY
    lines = [
        f"**{quantity}** "
        + ", ".join(f"{name.replace('_', chr(92) + '_')} {tone}" for name, tone in named.items())
        for quantity, named in series.items()
        if quantity in _PLOTTED
    ]
    tones = ["slow stream in light tones"] if len(sources) > 1 else []
    return rr.TextDocument(" · ".join([*lines, *tones]), media_type=rr.MediaType.MARKDOWN)


_PLOTTED = ("torque", "current", "speed", "flux")
