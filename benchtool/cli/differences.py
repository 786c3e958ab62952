"""What else runs differ in, in the terminal, before their numbers."""

from __future__ import annotations

from rich.text import Text

from benchtool.analysis import NOTHING, raw
from benchtool.cli.fitting import named
from benchtool.cli.output import Output
from benchtool.results import Differences, Kind

_MOST_RUNS = 3  # beside each other
_LONGEST = 36  # characters of a value; the whole is in the documents


def show_differences(output: Output, case: str, differences: Differences) -> None:
    """Print the circumstances in which runs differ, what is the same, and what cannot be compared."""
    title = f"{case}: what else differs" if case else "what else differs"
    letters = [chr(ord("A") + place) for place in range(len(differences.labels))][:_MOST_RUNS]
    rows: list[tuple[str | Text, ...]] = [
        (
            str(each.kind),
            each.key,
            *(_short(value) for value in list(each.values.values())[: len(letters)]),
        )
        for kind in Kind
        for each in differences.of_kind(kind)
    ]
    if rows:
        output.table(title, ("of", "what", *letters), rows)
        if more := len(differences.labels) - len(letters):
            output.line(f"of {more} more runs in --json and --html", "dim")
    if differences.same:
        output.sentence(f"the same in all runs: {', '.join(map(str, differences.same))}", "dim")
    for (label, reason), names in differences.reasons.items():
        output.sentence(f"not compared with {label}: {named(names)}: {reason}", "dim")


def _short(value: object) -> str:
    text = NOTHING if value is None else raw(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
