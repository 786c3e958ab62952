"""Recording the stream of a drive in any state; nothing is enabled."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any

from benchtool.bench import Session
from benchtool.drive import Capability, Identity
from benchtool.drive.parameters import snapshot
from benchtool.errors import LinkClosed, NoAnswer
from benchtool.recording import BundleWriter, Conditions, Event, Manifest, software_versions
from benchtool.run.failure import fail_bundle
from benchtool.telemetry import (
    DEFAULT_CHANNELS,
    Certificate,
    FrameLog,
    Sink,
    TelemetryStream,
    certify_recording,
    keep_journal,
    record_stream,
)

_STEP_S = 0.05
_SHOW_S = 0.25
_ROUNDING_S = 1e-9


@dataclass(frozen=True)
class Recording:
    """Settings of a recording.

    Attributes:
        channels: signals of the stream.
        rate_Hz: records per second.
        duration_s: drive time; None records until it is ended by hand.
        reconnect_s: time to wait for a lost link; 0 ends the recording.
        frames: logs every frame as well.
    """

    channels: Sequence[str]
    rate_Hz: float
    duration_s: float | None
    reconnect_s: float = 0.0
    frames: FrameLog | None = None


@dataclass(frozen=True)
class Status:
    """How far a recording is: drive time, rows received and missing until now, and the last row."""

    past_s: float
    duration_s: float | None
    rows: int
    missing_rows: int
    last: Mapping[str, float]


@dataclass(frozen=True)
class Ended:
    """What came of a recording, and whether it was ended by hand before its time."""

    certificate: Certificate
    past_s: float
    by_hand: bool

    def to_json(self) -> dict[str, Any]:
        """As the manifest and the JSON document have it."""
        return {"ended_by": "hand" if self.by_hand else "duration", "lasted_s": self.past_s}


def manifest_of(
    session: Session,
    identity: Identity,
    *,
    what: str,
    when: str,
    wall_s: float,
    note: str,
    conditions: Conditions,
    seed: int,
    link: str,
    command_line: tuple[str, ...],
    details: Mapping[str, Any],
) -> Manifest:
    """Return the manifest of a recording that begins now, at `wall_s` of wall time, `when` in ISO 8601.

    `details` are specific to this recording, `what` describes it.
    """
    drive = session.drive
    return Manifest(
        what=what,
        when=when,
        profile_name=session.profile_name,
        profile_toml=session.profile_toml,
        link=link,
        identity={key: value for key, value in asdict(identity).items() if value is not None},
        dictionary_hash=identity.dictionary_hash,
        parameters=snapshot(drive),
        versions=software_versions(),
        seed=seed,
        command_line=command_line,
        note=note,
        conditions=conditions,
        details={**details, "wall": drive.clock_anchor(wall_s)},
    )


def prepared(
    session: Session,
    channels: Sequence[str],
    rate_Hz: float,
    *,
    when: datetime,
    link: str,
    seed: int = 0,
    note: str = "",
    conditions: Conditions | None = None,
    command_line: tuple[str, ...] = (),
) -> tuple[tuple[str, ...], Manifest]:
    """Return channels of a recording that begins now, and its manifest; what cannot be streamed is refused.

    Args:
        channels: signals; those of `DEFAULT_CHANNELS` that fit without any.
        rate_Hz: records per second.
        when: wall time.

    Raises:
        CapabilityMissing, ValueRefused: the drive cannot stream this; nothing was sent.
        NoAnswer, IdentityMismatch, DictionaryMismatch: it is not the drive of the profile.
    """
    drive = session.drive
    drive.capabilities.require(Capability.STREAM, purpose="a recording")
    process_data = drive.link.process_data
    names = tuple(channels) or process_data.fitting(drive.dictionary, DEFAULT_CHANNELS)
    process_data.source(drive, names, rate_Hz)
    return names, manifest_of(
        session,
        drive.check(),
        what="record",
        when=when.isoformat(timespec="seconds"),
        wall_s=time.time(),
        note=note,
        conditions=conditions or Conditions(),
        seed=seed,
        link=link,
        command_line=command_line,
        details={"state": drive.state().value},
    )


def record(
    session: Session,
    bundle: BundleWriter,
    recording: Recording,
    note: Callable[[str], None],
    sinks: Sequence[Sink] = (),
    takers: Sequence[Callable[[Event], None]] = (),
    *,
    show: Callable[[Status], None] = lambda _: None,
    is_ended: Callable[[], bool] = lambda: False,
) -> Ended:
    """Record, and leave a bundle that states how the recording ended.

    Args:
        note: takes what happened, a line each.
        sinks: get the blocks as they come.
        takers: get the events.
        show: takes how far it is, a few times in a second.
        is_ended: whether a person has asked for the end, which leaves a complete bundle.

    Raises:
        LinkClosed: the link was lost and not restored within `reconnect_s`.
        RecordingError: a file cannot be written.
    """
    stream: TelemetryStream | None = None
    drive, log = session.drive, recording.frames
    try:
        if log is not None:
            log.start(bundle.directory)
        with (
            keep_journal(drive, takers),
            record_stream(drive, bundle, recording.channels, recording.rate_Hz, others=sinks) as stream,
        ):
            past_s = _wait(session, stream, recording, note, show, is_ended)
        if log is not None:
            log.close()
    except BaseException as failure:
        close = () if log is None else (log.close,)
        fail_bundle(bundle, failure, stream, drive.link.counters, close=close)
        failure.add_note(f"what came until then is in {bundle.directory}")
        raise
    certificate, details = certify_recording(stream, {}, drive.link.counters)
    by_hand = recording.duration_s is None or past_s < recording.duration_s - _ROUNDING_S
    ended = Ended(certificate, past_s, by_hand)
    bundle.finish(
        quality=asdict(drive.link.counters),
        details=details | ended.to_json(),
        certificate=certificate.to_json(),
    )
    return ended


def _wait(
    session: Session,
    stream: TelemetryStream,
    recording: Recording,
    note: Callable[[str], None],
    show: Callable[[Status], None],
    is_ended: Callable[[], bool],
) -> float:
    """Return the wait for the end; the drive time until then."""
    clock, drive = session.drive.clock, session.drive
    reconnect_s = recording.reconnect_s
    duration_s = math.inf if recording.duration_s is None else recording.duration_s
    start_s = clock.now_s()
    shown_s = 0.0
    while (left_s := start_s + duration_s - clock.now_s()) > _ROUNDING_S and not is_ended():
        try:
            with suppress(NoAnswer):  # the stream detects whether the drive is still there
                drive.poll()
            clock.wait(min(_STEP_S, left_s))
            stream.check()
            for emergency in drive.emergencies():
                note(f"the drive reports {emergency.text}")
        except LinkClosed as lost:
            if not reconnect_s:
                raise
            note(f"{lost}; waiting for it for {reconnect_s:g} s")
            drive.reconnect(reconnect_s)
            stream.resume()
        if recording.frames is not None:
            recording.frames.check()
        if (past_s := clock.now_s() - start_s) >= shown_s + _SHOW_S - _ROUNDING_S:
            shown_s += _SHOW_S
            show(_status(stream, past_s, recording.duration_s))
    return clock.now_s() - start_s


def _status(stream: TelemetryStream, past_s: float, duration_s: float | None) -> Status:
    report = stream.report()
    missing = sum(gap.missing_rows for gap in report.gaps)
    return Status(past_s, duration_s, report.counters.received, missing, report.last)
