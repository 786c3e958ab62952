"""The options of `benchtool analyze --csv`, held against one another, as a question on the table."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from benchtool.errors import RecordingError, UsageError
from benchtool.profile import load_bench
from benchtool.tables import PHASES, TableQuestion, TextTable, quantity


@dataclass(frozen=True)
class TableOptions:
    """What the command line states of a table, as it is written there."""

    time: str | None = None
    rate: float | None = None
    currents: tuple[str, ...] = ()
    torque: str | None = None
    angle: str | None = None
    speed: str | None = None
    ac: bool = False
    pole_pairs: int | None = None
    slots: int | None = None
    rated_torque: float | None = None
    bench: str | None = None
    decimal: str | None = None
    recorded_on: date | None = None

    def question(
        self, file: Path, from_: float | None, to: float | None, analyses: Mapping[str, Mapping[str, Any]]
    ) -> TableQuestion:
        """Return the question on a table, between times in s of its own axis, with `analyses` beside.

        Raises:
            UsageError: an option that is missing, or that says nothing without another one.
        """
        if self.decimal not in (None, ".", ","):
            raise UsageError(f"--decimal is '{self.decimal}', one of . and , is expected")
        _require_time(file, self.time, self.rate, self.decimal or "")
        if not (self.currents or self.torque or self._speed_column or analyses):
            missing = "--current, --torque and --speed"
            raise UsageError(
                f"--csv without {missing}: name the column of a current, torque or speed"
                f"{_columns_of(file, self.decimal or '')}"
            )
        self._require_what_others_need()
        if from_ is not None and to is not None and from_ > to:
            raise UsageError(f"--from {from_:g} is after --to {to:g}: give the earlier first")
        if len(self.currents) not in (0, 1, len(PHASES)):
            raise UsageError(
                f"--current is given {len(self.currents)} times: give it once, for a current by itself, or "
                f"three times, for phases a, b and c; where two were recorded of a motor without a neutral "
                f"conductor, the third is -(a + b): add it to the table as a column"
            )
        others = {"torque": self.torque, "angle": self.angle, "speed": self._speed_column}
        phases = dict(zip(PHASES, self.currents, strict=False))
        return TableQuestion(
            file=file,
            time=self.time,
            columns=phases | {what: name for what, name in others.items() if name is not None},
            pole_pairs=self.pole_pairs,
            slots=self.slots,
            is_of_phase=self.ac or len(self.currents) == len(PHASES),
            torque_rated_Nm=self.rated_torque,
            from_s=-math.inf if from_ is None else from_,
            to_s=math.inf if to is None else to,
            rate_Hz=self.rate,
            omega_m_rad_s=None if self.angle is not None else self._omega_m_rad_s,
            **_stated_sensors(self.bench),
            recorded_on=self.recorded_on,
            decimal=self.decimal or "",
            analyses=analyses,
        )

    @property
    def _omega_m_rad_s(self) -> float | None:
        """The constant speed that --speed states, with its unit; None where it names a column, or nothing."""
        return None if self.speed is None else quantity(self.speed, "rad/s")

    @property
    def _speed_column(self) -> str | None:
        return self.speed if self._omega_m_rad_s is None else None

    def _require_what_others_need(self) -> None:
        """Raise UsageError where an option says nothing without another one, or states what cannot be."""
        rated_Nm = self.rated_torque
        if rated_Nm is not None and not (math.isfinite(rated_Nm) and rated_Nm > 0.0):
            raise UsageError(f"--rated-torque is {rated_Nm:g}, a torque above zero in Nm is expected")
        has_angle, speed = self.angle is not None or self._omega_m_rad_s is not None, self._speed_column
        # what begins like a number may be meant as a constant speed, and is told how that is written
        has_speed = speed is not None and (bool(self.currents) or bool(re.match(r"[+-]?\.?[0-9]", speed)))
        by_pairs = "--angle, a stated speed (--speed 1500rpm), or a current beside the speed"
        for option, is_alone, without in (
            ("--pole-pairs", self.pole_pairs is not None and not (has_angle or has_speed), by_pairs),
            ("--slots", self.slots is not None and not has_angle, "--angle"),
            ("--ac", self.ac and not self.currents, "--current"),
            ("--rated-torque", rated_Nm is not None and self.torque is None, "--torque"),
        ):
            if is_alone:
                raise UsageError(f"{option} without {without}: name that column too, or leave {option} out")


def _stated_sensors(bench: str | None) -> dict[str, Any]:
    """Return `[bench]` of a file, and what else it may state than columns."""
    if bench is None:
        return {}
    from benchtool.protocol.dictionary import sensed_units_of  # which needs the drive's dictionary

    return {"bench": load_bench(bench), "signals": sensed_units_of(bench)}


def _columns_of(csv: Path, decimal: str) -> str:
    """Return the columns to choose from, or nothing where the table cannot be read."""
    try:
        return f" ({TextTable.open(csv, decimal, timed=False).listed})"
    except RecordingError:
        return ""


def _require_time(csv: Path, time: str | None, rate: float | None, decimal: str) -> None:
    """Refuse a table without a time or a rate, or with both.

    Raises:
        UsageError: one of the two is expected.
    """
    if time is None and rate is None:
        raise UsageError(
            f"--csv without --time: name the column of the time, or state --rate in Hz"
            f"{_columns_of(csv, decimal)}"
        )
    if time is not None and rate is not None:
        raise UsageError(f"both --time {time} and --rate {rate:g} for {csv}: give one of the two")
    if rate is not None and not (math.isfinite(rate) and rate > 0.0):
        raise UsageError(f"--rate is {rate:g}, rows per second above zero are expected")
