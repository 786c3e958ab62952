"""Step response and tuning: the torque with two bandwidths of the current controllers.

The drive paces the step and captures it by itself, so that the timing of this computer plays no part.
"""

import benchtool

STEP = benchtool.Stimulus(quantity="torque", shape="step", amplitude_Nm=2.0, duration_s=0.02)
ASKED = {"steady": False, "step": {"signal": "torque", "reference": "torque_reference"}}

with benchtool.open_bench("zhu2011") as bench:
    bench.load.hold(31.4)
    bench.drive["law"] = "foc"
    for bandwidth in (1000.0, 3000.0):
        bench.drive["omega_current"] = bandwidth
        with bench.drive.enabled("torque") as drive:
            bench.wait(0.1)
            block = drive.play(STEP, ["torque", "torque_reference", "i_q"])
        step = benchtool.analyze(block, bench.profile, analyses=ASKED)
        print(f"{bandwidth:g} rad/s: rises in {step['rise_time']}, overshoots {step['overshoot']}")
        block.plot("torque", "torque_reference").save(f"step_{bandwidth:g}.png")
