"""Whether pictures can be drawn on this machine."""

from __future__ import annotations

import sys
from pathlib import Path

POSSIBLE = sys.platform == "linux" and any(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))
"""Whether there is lavapipe, which draws without a graphics card (Debian: mesa-vulkan-drivers)."""
