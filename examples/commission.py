"""Look at a drive and set it up: who answers, what it can do, parameters with their limits, all or none."""

import benchtool

with benchtool.open_bench("zhu2011") as bench:
    drive = bench.drive
    identity = drive.identity
    print(f"{identity.device_name}, firmware {identity.firmware_version}, {drive.state.value}")
    print(drive.parameters.about("R_s"))
    drive.update({"R_s": "470 mohm", "L_d": "3.1 mH", "L_q": "3.1 mH"})
    for parameter in drive.parameters.overview("L_*"):
        print(parameter, "·", parameter.about)
    try:
        drive["R_s"] = "470 ohm"
    except benchtool.BenchError as refused:
        print(f"refused: {refused}")
