"""Runs a module with few garbage collections, or none: a fifth of mypy's time goes into them.

python -m tests.few_collections mypy --version
"""

from __future__ import annotations

import gc
import os
import runpy
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final
from unittest import mock

OBJECTS: Final = 2_000_000
"""Made between two collections. With ten times as many as mypy's own 200 000 it takes a fifth more memory."""
PLENTY_BYTES: Final = 12 << 30
"""Memory beside which no collection is needed: mypy takes 3.2 GB in place of 1.2, three workers 4 GB."""


def memory_bytes() -> int:
    """Return how much memory the machine has, or lets its container have."""
    sizes = [os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")]
    with suppress(OSError, ValueError):  # in no container, or in one without a limit
        sizes.append(int(Path("/sys/fs/cgroup/memory.max").read_text(encoding="ascii")))
    return min(sizes)


if __name__ == "__main__":
    del sys.argv[0]
    gc.set_threshold(OBJECTS, 30, 30)
    kept = ["set_threshold"]  # mypy would set its own
    if memory_bytes() >= PLENTY_BYTES:
        gc.disable()
        kept.append("enable")  # mypy would, after it has read its cache
    with mock.patch.multiple(gc, **dict.fromkeys(kept, mock.DEFAULT)):
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
