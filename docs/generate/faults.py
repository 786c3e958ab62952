"""The page of faults: the table of the emulator, and what `benchmarks.faults` has measured."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from benchtool.emulator.faults import FAULTS, Kind, Outcome

MEASURED = Path(__file__).parents[2] / "benchmarks" / "faults" / "measured.json"

_HEAD = """# Faults, and what becomes of them

`benchtool emulate --fault NAME[:key=value,...][@SECONDS]` has an emulated drive fail, `faults = ["..."]` of a
[plan](reference/plan.md) the bench that it runs on, `session.faults.inject("...")` that of a test. This page
is generated from the emulator's table and from the figures of `python -m benchmarks.faults --write`.

## The faults
"""

_MEASURED = """
## What was measured

The machine of the paper runs at 50 rad/s against 2 Nm of friction, the host's supervision of the link is set
to 100 ms, the profile has limits of torque, speed, sum and unbalance of the currents. Each fault begins in a
random tick. The columns:

- **torque ends**: median, 95th percentile and maximum of the time until the true air-gap torque stays below
  5 % of the rated one, in ticks of the drive; of a lost link from the last valid command on, of others from
  the fault on.
- **named**: how long until the host said what happened, at most, in drive time. A host that asks a silent
  drive also waits for an answer, half a second of wall time, twice.
- **held**: trials of those made in which all of this held. The torque ended in the time of the column before
  and did not come back. The host's words named the fault. Every record of the stream is the one that the
  drive sent in that tick, or counted as missing. The next session connected and ran without a power cycle.
  The drive was enabled once by each session. Threads and open files of the process were as before.

Of faults that the work survives, a trial holds if it went on, or ended with an answer that was lost and said
so.

| fault | wire | torque ends, ms | at most, ms | named, s | held |
|---|---|---|---|---|---|
"""

_TAIL = """
What the figures are not: no adapter, operating system or real drive took part, time on the wire is not
modelled, and a drive's firmware reacts as its maker wrote it. Of {losses} lost links {in_time} ended in time;
299 without a failure are a share of at least 99 % with a confidence of 95 %.

What only a host can notice needs `[limits]` of the [profile](reference/profile.md), and half a second. A
wrong parameter is not noticed while the drive runs: the check before the next run names it. The time until
the torque ends of a fault of the plant may contain what no switch can end: a shaft that turns faster than its
dc link allows brakes through the diodes.
"""


def page() -> str:
    """Return the page; without figures where none were kept."""
    rows = json.loads(MEASURED.read_text(encoding="utf-8"))["faults"] if MEASURED.is_file() else []
    losses = [row for row in rows if row["fault"] in ("host_killed", "cable_pulled")]
    return (
        _HEAD
        + "\n".join(line for kind in FAULTS.values() for line in _described(kind))
        + "\n"
        + _MEASURED
        + "\n".join(_row(row) for row in rows)
        + "\n"
        + _TAIL.format(losses=sum(row["n"] for row in losses), in_time=sum(row["in_time"] for row in losses))
    )


def _described(kind: Kind) -> Iterator[str]:
    yield f"\n### `{kind.name}`\n"
    outcomes = {
        Outcome.STOPS: "The drive stops.",
        Outcome.ENDED: "The drive does not notice; the host disables it.",
        Outcome.GOES_ON: "The work goes on.",
    }
    where = " CAN only." if kind.can_only else ""
    yield f"{kind.does} {outcomes[kind.outcome]}{where} Told by: {kind.named}.\n"
    if kind.parameters:
        yield "| parameter | default | unit | meaning |\n|---|---|---|---|"
    for each in kind.parameters:
        value = each.default if isinstance(each.default, str) else f"{each.default:g}"
        yield f"| `{each.name}` | {value} | {each.unit} | {each.meaning} |"


def _row(row: Mapping[str, Any]) -> str:
    stopped = "-" if row["stopped_ms"] is None else " / ".join(f"{each:.1f}" for each in row["stopped_ms"])
    limit = "-" if row["limit_ms"] is None else f"{row['limit_ms']:g}"
    named = "-" if row["named_ms"] is None else f"{row['named_ms'] * 1e-3:.2f}"
    checks = ("in_time", "latched", "named", "recorded", "next_session", "once", "tidy")
    held = min(row[name] for name in checks)
    return f"| `{row['fault']}` | {row['wire']} | {stopped} | {limit} | {named} | {held} of {row['n']} |"
