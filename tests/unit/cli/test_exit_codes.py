"""The end of the process of the command line."""

from __future__ import annotations

import subprocess
import sys

import pytest

_PROGRAM = """
import atexit, sys
{before}
from benchtool.cli.exit_codes import end_quickly

class Taken:
    def __del__(self):
        print("taken apart")

kept = Taken()

def main():
    atexit.register(print, "registered by the command")
    print("done")
    {end}

end_quickly(main)
"""


@pytest.mark.parametrize(
    ("before", "end", "code", "last"),
    [
        ("", "raise SystemExit(3)", 3, []),
        ("", "raise SystemExit", 0, []),
        ("", "raise SystemExit('a message')", 1, ["taken apart"]),
        ("", "raise ValueError('a defect')", 1, ["taken apart"]),
        ("atexit.register(print, 'coverage')", "raise SystemExit(3)", 3, ["coverage", "taken apart"]),
    ],
    ids=["failed", "passed", "message", "defect", "measured"],
)
def test_the_process_ends_after_what_was_registered(
    before: str, end: str, code: int, last: list[str]
) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", _PROGRAM.format(before=before, end=end)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == code
    assert ended.stdout.splitlines() == ["done", "registered by the command", *last]
    assert ("a message" in ended.stderr, "ValueError: a defect" in ended.stderr) == (
        "message" in end,
        "defect" in end,
    )
