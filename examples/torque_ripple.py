"""Torque ripple at an operating point: set a parameter, load the shaft, run, capture, measure.

Run it with `python examples/torque_ripple.py`; for a real drive give its link, such as
`python examples/torque_ripple.py slcan:/dev/ttyACM0`.
"""

import sys

import benchtool

link = sys.argv[1] if len(sys.argv) > 1 else "emulated"

with benchtool.open_bench("zhu2011", link=link) as bench:
    bench.drive["u_s"] = 81.65
    bench.load.torque(0.65)
    with bench.drive.enabled("velocity") as drive:
        drive.omega_m_command = "150 rpm"
        bench.wait(1.5)
        block = drive.capture(0.52, ["i_a", "i_b", "i_c", "torque", "psi_s", "theta_m"])

results = benchtool.analyze(block, bench.profile)
print(results["torque_ripple_pp"])
print(results["current_thd_f"])
block.crop(0.0, 0.1).plot("torque", "i_a", "i_b", "i_c").save("torque_ripple.png")
