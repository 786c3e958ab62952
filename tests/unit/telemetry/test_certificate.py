"""The certificate: numbers by name, each with its definition, from what was recorded."""

from __future__ import annotations

import json
import math

import numpy as np
from hypothesis import given, strategies as st

from benchtool.block import Block, Channel, Gap
from benchtool.link import LinkCounters
from benchtool.protocol.telemetry import StreamCounters
from benchtool.telemetry import ClockFit, StreamFacts, StreamReport, certify

CHANNELS = (Channel("torque", "Nm"), Channel("adc_saturated", ""))


def report(*, expected: int | None, clock: ClockFit | None) -> StreamReport:
    counters = StreamCounters(received=90, missing=7, lost=5, incomplete=2, off_grid=1, malformed=3)
    return StreamReport(
        expected=expected,
        drive_dropped=None if expected is None else 2,
        counters=counters,
        gaps=(Gap(10, 3), Gap(40, 4)),
        first={"law_clipped": 4294967290.0},
        last={"law_clipped": 4.0},
        frames_dropped=6,
        rows_dropped=8,
        resumptions=0,
        jitter_rms_s=1e-4,
        jitter_max_s=3e-4,
        clock=clock,
    )


def test_a_whole_capture_is_complete() -> None:
    data = np.column_stack([np.zeros(5), [2.0, 2.0, 3.0, 9.0, 9.0]])
    certificate = certify({"capture": StreamFacts.of(Block(CHANNELS, 0, 1, 1e-4, data))}, LinkCounters())
    assert certificate.complete
    assert certificate.value("capture_rows_expected") == certificate.value("capture_rows_received") == 5
    assert certificate.value("capture_adc_saturated_count") == 7
    assert certificate.summary == "data: 5 rows expected, 0 missing, 7 samples saturated"
    assert math.isnan(certificate.value("capture_law_clipped_count"))


def test_gaps_are_counted_and_located_by_their_largest() -> None:
    block = Block(CHANNELS, 0, 1, 1e-4, np.zeros((5, 2)), (Gap(1, 2), Gap(3, 6)))
    certificate = certify({"capture": StreamFacts.of(block)}, LinkCounters(frames_dropped=2))
    assert not certificate.complete
    assert certificate.value("capture_rows_missing") == 8
    assert certificate.value("capture_gaps") == 2
    assert certificate.value("capture_gap_max") == 6
    assert certificate.value("link_frames_dropped") == 2


@given(
    st.integers(1, 50),
    st.lists(st.integers(1, 1000), max_size=8),
    st.integers(0, 20) | st.none(),
)
def test_missing_rows_are_what_was_expected_less_what_came(
    rows: int, lengths: list[int], beyond: int | None
) -> None:
    """`beyond`: rows that the drive says it sent, besides those that the gaps within tell."""
    gaps = tuple(Gap(row, missing) for row, missing in enumerate(lengths, start=1) if row < rows)
    inside = sum(gap.missing_rows for gap in gaps)
    expected = None if beyond is None else rows + inside + beyond
    facts = StreamFacts(rows, gaps, {}, expected)
    certificate = certify({"capture": facts}, LinkCounters())
    assert certificate.value("capture_rows_missing") == inside + (beyond or 0)
    assert certificate.value("capture_rows_expected") == rows + inside + (beyond or 0)
    assert certificate.complete == (inside + (beyond or 0) == 0)
    assert f"{inside + (beyond or 0)} missing" in certificate.summary


def test_a_counter_may_run_on_by_nearly_its_whole_range() -> None:
    counts = {"adc_saturated": (10.0, 10.0 + 3e9 - 2**32)}
    certificate = certify({"capture": StreamFacts(5, (), counts)}, LinkCounters())
    assert certificate.value("capture_adc_saturated_count") == 3e9


def test_the_slow_stream_is_measured_against_the_drives_own_count() -> None:
    clock = ClockFit(records=90, offset_s=1.0, drift_ppm=12.5, residual_rms_s=2e-4, residual_max_s=9e-4)
    stream = report(expected=100, clock=clock)
    certificate = certify({"telemetry": StreamFacts.of_report(stream)}, LinkCounters(), stream)
    values = {each.name: each.value for each in certificate.measurements}
    assert values["telemetry_rows_missing"] == 10, "seven within, and three at the ends"
    assert values["telemetry_gap_max"] == 4
    assert certificate.summary == "data: 100 rows expected, 10 missing, 10 ticks clipped by the law"
    assert values["telemetry_records_lost"] == 5
    assert values["telemetry_law_clipped_count"] == 10, "the counter wraps at 2**32"
    assert values["arrival_jitter_max"] == 3e-4
    assert values["clock_drift"] == 12.5
    assert values["clock_residual_max"] == 9e-4
    assert len(values) == len(certificate.measurements), "names are unique"
    assert {each.unit for each in certificate.measurements} == {"", "s", "ppm"}
    assert all(len(each.definition) > 5 for each in certificate.measurements)


def test_what_is_undefined_is_null_in_json() -> None:
    stream = report(expected=None, clock=None)
    certificate = certify({"telemetry": StreamFacts.of_report(stream)}, LinkCounters(), stream)
    document = json.loads(json.dumps(certificate.to_json(), allow_nan=False))
    assert document["complete"] is False
    assert document["measurements"]["clock_drift"]["value"] is None
    assert {each.unit for each in certificate.measurements} == {"", "s", "ppm"}
    assert "fewer than three records" in document["measurements"]["clock_drift"]["reason"]
    saturated = document["measurements"]["telemetry_adc_saturated_count"]
    assert (saturated["value"], saturated["unit"]) == (None, "")
    assert "adc_saturated is not recorded" in saturated["reason"]
    assert document["measurements"]["telemetry_rows_expected"]["value"] == 97
