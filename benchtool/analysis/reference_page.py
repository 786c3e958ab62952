"""Fill the tables of docs/reference/measurements.md from the catalogue; the text between is written by hand.

python -m benchtool.analysis.reference_page            fill them
python -m benchtool.analysis.reference_page --check    write nothing; exit 1 if the page is stale

A table stands between `<!-- analyses: NAME NAME -->` and `<!-- end -->`. What no such line names stands where
`<!-- analyses: others -->` does, and `<!-- catalogue -->` has the list of all. The same catalogue gives the
same page.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from benchtool.analysis.catalogue import BUILT_IN
from benchtool.analysis.declaration import Analysis, Quantity
from benchtool.errors import UsageError

PAGE: Final = Path(__file__).resolve().parents[2] / "docs" / "reference" / "measurements.md"

_OTHERS: Final = "others"
_TABLE: Final = re.compile(r"(<!-- (catalogue|analyses: ([\w ]+)) -->\n)(.*?)(<!-- end -->)", re.DOTALL)


def filled(page: str, analyses: Sequence[Analysis[Any]] = BUILT_IN) -> str:
    """Return the page with every table as the catalogue has it.

    Raises:
        UsageError: a table names an analysis that there is not, or one stands in two.
    """
    by_name = {each.name: each for each in analyses}
    named = [name for found in _TABLE.finditer(page) for name in (found[3] or "").split() if name != _OTHERS]
    if odd := sorted(name for name in {*named} if name not in by_name or named.count(name) > 1):
        raise UsageError(
            f"{', '.join(odd)}: each analysis of the catalogue is expected in one table of the page: take it "
            f"out of a line '<!-- analyses: ... -->'"
        )

    def table(found: re.Match[str]) -> str:
        if found[3] is None:
            lines = _kinds(analyses)
        elif found[3] == _OTHERS:
            lines = _others([each for each in analyses if each.name not in named])
        else:
            lines = _measurements([by_name[name] for name in found[3].split()])
        return found[1] + "".join(f"{line}\n" for line in lines) + found[5]

    return _TABLE.sub(table, page)


def main(arguments: Sequence[str] | None = None, page: Path = PAGE) -> int:
    """Fill or check the page; the process's exit code."""
    parser = argparse.ArgumentParser(prog="python -m benchtool.analysis.reference_page", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing, exit 1 if the page is stale")
    check = parser.parse_args(arguments).check
    text = page.read_text(encoding="utf-8")
    fresh = filled(text)
    if fresh == text:
        return 0
    if check:
        sys.stderr.write(f"{page.name} is stale: run python -m benchtool.analysis.reference_page\n")
        return 1
    page.write_text(fresh, encoding="utf-8")
    return 0


def _kinds(analyses: Sequence[Analysis[Any]]) -> Iterator[str]:
    yield from ("| key | what it measures | made | needs | figures |", "|---|---|---|---|---|")
    for each in analyses:
        settings = each.settings().model_dump(mode="json")
        asked = not each.of_steady_state
        made = "`= true`, or a table" if asked else "in steady state"
        if settings:
            made += ": " + ", ".join(f"`{key} = {json.dumps(value)}`" for key, value in settings.items())
        defaults = each.settings()
        named = (f"the channel `{key}`" for key in each.channel_settings if getattr(defaults, key))
        needs = ", ".join((*(f"`{name}`" for name in each.channels), *named, *each.conditions))
        figures = dict.fromkeys(f"`{one.name}`" for one in (*each.figures, *each.comparisons))
        yield f"| `{each.name}` | {each.title} | {made} | {needs} | {', '.join(figures)} |"


def _others(analyses: Sequence[Analysis[Any]]) -> Iterator[str]:
    """Yield each with its title, since nothing is written about it."""
    for each in analyses:
        yield from ("", f"**{each.title.capitalize()}** (`{each.name}`)", "", *_measurements([each]), "")


def _measurements(analyses: Sequence[Analysis[Any]]) -> Iterator[str]:
    """Yield a row for each quantity; those of one unit, definition and uncertainty share it."""
    rows: dict[tuple[str, str, str], list[str]] = {}
    for quantity in (quantity for each in analyses for quantity in each.quantities):
        rows.setdefault(_cells(quantity), []).extend(quantity.names)
    uncertain = any(uncertainty for _, _, uncertainty in rows)
    headings = ("measurement", "unit", "formula", *(("uncertainty (standard)",) if uncertain else ()))
    yield f"| {' | '.join(headings)} |"
    yield "|" + "---|" * len(headings)
    for cells, names in rows.items():
        shown = cells if uncertain else cells[:2]
        yield f"| {', '.join(f'`{name}`' for name in names)} | {' | '.join(shown)} |"


def _cells(quantity: Quantity) -> tuple[str, str, str]:
    unit, definition, uncertainty = (
        text.replace("|", "\\|") for text in (str(quantity.unit), quantity.definition, quantity.uncertainty)
    )
    return unit, definition, uncertainty


if __name__ == "__main__":
    sys.exit(main())
