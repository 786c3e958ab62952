"""Measurements of speed; each module runs with `python -m` and prints JSON with `--json`."""
