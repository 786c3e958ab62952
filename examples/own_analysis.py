"""An analysis of one's own: a block is numpy columns with their unit and time, nothing more.

Currents in the rotor frame and the amplitude of the largest line beside the mean, computed by hand.
"""

import numpy as np

import benchtool

with benchtool.open_bench("zhu2011") as bench:
    pole_pairs = bench.profile.motor.pole_pairs
    with bench.drive.enabled("torque") as drive:
        bench.load.hold(31.4)
        drive.torque_command = 1.0
        bench.wait(0.3)
        block = drive.capture(0.2, ["i_a", "i_b", "i_c", "theta_m"])

i_a, i_b, i_c, theta_m = (block[name] for name in block.names)
theta_e = pole_pairs * theta_m
i_alpha, i_beta = (2.0 * i_a - i_b - i_c) / 3.0, (i_b - i_c) / np.sqrt(3.0)  # amplitude-invariant
i_q = i_beta * np.cos(theta_e) - i_alpha * np.sin(theta_e)
window = np.hanning(len(i_q))
spectrum = 2.0 * np.abs(np.fft.rfft((i_q - i_q.mean()) * window)) / window.sum()
largest = int(np.argmax(spectrum))
line = f"{spectrum[largest]:.3f} A at {largest / block.duration_s:.0f} Hz"
print(f"i_q is {i_q.mean():.3f} A, its largest line {line}")
