"""A sweep by a loop: ripple and switching frequency against the load, drawn with matplotlib.

A plan does the same with limits, a bundle on disk and a report: see `own_plan.py`.
"""

from matplotlib.figure import Figure

import benchtool

CHANNELS = ["i_a", "i_b", "i_c", "torque", "psi_s", "theta_m", "switching_count"]
loads_Nm = [0.3, 0.9, 1.5]
ripple, switching_Hz = [], []

with benchtool.open_bench("zhu2011") as bench, bench.drive.enabled("velocity") as drive:
    drive.omega_m_command = 62.8
    bench.wait(1.0)
    for load_Nm in loads_Nm:
        bench.load.torque(load_Nm)
        bench.wait(0.4)
        results = benchtool.analyze(drive.capture(0.15, CHANNELS), bench.profile)
        ripple.append(results["torque_ripple_pp"])
        switching_Hz.append(results["switching_frequency_mean"].value)
        print(f"{load_Nm:4.1f} Nm: {ripple[-1]}, {switching_Hz[-1]:.0f} Hz")

figure = Figure(layout="constrained")
axes = figure.subplots()
expanded = [each.uncertainty.expanded if each.uncertainty else 0.0 for each in ripple]
axes.errorbar(loads_Nm, [each.value for each in ripple], yerr=expanded, marker="o", capsize=3)
axes.set_xlabel("load torque in Nm")
axes.set_ylabel("torque ripple, peak to peak, in Nm")
figure.savefig("sweep.png")
