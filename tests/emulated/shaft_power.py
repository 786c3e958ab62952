"""Another package, which measures the mechanical power, as an installer would have left it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

MODULE: Final = '''"""Mechanical power of the shaft."""

import numpy as np

from benchtool.analysis import Analysis, Basis, Drawing, Findings, Measurement, Quantity
from benchtool.document import Section


class PowerSettings(Section):
    """Which torque counts."""

    torque: str = "torque"


def measure(window, settings):
    block = window.block
    power_W = block.column(settings.torque) * block.column("omega_m")
    basis = Basis(samples=len(power_W), sample_rate_Hz=block.sample_rate_Hz)
    text = f"mean of {settings.torque} x omega_m"
    mean = Measurement("shaft_power_mean", float(np.mean(power_W)), "W", text, basis)
    return Findings((mean,), result=power_W)


def draw(figure, panels):
    axes = figure.subplots()
    for panel in panels:
        axes.plot(panel.result("shaft_power"), label=panel.name)
    axes.set_xlabel("row")
    axes.set_ylabel("power (W)")


DRAWING = Drawing("shaft_power", "Shaft power", "Mechanical power at every row.", draw=draw)

SHAFT_POWER = Analysis(
    name="shaft_power",
    title="shaft power",
    measure=measure,
    quantities=(Quantity(("shaft_power_mean",), "W", "mean of torque x omega_m", label="power"),),
    settings=PowerSettings,
    channels=("omega_m",),
    channel_settings=("torque",),
    figures=(DRAWING,),
    comparisons=(DRAWING,),
)
'''


def install(folder: Path, module: str = MODULE, value: str = "shaft_power_analysis:SHAFT_POWER") -> None:
    """Write the package into a folder that is then on `sys.path`."""
    (folder / "shaft_power_analysis.py").write_text(module, encoding="utf-8")
    info = folder / "shaft_power-1.2.dist-info"
    info.mkdir()
    metadata = "Metadata-Version: 2.1\nName: shaft-power\nVersion: 1.2\n"
    (info / "METADATA").write_text(metadata, encoding="utf-8")
    (info / "entry_points.txt").write_text(f"[benchtool.analyses]\nshaft_power = {value}\n", encoding="utf-8")
