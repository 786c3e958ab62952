"""Spectra as bars and as a waterfall of a recording."""

from __future__ import annotations

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from benchtool.block import Block
from benchtool.live import names
from benchtool.live.messages import Message, TimeAxis, at
from benchtool.live.panels.spectrum import Bars, RunningSpectrum, bars, chosen, decibels, spectrogram

_BLUE, _RED = (86, 180, 233), (213, 94, 0)
_LINES = f"{names.SPECTRUM}/lines"
_HARMONICS = f"{names.SPECTRUM}/harmonics"
_WATERFALL = f"{names.SPECTRUM}/waterfall"


def running_spectra(running: RunningSpectrum, axis: TimeAxis, tick: int, *, waterfall: bool) -> list[Message]:
    """Return the spectrum of the stream's last seconds, and the waterfall so far where that is asked for."""
    found = running.bars()
    if found is None:
        return []
    messages = _bars(found, axis, tick)
    if waterfall:
        messages.append(_waterfall(running.waterfall(), axis, tick, "newest below", running.sample_rate_Hz))
    return messages


def capture_spectra(block: Block, axis: TimeAxis, tick: int) -> list[Message]:
    """Return the spectrum and waterfall of a capture, nothing of one with a gap.

    `tick` is that of the newest row of all: of the spectra the last is shown, and that of a capture is finer
    than those of a slow stream that ran beside it.
    """
    name = chosen(block.names)
    if name is None or block.gaps:
        return []
    samples, rate_Hz = block.column(name), block.sample_rate_Hz
    found = bars(samples, rate_Hz, name, block.unit(name))
    if found is None:
        return []
    picture, row_s = spectrogram(samples, rate_Hz)
    title = f"{len(picture) * row_s:.2g} s, from above"
    return [*_bars(found, axis, tick), _waterfall(picture, axis, tick, title, rate_Hz)]


def _bars(found: Bars, axis: TimeAxis, tick: int) -> list[Message]:
    step_Hz = float(found.frequency_Hz[1] - found.frequency_Hz[0])
    peak_Hz, peak = np.array([found.fundamental_Hz]), decibels(np.array([found.fundamental]))
    order = np.arange(2, 2 + len(found.harmonic_percent), dtype=np.float64)
    mark_Hz = max(step_Hz, 0.01 * float(found.frequency_Hz[-1]))
    spectrum = _chart(found.frequency_Hz, found.amplitude_dB, step_Hz, _BLUE)
    fundamental = _chart(peak_Hz, peak, mark_Hz, _RED)
    return [
        at(f"{_LINES}/amplitude", axis, tick, spectrum),
        at(f"{_LINES}/fundamental", axis, tick, fundamental),
        at(f"{_HARMONICS}/relative", axis, tick, _chart(order, found.harmonic_percent, 0.8, _BLUE)),
    ]


def _chart(
    place: NDArray[np.float64], value: NDArray[np.float64], width: float, colour: names.Colour
) -> rr.ComponentColumnList:
    return rr.BarChart.columns(
        values=[rr.TensorData(array=value)],
        color=[colour],
        abscissa=[rr.TensorData(array=place)],
        widths=[np.full(len(value), width)],
    )


def _waterfall(
    picture: NDArray[np.uint8], axis: TimeAxis, tick: int, rows: str, sample_rate_Hz: float
) -> Message:
    data = rr.TensorData(array=picture, dim_names=(rows, f"0 to {sample_rate_Hz / 2.0:g} Hz"))
    return at(_WATERFALL, axis, tick, rr.Tensor.columns(data=[data], value_range=[[0.0, 70.0]]))
