"""How well the shipped suite finds faults: the measured score, and the hash of the suite it belongs to."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Final

from benchtool.results import SuiteScore

SUITE: Final = Path(__file__).parent / "suite"
"""Folder of the tests that ship."""

SCORE: Final = SUITE.parent / "score.json"
"""What `benchtool acceptance --mutants` has measured of them."""


def suite_hash() -> str:
    """Return the first 16 digits of SHA-256 over the files of the suite."""
    digest = hashlib.sha256()
    for path in sorted(SUITE.glob("*.py")):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def shipped_score() -> SuiteScore | None:
    """Return the score that ships; None without one."""
    if not SCORE.is_file():
        return None
    return SuiteScore.model_validate_json(SCORE.read_text(encoding="utf-8"))
