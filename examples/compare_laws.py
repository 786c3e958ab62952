"""Two torque laws at the same operating point, with the uncertainty of their difference."""

import benchtool

CHANNELS = ["i_a", "i_b", "i_c", "torque", "psi_s", "theta_m"]
results = {}

with benchtool.open_bench("zhu2011") as bench:
    bench.load.torque(0.65)
    for law in ("tpc", "foc"):
        with bench.drive.parameters.temporary({"law": law}), bench.drive.enabled("velocity") as drive:
            drive.omega_m_command = 31.4
            bench.wait(1.0)
            results[law] = benchtool.analyze(drive.capture(0.25, CHANNELS), bench.profile)

comparison = benchtool.compare(results["tpc"], results["foc"])
ripple = comparison["torque_ripple_pp"]
print(f"torque ripple: tpc {results['tpc']['torque_ripple_pp']}, foc {results['foc']['torque_ripple_pp']}")
print(f"{ripple.percent:+.0f} %, more than its uncertainty: {ripple.exceeds}")
