"""The page of what a commissioning comes to: `python -m docs.generate.commissioning CAMPAIGN.json`.

The campaign is what `python -m benchmarks.commissioning --json` prints: for each estimate how often it
was told, within its tolerance, and how its stated uncertainty held; for each motor, where it has them,
the largest deviations in shares of the tolerances.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

PAGE: Final = Path(__file__).parents[1] / "commissioning.md"
_HEAD: Final = """\
# Commissioning of the motors that ship

What `benchtool commission` finds on emulated motors whose nameplate and sensors are off at random, and whose
truth it does not see. Generated from `python -m benchmarks.commissioning --json`.
"""
_FIGURES: Final = {
    "series": "series of draws",
    "seed": "seed of the draws",
    "runs": "motors commissioned",
    "estimates": "estimates with an uncertainty",
    "z_rms": "deviation over standard uncertainty, rms",
    "within_2u_percent": "within two standard uncertainties, %",
    "largest_z": "largest deviation over standard uncertainty",
    "longest_drive_s": "longest drive time, s",
}


def page(campaign: Mapping[str, Any]) -> str:
    """Return the page of a campaign."""
    parts = [_HEAD, _table(("figure", "value"), _of_figures(campaign))]
    lines = [(name, text) for name, text in campaign.items() if isinstance(text, str) and "told" in text]
    if lines:
        parts.append(
            _table(("estimate", "deviation in shares of its tolerance, and stated uncertainty"), lines)
        )
    motors = campaign.get("motors")
    if isinstance(motors, dict) and motors:
        names = list(dict.fromkeys(name for each in motors.values() for name in each))
        rows = [(motor, *(_share(each.get(name)) for name in names)) for motor, each in motors.items()]
        parts.append("Largest deviation of each motor, in shares of the tolerance:\n")
        parts.append(_table(("motor", *names), rows))
    return "\n".join(parts)


def _of_figures(campaign: Mapping[str, Any]) -> list[tuple[str, ...]]:
    return [(said, _shown(campaign[key])) for key, said in _FIGURES.items() if key in campaign]


def _shown(figure: str | float) -> str:
    return figure if isinstance(figure, str) else f"{figure:.15g}"


def _share(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join(f"| {' | '.join(each)} |" for each in lines) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page; the process's exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m docs.generate.commissioning", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("campaign", type=Path)
    parser.add_argument("--page", type=Path, default=PAGE)
    asked = parser.parse_args(arguments)
    campaign = json.loads(asked.campaign.read_text(encoding="utf-8"))
    asked.page.write_text(page(campaign), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
