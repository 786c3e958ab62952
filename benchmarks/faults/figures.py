"""Figures of all trials of one fault on one wire."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.faults.trial import NAMED_WITHIN_S, WATCHDOG_S, Outcomes
from benchtool.emulator.faults import FAULTS, Outcome

_HOST_S = 1.0  # for a host that stops what the drive does not notice


@dataclass(frozen=True)
class Figures:
    """How often what must hold held, of `n` trials; times in ms, None where there is nothing to time."""

    fault: str
    wire: str
    n: int
    stopped_ms: tuple[float, float, float] | None
    """Median, 95th percentile and maximum of the time to torque below 5 % of the rated one."""
    limit_ms: float | None
    in_time: int
    latched: int
    named: int
    named_ms: float | None
    recorded: int
    next_session: int
    once: int
    tidy: int
    said: str
    remarks: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether everything held in every trial."""
        counts = (self.in_time, self.latched, self.named, self.recorded, self.next_session, self.once)
        return all(each == self.n for each in (*counts, self.tidy))

    @property
    def line(self) -> str:
        """One line for a person."""
        stopped = "-" if self.stopped_ms is None else "/".join(f"{each:.1f}" for each in self.stopped_ms)
        return (
            f"{self.fault:20s} {self.wire:6s} n {self.n:3d} stop {stopped:18s} ms, in time {self.in_time}, "
            f"latched {self.latched}, named {self.named} ({self.named_ms} ms), recorded {self.recorded}, "
            f"next {self.next_session}, once {self.once}, tidy {self.tidy}"
            f"{''.join(f' | {each}' for each in self.remarks[:2])}"
        )

    def to_json(self) -> dict[str, Any]:
        """As a JSON document has it."""
        return asdict(self) | {"holds": self.holds}


def limit_s(name: str) -> float | None:
    """Return the time in which the torque must end; None of a fault that the work survives.

    What the drive notices: the time of the watchdog. What only the host can notice: a second.
    """
    kind = FAULTS[name]
    if kind.outcome is Outcome.GOES_ON:
        return None
    if kind.outcome is Outcome.ENDED:
        return _HOST_S
    return WATCHDOG_S


def summarise(name: str, wire: str, trials: Sequence[Outcomes]) -> Figures:
    """Return the figures of trials of one fault on one wire."""
    limit, kind, n = limit_s(name), FAULTS[name], len(trials)
    goes_on = kind.outcome is Outcome.GOES_ON
    times = [each.stopped_s for each in trials if each.stopped_s is not None]
    named = [each.named_s for each in trials if each.named_s is not None]
    said = Counter(each.said for each in trials if each.said).most_common(1)
    remarks = Counter(remark for each in trials for remark in each.remarks)
    return Figures(
        fault=name,
        wire=wire,
        n=n,
        stopped_ms=_spread(times) if times and not goes_on else None,
        limit_ms=None if limit is None else round(limit * 1e3, 1),
        in_time=n if limit is None else sum(each <= limit + 1e-9 for each in times),
        latched=n if goes_on else sum(bool(each.latched) for each in trials),
        named=sum(_fits(each) for each in trials)
        if goes_on
        else sum(each <= NAMED_WITHIN_S for each in named),
        named_ms=round(max(named) * 1e3, 1) if named and not goes_on else None,
        recorded=sum(each.recorded for each in trials),
        next_session=sum(each.next_session for each in trials),
        once=sum(each.once for each in trials),
        tidy=sum(each.tidy for each in trials),
        said=said[0][0] if said else "",
        remarks=tuple(f"{count} x {text}" for text, count in remarks.most_common(5)),
    )


def _fits(trial: Outcomes) -> bool:
    """Return whether work that is to go on did, or ended as it may; a wrong parameter is named."""
    if trial.fault == "wrong_parameter":
        return "psi_r" in trial.said
    return not any(each.startswith("ended") for each in trial.remarks)


def _spread(times_s: Sequence[float]) -> tuple[float, float, float]:
    ordered = np.asarray(times_s) * 1e3
    median, high = np.quantile(ordered, [0.5, 0.95])
    return round(float(median), 2), round(float(high), 2), round(float(ordered.max()), 2)
