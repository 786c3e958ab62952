"""An analysis as a package of its own: once it is installed, plans, results and reports have it.

`pip install ./examples/plug_in_analysis`, then `benchtool analyze --list` shows it.
"""

import numpy as np

import benchtool
from benchtool.analysis import Analysis, Findings, Measurement, NoSettings, Quantity, Window

DEFINITION = "mean of torque x omega_m"


def measure(window: Window, _settings: NoSettings) -> Findings:
    """Mechanical power of the steady state."""
    power_W = window.block.column("torque") * window.block.column("omega_m")
    return Findings((Measurement("shaft_power_mean", float(np.mean(power_W)), "W", DEFINITION),))


SHAFT_POWER = Analysis(
    name="shaft_power",
    title="Power at the shaft",
    measure=measure,
    quantities=(Quantity(("shaft_power_mean",), "W", DEFINITION),),
    settings=NoSettings,
    channels=("torque", "omega_m"),
)

if __name__ == "__main__":  # as it is, before it is installed
    with benchtool.open_bench("zhu2011") as bench, bench.drive.enabled("velocity") as drive:
        bench.load.torque(0.65)
        drive.omega_m_command = 31.4
        bench.wait(0.8)
        block = drive.capture(0.1, ["torque", "omega_m"])
    print(*measure(Window.of(block, bench.profile.motor), NoSettings()).measurements)
