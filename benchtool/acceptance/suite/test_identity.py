"""Identity: the drive is the one of the profile, alive and on time."""

from __future__ import annotations

import pytest

from benchtool.acceptance import Attach, Measure
from benchtool.acceptance.suite.conditions import number, quiet, require_objects
from benchtool.api import Bench
from benchtool.bench import Session
from benchtool.protocol.dictionary import Role

pytestmark = pytest.mark.requirement("ACC-IDENTITY")


def test_identity(bench_session: Session, measure: Measure, attach: Attach) -> None:
    """The drive says who it is, and speaks the dictionary of the profile."""
    drive = bench_session.drive
    identity = drive.identify()
    expected = drive.dictionary.identity
    attach.text("identity.txt", "\n".join(f"{key}: {value}" for key, value in vars(identity).items()) + "\n")
    if expected.vendor_id is not None:
        measure("vendor_id", identity.vendor_id, min=expected.vendor_id, max=expected.vendor_id)
    if expected.product_code is not None:
        measure("product_code", identity.product_code, min=expected.product_code, max=expected.product_code)
    if drive.dictionary.hash is not None:
        expected_hash = drive.dictionary.hash
        measure("dictionary_hash", identity.dictionary_hash, min=expected_hash, max=expected_hash)
    measure("serial_number", identity.serial_number, min=1)
    told = [
        each for each in (identity.device_name, identity.hardware_version, identity.firmware_version) if each
    ]
    measure("texts_of_the_identity", len(told), min=3)


def test_periods(bench_session: Session, measure: Measure) -> None:
    """Control and PWM periods are those of the profile."""
    require_objects(bench_session, "control_period", "pwm_period")
    drive, profile = bench_session.drive, bench_session.profile
    T_s = profile.control_period_s
    measure("control_period", drive.number("control_period"), "s", min=T_s * (1 - 1e-5), max=T_s * (1 + 1e-5))
    T_pwm = (2.0 if profile.drive.double_update else 1.0) * T_s
    measure("pwm_period", drive.number("pwm_period"), "s", min=T_pwm * (1 - 1e-5), max=T_pwm * (1 + 1e-5))


def test_heartbeat(bench_session: Session, measure: Measure) -> None:
    """The drive's heartbeat comes with its period."""
    drive = bench_session.drive
    if Role.PRODUCER_HEARTBEAT not in drive.dictionary:
        pytest.skip("the drive's dictionary has no heartbeat of its own")
    period_s = drive.number(Role.PRODUCER_HEARTBEAT)
    if not period_s:
        pytest.skip("the drive's heartbeat is off")
    quiet(bench_session, period_s)
    before = drive.link.counters.heartbeats_received
    quiet(bench_session, 20.0 * period_s)
    measure("heartbeats_in_20_periods", drive.link.counters.heartbeats_received - before, min=19, max=21)


def test_time_base(bench_session: Session, measure: Measure) -> None:
    """The drive's tick runs as fast as its control period says."""
    require_objects(bench_session, "tick", "control_period")
    drive, clock = bench_session.drive, bench_session.clock
    quiet(bench_session, 0.01)
    began_s, first = clock.now_s(), drive.number("tick")
    quiet(bench_session, 1.0)
    past_s = clock.now_s() - began_s
    told_s = (drive.number("tick") - first) % 2**32 * drive.number("control_period")
    measure("tick_rate_error", told_s / past_s - 1.0, "", min=-0.01, max=0.01)


def test_stream(bench: Bench, measure: Measure) -> None:
    """The drive streams every record, numbered without a gap, at the times it says."""
    require_stream(bench)
    block = bench.drive.record(1.0, ("omega_m", "u_dc"), rate_Hz=100.0)
    measure("stream_rows", len(block.data), min=95, max=105)
    measure("stream_rows_missing", sum(gap.missing_rows for gap in block.gaps), max=0)


def test_nothing_is_dropped(bench_session: Session, measure: Measure) -> None:
    """Two hundred reads are answered, none is repeated, and the drive drops no frame."""
    drive = bench_session.drive
    for _ in range(200):
        drive.number(Role.STATUSWORD)
    counters = drive.link.counters
    measure("reads_repeated", counters.retries, max=0)
    measure("frames_dropped", counters.frames_dropped + counters.receive_errors, max=0)
    measure("adc_saturated", number(bench_session, "adc_saturated", 0.0), max=0)


def require_stream(bench: Bench) -> None:
    """Skip the test on a drive without a stream."""
    from benchtool.drive import Capability

    if Capability.STREAM not in bench.drive.capabilities:
        pytest.skip("the drive has no stream of signals")
