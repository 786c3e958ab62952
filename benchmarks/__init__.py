"""Measurements of speed; each module runs with `python -m` and prints JSON with `--json`."""

import os

# As in the command line, before numpy is imported: further threads of linear algebra wait for each other.
os.environ.setdefault("OMP_NUM_THREADS", "1")
