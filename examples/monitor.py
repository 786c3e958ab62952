"""A monitor that runs for hours: watch the stream, keep what leads up to an event, go on.

`python examples/monitor.py 3600 slcan:/dev/ttyACM0` watches for an hour what another program has a drive do.
"""

import sys

import benchtool

duration_s = float(sys.argv[1]) if len(sys.argv) > 1 else 3.0
link = sys.argv[2] if len(sys.argv) > 2 else "emulated"
HIGHEST_TORQUE_NM = 2.0

with benchtool.open_bench("zhu2011", link=link) as bench:
    events, left_s = 0, duration_s
    while left_s > 0.0:
        # A stream of its own for each minute: memory stays as it is, however long this runs.
        part_s = min(60.0, left_s)
        with bench.drive.stream(["torque", "omega_m", "u_dc"], rate_Hz=100) as stream:
            bench.wait(part_s)
        left_s -= part_s
        block = stream.block
        highest_Nm = abs(block["torque"]).max()
        if highest_Nm > HIGHEST_TORQUE_NM:
            events += 1
            block.plot().save(f"event_{events}.png")
        lost = sum(gap.missing_rows for gap in block.gaps)
        print(f"{len(block.data)} rows, {lost} lost, at most {highest_Nm:.2f} Nm; {events} events")
