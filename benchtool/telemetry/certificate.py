"""The data-quality certificate of a recording: numbers that a plan may limit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any, Final

from benchtool.analysis import Measurement, Uncertainty, measurements_to_json
from benchtool.block import Block, Gap
from benchtool.link import LinkCounters
from benchtool.protocol import COUNTING_SIGNALS, StreamCounters
from benchtool.telemetry.recorder import STREAM
from benchtool.telemetry.stream import StreamReport, TelemetryStream
from benchtool.ticks import TICKS

_COUNTED: Final = Uncertainty(0.0, "a count")


@dataclass(frozen=True)
class StreamFacts:
    """Facts of one stream: rows, gaps, and first and last value of its counters."""

    rows: int
    gaps: tuple[Gap, ...]
    counts: Mapping[str, tuple[float, float]]
    expected: int | None = None

    @classmethod
    def of(cls, block: Block, expected: int | None = None) -> StreamFacts:
        """Return the facts of a whole stream as one block; `expected` rows if the source provides their
        number."""
        counts = {
            name: (float(block.column(name)[0]), float(block.column(name)[-1]))
            for name in COUNTING_SIGNALS
            if name in block.names and len(block.data)
        }
        return cls(len(block.data), block.gaps, counts, expected)

    @classmethod
    def of_report(cls, report: StreamReport) -> StreamFacts:
        """Return the facts of the slow stream."""
        counts = {
            name: (report.first[name], report.last[name]) for name in COUNTING_SIGNALS if name in report.first
        }
        return cls(report.counters.received, report.gaps, counts, report.expected)


@dataclass(frozen=True)
class Certificate:
    """The data-quality certificate of a recording."""

    measurements: tuple[Measurement, ...]

    def value(self, name: str) -> float:
        """Return the value by name; nan where it is undefined. Raises KeyError for a name that is not
        certified."""
        return {each.name: each.value for each in self.measurements}[name]

    @property
    def complete(self) -> bool:
        """Whether every row of every stream is there."""
        return all(each.value == 0 for each in self.measurements if each.name.endswith("_rows_missing"))

    @property
    def summary(self) -> str:
        """Summary on one line: missing rows, saturated samples, clipped laws."""
        totals = {
            text: sum(each.value for each in self.measurements if each.name.endswith(ending))
            for ending, text in (("_rows_expected", "expected"), ("_rows_missing", "missing"))
        }
        found = [f"{totals['expected']:.0f} rows expected, {totals['missing']:.0f} missing"]
        for signal, text in (
            ("adc_saturated", "samples saturated"),
            ("law_clipped", "ticks clipped by the law"),
        ):
            # Streams overlap in time: use the largest count, as a sum would count twice.
            counts = [each.value for each in self.measurements if each.name.endswith(f"_{signal}_count")]
            if worst := max((count for count in counts if count > 0), default=0):
                found.append(f"{worst:.0f} {text}")
        return "data: " + ", ".join(found)

    def to_json(self) -> dict[str, Any]:
        """Return the document `certificate.json`: `value`, `unit` and `definition` by name."""
        return {"complete": self.complete, "measurements": measurements_to_json(self.measurements)}


def certify(
    streams: Mapping[str, StreamFacts], link: LinkCounters, report: StreamReport | None = None
) -> Certificate:
    """Return the certificate of a recording.

    Args:
        streams: by name; their names begin those of their measurements: `capture_rows_missing`.
        link: counters of the link at the end of the recording.
        report: of the slow stream, if there was one.
    """
    measurements = [each for name, facts in streams.items() for each in _stream(name, facts)]
    if report is not None:
        measurements += _slow_stream(report)
    for name, count in asdict(link).items():
        measurements.append(_count(f"link_{name}", count, "counter of the link since it was opened"))
    return Certificate(tuple(measurements))


def certify_recording(
    stream: TelemetryStream | None, blocks: Mapping[str, Block], link: LinkCounters
) -> tuple[Certificate, dict[str, Any]]:
    """Return certificate of what a run recorded, the slow stream among it, and what a manifest says of it."""
    facts = {name: StreamFacts.of(block) for name, block in blocks.items()}
    if stream is None:
        return certify(facts, link), {}
    report = stream.report()
    clock = None if report.clock is None else asdict(report.clock)
    stated = {"clock_fit": clock, "records": asdict(report.counters), "rate_Hz": 1.0 / stream.period_s}
    return certify(facts | {STREAM: StreamFacts.of_report(report)}, link, report), {STREAM: stated}


@cache
def certificate_units(*, stream: bool) -> Mapping[str, str]:
    """Return the units of what the certificate of a run measures, by name; `stream` tells whether the drive
    has a slow stream."""
    blocks = ("capture", STREAM) if stream else ("capture",)
    empty = StreamReport(None, None, StreamCounters(), (), {}, {}, 0, 0, 0, 0.0, 0.0, None)
    found = certify(
        {name: StreamFacts(0, (), {}) for name in blocks}, LinkCounters(), empty if stream else None
    )
    return {each.name: each.unit for each in found.measurements}


def _count(name: str, count: float, definition: str) -> Measurement:
    """Return what was counted, which has no uncertainty."""
    return Measurement(name, count, "", definition, uncertainty=_COUNTED)


def _stream(name: str, facts: StreamFacts) -> Iterator[Measurement]:
    inside = sum(gap.missing_rows for gap in facts.gaps)
    expected = facts.rows + inside if facts.expected is None else facts.expected
    source = "by the ticks of its rows" if facts.expected is None else "by the drive's own count"
    yield _count(f"{name}_rows_expected", expected, f"rows that {name} should have, {source}")
    yield _count(f"{name}_rows_received", facts.rows, f"rows that {name} has")
    yield _count(f"{name}_rows_missing", expected - facts.rows, "rows expected less rows received")
    yield _count(f"{name}_gaps", len(facts.gaps), "places between two rows where rows are missing")
    largest = max((gap.missing_rows for gap in facts.gaps), default=0)
    yield _count(f"{name}_gap_max", largest, "most rows missing in one place")
    for signal, text in COUNTING_SIGNALS.items():
        definition = f"{text}, last less first value of {signal} in {name}"
        if signal in facts.counts:
            first, last = facts.counts[signal]
            yield _count(f"{name}_{signal}_count", (last - first) % TICKS, definition)
        else:
            reason = f"{signal} is not recorded: record it too"
            yield Measurement.undefined(f"{name}_{signal}_count", "", definition, reason)


def _slow_stream(report: StreamReport) -> Iterator[Measurement]:
    counters = report.counters
    yield _count(
        "telemetry_records_lost",
        counters.lost,
        "sent by the drive, by sequence number, but not received whole",
    )
    dropped = "not sent by the drive, as its line was full"
    if report.drive_dropped is None:
        yield Measurement.undefined("telemetry_records_dropped", "", dropped, "the drive could not be asked")
    else:
        yield _count("telemetry_records_dropped", report.drive_dropped, dropped)
    yield _count("telemetry_records_incomplete", counters.incomplete, "begun, not ended")
    yield _count("telemetry_records_off_grid", counters.off_grid, "whole, with a tick that continues no row")
    yield _count("telemetry_pdos_malformed", counters.malformed, "PDOs or batches of a wrong length")
    yield _count("telemetry_frames_dropped", report.frames_dropped, "no room in the host's queue")
    yield _count("telemetry_rows_dropped", report.rows_dropped, "no room in a viewer's queue")
    yield _count("telemetry_resumptions", report.resumptions, "times the link was lost and came back")
    jitter = "time between two arrivals less drive time between their ticks"
    yield Measurement("arrival_jitter_rms", report.jitter_rms_s, "s", f"{jitter}, rms")
    yield Measurement("arrival_jitter_max", report.jitter_max_s, "s", f"{jitter}, largest magnitude")
    fit = "arrival on the host's clock against drive time, straight line by least squares"
    clock = report.clock
    values = (clock.drift_ppm, clock.residual_rms_s, clock.residual_max_s) if clock else (math.nan,) * 3
    missing = "" if clock else "fewer than three records"
    names = (
        ("clock_drift", "ppm", "slope less one"),
        ("clock_residual_rms", "s", "residual, rms"),
        ("clock_residual_max", "s", "residual, largest magnitude"),
    )
    for (name, unit, what), value in zip(names, values, strict=True):
        yield Measurement(name, value, unit, f"{fit}: {what}", reason=missing)
