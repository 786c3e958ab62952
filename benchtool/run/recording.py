"""Recording the stream of a drive, whatever it is doing: nothing is enabled."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from benchtool.bench.session import Session
from benchtool.drive import Identity
from benchtool.drive.parameters.transaction import snapshot
from benchtool.errors import LinkClosed, NoAnswer
from benchtool.recording import BundleWriter, Conditions, Event, Manifest, software_versions
from benchtool.run.failure import fail_bundle
from benchtool.telemetry import (
    Certificate,
    FrameLog,
    Sink,
    TelemetryStream,
    certify_recording,
    keep_journal,
    record_stream,
)

_STEP_S = 0.05
_TELL_S = 1.0
_ROUNDING_S = 1e-9


@dataclass(frozen=True)
class Recording:
    """What is recorded, and how.

    Attributes:
        channels: signals of the stream.
        rate_Hz: records per second.
        duration_s: drive time.
        reconnect_s: how long a link that is lost is waited for; 0 ends the recording.
        frames: keeps every frame too.
    """

    channels: Sequence[str]
    rate_Hz: float
    duration_s: float
    reconnect_s: float = 0.0
    frames: FrameLog | None = None


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
    """The manifest of a recording that begins now, at `wall_s` of wall time, `when` in ISO 8601.

    `details` are what only this recording has, `what` it is.
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
        details={**details, "wall": drive.wall_mark(wall_s)},
    )


def record(
    session: Session,
    bundle: BundleWriter,
    recording: Recording,
    note: Callable[[str], None],
    sinks: Sequence[Sink] = (),
    takers: Sequence[Callable[[Event], None]] = (),
) -> Certificate:
    """Record, and leave a bundle that says how it ended, whatever ends it.

    Args:
        note: takes a line of progress.
        sinks: get the blocks as they come.
        takers: get the events.

    Raises:
        LinkClosed: the link was lost and did not come back in `reconnect_s`.
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
            _wait(session, stream, recording, note)
        if log is not None:
            log.close()
    except BaseException as failure:
        close = () if log is None else (log.close,)
        fail_bundle(bundle, failure, stream, drive.link.counters, close=close)
        failure.add_note(f"what came until then is in {bundle.directory}")
        raise
    certificate, details = certify_recording(stream, {}, drive.link.counters)
    bundle.finish(quality=asdict(drive.link.counters), details=details, certificate=certificate.to_json())
    return certificate


def _wait(
    session: Session, stream: TelemetryStream, recording: Recording, note: Callable[[str], None]
) -> None:

    clock, drive = session.drive.clock, session.drive
    duration_s, reconnect_s = recording.duration_s, recording.reconnect_s
    start_s = clock.now_s()
    told_s = 0.0
    while (left_s := start_s + duration_s - clock.now_s()) > _ROUNDING_S:
        try:
            with suppress(NoAnswer):  # whether the drive is still there is the stream's to find
                drive.look()
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
        if (past_s := clock.now_s() - start_s) >= told_s + _TELL_S - _ROUNDING_S:
            told_s += _TELL_S
            note(f"{past_s:.0f} of {duration_s:g} s, {stream.report().counters.received} records")
