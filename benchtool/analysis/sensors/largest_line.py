"""Which of several lines is the largest before a sensor that takes more off one than off another."""

from __future__ import annotations

import math

import numpy as np

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.numbers import raw
from benchtool.analysis.sensors.lag import Lag
from benchtool.analysis.sensors.waveform import Waveform

_OWN_BINS = 3.0  # about a line: half of the main lobe of a Hann window, and what sampling may shift


def may_be_another(each: Measurement, lag: Lag, waveform: Waveform) -> str:
    """Return that another line than the one that was read as the largest may be so before its sensor; empty
    where none may.

    By each response that is possible, of lines that stand out of the noise: of a number of an order of the
    rotation (`basis.order`) the other orders, of any other all lines.
    """
    own_Hz, order = each.basis.frequency_Hz, each.basis.order
    if own_Hz is None or not own_Hz > 0.0:
        return ""
    if order is None:
        width_Hz = waveform.rate_Hz / len(waveform.samples)
        places, sizes = waveform.lines()
        apart = np.abs(places * width_Hz - own_Hz) > _OWN_BINS * width_Hz
        others = list(zip((places[apart] * width_Hz).tolist(), sizes[apart].tolist(), strict=True))
    else:
        top_Hz = math.inf if each.basis.bandwidth_Hz is None else each.basis.bandwidth_Hz
        found = waveform.harmonics(own_Hz / order, top_Hz)
        others = [(at_Hz, size) for at_Hz, size in found if size > waveform.least_amplitude]
    own = waveform.amplitude(own_Hz)
    # faster ones lose more: where one is larger as it was read, it was left out for a reason of its own
    others = [(at_Hz, size) for at_Hz, size in others if at_Hz > own_Hz and size < own]
    for response in lag.responses:
        for at_Hz, size in others:
            if size * response.enlarges(at_Hz) >= own * response.enlarges(own_Hz):
                return f"the line at {raw(at_Hz, 5)} Hz may be the largest before the sensor"
    return ""
