"""Record the stream of a drive to disk and read it back, whatever the drive is doing meanwhile.

Another program may have enabled the drive: a recording sends nothing but what sets the stream up.
"""

import benchtool

with benchtool.open_bench("zhu2011") as bench, bench.drive.enabled("velocity") as drive:
    drive.omega_m_command = 31.4
    recorded = bench.record(2.0, ["torque", "omega_m", "i_q"], out="recording", rate_Hz=250)

bundle = benchtool.open_bundle(recorded.path)
block = bundle.block()
print(block)
print(block.certificate.summary if block.certificate else "without a certificate")
frame = block.to_pandas()
print(frame.loc[1.5:, "omega_m"].describe())
block.plot("omega_m", "torque").save("recording.png")
