"""Output of all benchmarks."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping


def print_figures(figures: Mapping[str, object], *, as_json: bool) -> None:
    """Print figures as one JSON object, or a line each; Python and machine are added."""
    known = {**figures, "python": platform.python_version(), "machine": platform.machine()}
    if as_json:
        print(json.dumps(known, indent=2))
        return
    for name, value in known.items():
        print(f"{name:36s} {value}")
