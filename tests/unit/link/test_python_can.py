"""The command line starts without pandas, which is installed with the extra `mdf` and which no run needs."""

from __future__ import annotations

import subprocess
import sys

CODE = """
import sys
from benchtool.link import import_can_without_mdf
import_can_without_mdf()
import can
from benchtool.block import Block, TimeBase, batch_of, block_of, schema_of
block = Block.from_arrays(1e3, {"i_a": "A"}, i_a=[1.0, float("nan"), 3.0])
time_base = TimeBase.of(block)
batch = batch_of(block, schema := schema_of(block.channels, time_base))
read = block_of(schema, [batch.slice(1)], 2, time_base, ())
print(can.Message().dlc, batch.column(0).to_pylist(), batch.column(0).null_count, read.data.T)
print("pandas" in sys.modules)
from asammdf import MDF
print(MDF.__name__, "pandas" in sys.modules)
"""


def test_a_bus_and_rows_of_a_recording_take_no_pandas_and_an_export_has_its_package() -> None:
    done = subprocess.run((sys.executable, "-c", CODE), capture_output=True, text=True, check=False)
    assert done.stdout.splitlines() == ["0 [1.0, nan, 3.0] 0 [[nan  3.]]", "False", "MDF True"], done.stderr
