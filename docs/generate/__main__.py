"""Write the generated pages: the reference from models and command line, the faults, the index of decisions.

python -m docs.generate            write them
python -m docs.generate --check    write nothing; exit 1 if a page is stale

`python -m benchtool.analysis.reference_page` fills the tables of docs/reference/measurements.md, and
`python -m firmware_protocol.generate` makes the object dictionary.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from docs.generate import pages

DOCS = Path(__file__).parents[1]


def main(arguments: Sequence[str] | None = None, folder: Path = DOCS) -> int:
    """Write or check the pages; the process's exit code."""
    parser = argparse.ArgumentParser(prog="python -m docs.generate", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing, exit 1 if a page is stale")
    check = parser.parse_args(arguments).check
    stale = []
    for name, text in pages.all_pages().items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            stale.append(name)
            if not check:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
    if check and stale:
        sys.stderr.write(f"{', '.join(stale)}: stale, run python -m docs.generate\n")
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
