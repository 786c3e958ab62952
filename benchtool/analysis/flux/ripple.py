"""The ripple of the length of the stator flux, by the drive's estimate."""

from __future__ import annotations

from typing import Final

from benchtool.analysis.declaration import Analysis, Findings, NoSettings, Quantity
from benchtool.analysis.drawings import WAVEFORMS
from benchtool.analysis.torque.ripple import peak_to_peak_number
from benchtool.analysis.window import Window


def _measure_ripple(window: Window, _: NoSettings) -> Findings:
    what = "the drive's estimate psi_s (peak)"
    number = peak_to_peak_number(window.block, "psi_s", "flux_ripple_pp", track=window.track, what=what)
    return Findings((number,))


FLUX_RIPPLE: Final = Analysis(
    name="flux_ripple",
    title="flux ripple",
    measure=_measure_ripple,
    quantities=(Quantity(("flux_ripple_pp",), "Wb", "max - min of psi_s", "as pp", headline=True),),
    settings=NoSettings,
    channels=("psi_s",),
    figures=(WAVEFORMS,),
)
