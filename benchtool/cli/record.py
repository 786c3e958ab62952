"""`benchtool record`."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from benchtool.cli import options, viewing
from benchtool.cli.output import Output, significant

if TYPE_CHECKING:
    from benchtool.bench.session import Session
    from benchtool.drive import Identity
    from benchtool.recording import BundleWriter, Event, Manifest
    from benchtool.telemetry import Certificate, FrameLog, Sink, TelemetryStream

_STEP_S = 0.05
_TELL_S = 1.0
_ROUNDING_S = 1e-9


def record(
    duration: Annotated[float, typer.Option(metavar="S", min=0.1, help="Seconds of drive time.")],
    out: options.Out = None,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    channels: Annotated[
        str,
        typer.Option(
            metavar="A,B,C",
            help="Signals: 13 at most over CAN, 16 over a serial line.",
            show_default="torque,omega_m,i_q,...",
        ),
    ] = "",
    rate: Annotated[
        float,
        typer.Option(
            metavar="HZ",
            help="Records per second: 1000 at most over CAN, the rate of the control over a serial line.",
        ),
    ] = 100.0,
    note: Annotated[str, typer.Option(help="A line for the manifest.")] = "",
    frames: Annotated[
        bool, typer.Option("--frames", help="Keep every frame too, for candump and --link replay:DIR.")
    ] = False,
    reconnect: Annotated[
        float,
        typer.Option(metavar="S", min=0.0, help="Wait so long for a link that is lost, and go on; 0: end."),
    ] = 0.0,
    live: viewing.Live = None,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """Record the stream of a drive, whatever it is doing; nothing is enabled."""
    from benchtool.bench.session import open_session
    from benchtool.recording import BundleWriter, EventFile
    from benchtool.telemetry import DEFAULT_CHANNELS, FrameLog, fitting, stream_source

    output = Output(as_json=as_json)
    when = options.wall_time()
    log = FrameLog() if frames else None
    with (
        options.bundle_folder(out, when, "record") as folder,
        viewing.places(live or (), output) as where,
    ):
        with open_session(
            profile, link, seed=seed, real_time=real_time, note=output.note, frames=log, instruments=False
        ) as session:
            drive = session.drive
            names = options.listed(channels) or fitting(drive, DEFAULT_CHANNELS)
            # Before there is a folder: what cannot be streamed leaves nothing behind.
            stream_source(drive, names, rate)
            identity = drive.check()
            manifest = _manifest(session, identity, when.isoformat(timespec="seconds"), note, seed, link)
            with (
                BundleWriter(folder, manifest) as bundle,
                viewing.stream_view(where, session, folder.name, manifest, output) as view,
            ):
                sinks, takers = [], [EventFile(folder).append]
                if view is not None:
                    takers.append(view.event)
                    sinks.append(viewing.live_sink(view))
                certificate = _record(
                    session, bundle, names, rate, duration, reconnect, log, output, sinks, takers
                )
                if view is not None:
                    viewing.show_certificate(view, certificate)
        _show(output, folder, certificate)
        where.linger(output)
    return 0


def _manifest(session: Session, identity: Identity, when: str, note: str, seed: int, link: str) -> Manifest:
    from benchtool.drive.parameters.transaction import snapshot
    from benchtool.recording import Manifest, software_versions

    drive = session.drive
    wall = drive.wall_mark(options.wall_time().timestamp())
    return Manifest(
        what="record",
        when=when,
        profile_name=session.profile_name,
        profile_toml=session.profile_toml,
        link=link,
        identity={key: value for key, value in asdict(identity).items() if value is not None},
        dictionary_hash=identity.dictionary_hash,
        parameters=snapshot(drive),
        versions=software_versions(),
        seed=seed,
        command_line=tuple(sys.argv[1:]),
        note=note,
        details={"state": drive.state().value, "wall": wall},
    )


def _record(
    session: Session,
    bundle: BundleWriter,
    names: Sequence[str],
    rate_Hz: float,
    duration_s: float,
    reconnect_s: float,
    log: FrameLog | None,
    output: Output,
    sinks: Sequence[Sink],
    takers: Sequence[Callable[[Event], None]],
) -> Certificate:
    """Record, and leave a bundle that says how it ended, whatever ends it."""
    from benchtool.errors import BenchError
    from benchtool.telemetry import certify_recording, keep_journal, record_stream

    stream: TelemetryStream | None = None
    drive = session.drive
    try:
        if log is not None:
            log.start(bundle.directory)
        with (
            keep_journal(drive, takers),
            record_stream(drive, bundle, names, rate_Hz, others=sinks) as stream,
        ):
            _wait(session, stream, duration_s, reconnect_s, log, output)
        if log is not None:
            log.close()
    except BaseException as failure:
        certificate, details = certify_recording(stream, {}, drive.link.counters)
        reason = f"{type(failure).__name__}: {failure}".rstrip(": ")
        fail = partial(
            bundle.fail,
            reason,
            quality=asdict(drive.link.counters),
            details=details,
            certificate=certificate.to_json(),
        )
        for end in (*(() if log is None else (log.close,)), fail):  # the files, then what says how they are
            try:
                end()
            except BenchError as also:
                failure.add_note(str(also))
        failure.add_note(f"what came until then is in {bundle.directory}")
        raise
    certificate, details = certify_recording(stream, {}, drive.link.counters)
    bundle.finish(quality=asdict(drive.link.counters), details=details, certificate=certificate.to_json())
    return certificate


def _wait(
    session: Session,
    stream: TelemetryStream,
    duration_s: float,
    reconnect_s: float,
    log: FrameLog | None,
    output: Output,
) -> None:
    from benchtool.errors import LinkClosed, NoAnswer

    clock, drive = session.drive.clock, session.drive
    start_s = clock.now_s()
    told_s = 0.0
    while (left_s := start_s + duration_s - clock.now_s()) > _ROUNDING_S:
        try:
            with suppress(NoAnswer):  # whether the drive is still there is the stream's to find
                drive.look()
            clock.wait(min(_STEP_S, left_s))
            stream.check()
            for emergency in drive.emergencies():
                output.note(f"the drive reports {emergency.text}")
        except LinkClosed as lost:
            if not reconnect_s:
                raise
            output.note(f"{lost}; waiting for it for {reconnect_s:g} s")
            drive.reconnect(reconnect_s)
            stream.resume()
        if log is not None:
            log.check()
        if (past_s := clock.now_s() - start_s) >= told_s + _TELL_S - _ROUNDING_S:
            told_s += _TELL_S
            output.note(f"{past_s:.0f} of {duration_s:g} s, {stream.report().counters.received} records")


def _show(output: Output, folder: Path, certificate: Certificate) -> None:
    rows = [
        (each.name, significant(each.value) if each.unit else _count(each.value), each.unit)
        for each in certificate.measurements
        if each.value or not each.name.startswith("link_")
    ]
    output.table("data quality", ("what", ">value", "unit"), rows)
    output.line(f"complete: {'yes' if certificate.complete else 'no'}")
    output.line(f"bundle: {folder}")
    output.document({"bundle": str(folder), "certificate": certificate.to_json()})


def _count(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "–"
