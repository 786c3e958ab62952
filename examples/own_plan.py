"""A plan made in Python: the same keys as in a TOML file, run, judged and kept on disk.

`benchtool.write_report(result)` makes a page of it, as `benchtool report laws` does.
"""

import benchtool

plan = benchtool.Plan(
    title="Ripple of two laws at half of rated speed",
    profile="zhu2011",
    operating_point={"omega_m_rad_s": 78.5, "load_torque_Nm": 1.0, "settle_s": 0.8},
    sweep={"setup": {"law": ["tpc", "foc"]}},
    record={"duration_s": 0.1, "channels": ["torque", "psi_s", "theta_m"]},
    limits={"torque_ripple_pp_Nm": {"max": 0.5}, "capture_rows_missing": {"max": 0}},
)

result = benchtool.run_plan(plan, out="laws")
for name, case in result.items():
    print(f"{name}: {case.verdict}, {case['torque_ripple_pp']}")
print(f"together: {result.verdict}, kept in {result.folder}")
