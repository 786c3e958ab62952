"""Runs a module with few garbage collections: mypy spends a quarter of its time on them, sphinx nearly half.

python -m tests.few_collections mypy --version
"""

from __future__ import annotations

import gc
import runpy
import sys
from typing import Final
from unittest import mock

OBJECTS: Final = 2_000_000
"""Made between two collections. With ten times as many as mypy's own 200 000 it takes a fifth more memory."""

if __name__ == "__main__":
    del sys.argv[0]
    gc.set_threshold(OBJECTS, 30, 30)
    with mock.patch.object(gc, "set_threshold"):  # mypy would set its own
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
