"""Calibration of the instruments of a recording on its day."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import Any

from pydantic import ValidationError

from benchtool.analysis import count_of
from benchtool.errors import AnalysisError
from benchtool.misfits import explain
from benchtool.profile import Bench, Instrument, Profile, bench_of
from benchtool.recording import Manifest

CLOCK = "the drive's clock"


@dataclass(frozen=True)
class Overdue:
    """An instrument that was used after its calibration was due."""

    channel: str
    instrument: Instrument
    on: date

    def __str__(self) -> str:
        due = self.instrument.due
        assert due is not None
        label = f" ({self.instrument.label})" if self.instrument.label else ""
        days = (self.on - due).days
        late = count_of(days, "day")
        return f"calibration of {self.channel}{label} was due on {due}, {late} before this run"

    def to_json(self) -> dict[str, Any]:
        """Return the channel, the instrument and both days in words."""
        one = self.instrument
        return {
            "channel": self.channel,
            "sensor": one.sensor,
            "serial_number": one.serial_number,
            "certificate": one.certificate,
            "due": str(one.due),
            "on": str(self.on),
        }


@dataclass(frozen=True)
class Calibration:
    """The bench of a recording and the day on which it was made, None if that is not known."""

    bench: Bench = field(default_factory=Bench)
    on: date | None = None

    @classmethod
    def at(cls, bench: Bench, when: str) -> Calibration:
        """Return the calibration on the day of a wall time as a manifest has it."""
        try:
            return cls(bench, date.fromisoformat(when[:10]))
        except ValueError:
            return cls(bench)

    @classmethod
    def of(cls, manifest: Manifest) -> Calibration:
        """Return the calibration of the profile in a bundle; empty without a profile.

        Raises:
            AnalysisError: this version does not understand its section [bench].
        """
        try:
            content = tomllib.loads(manifest.profile_toml)
        except (ValueError, RecursionError):
            return cls()
        try:
            return cls.at(bench_of(content), manifest.when)
        except ValidationError as failed:
            raise AnalysisError(
                f"the sensors of the profile that the bundle carries cannot be read: "
                f"{explain(Profile, failed)}; use the benchtool that recorded it"
            ) from None

    def overdue(self, channels: Iterable[str]) -> tuple[Overdue, ...]:
        """Return the instruments of these channels, and the clock, whose calibration was due before."""
        return () if self.on is None else tuple(self._overdue(self.on, frozenset(channels)))

    def _overdue(self, on: date, channels: frozenset[str]) -> Iterator[Overdue]:
        for channel, sensor in self.bench.channels.items():
            if channel in channels and sensor.overdue(on):
                yield Overdue(channel, sensor, on)
        if self.bench.clock is not None and self.bench.clock.overdue(on):
            yield Overdue(CLOCK, self.bench.clock, on)


def overdue_text(overdue: Sequence[Overdue]) -> str:
    """Return half a sentence that names the channels; empty without any."""
    if not overdue:
        return ""
    return f"calibration overdue: {', '.join(dict.fromkeys(each.channel for each in overdue))}"


def stated_overdue(overdue: Sequence[Overdue]) -> dict[str, list[dict[str, Any]]]:
    """`overdue` of a JSON document; nothing where no instrument is."""
    found = list(dict.fromkeys(overdue))
    return {"overdue": [each.to_json() for each in found]} if found else {}
