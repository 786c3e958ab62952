"""`benchtool record`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Annotated

import typer

from benchtool.bench.session import open_session
from benchtool.bench.wires import registry
from benchtool.cli import options, viewing
from benchtool.cli.bundles import bundle_folder, conditions
from benchtool.cli.output import Output, significant, tell_overdue
from benchtool.drive.capabilities import Capability
from benchtool.recording import BundleWriter, EventFile
from benchtool.results.calibration import Calibration
from benchtool.run.recording import Recording, manifest_of
from benchtool.run.recording import record as keep
from benchtool.telemetry import (
    DEFAULT_CHANNELS,
    Certificate,
    FrameLog,
)


def record(
    duration: Annotated[float, typer.Option(metavar="S", min=0.1, help="Seconds of drive time.")],
    out: options.Out = None,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    channels: Annotated[
        str,
        typer.Option(
            metavar="A,B,C",
            help=registry.channels_help(),
            show_default="torque,omega_m,i_q,...",
        ),
    ] = "",
    rate: Annotated[
        float,
        typer.Option(
            metavar="HZ",
            help=registry.rate_help(),
        ),
    ] = 100.0,
    note: options.Note = "",
    operator: options.Operator = "",
    serial_number: options.SerialNumber = "",
    temperature: options.Temperature = None,
    instrument: options.InstrumentsBeside = None,
    frames: Annotated[
        bool, typer.Option("--frames", help="Keep every frame too, for candump and --link replay:DIR.")
    ] = False,
    reconnect: Annotated[
        float,
        typer.Option(metavar="S", min=0.0, help="Wait so long for a link that is lost, and go on; 0: end."),
    ] = 0.0,
    live: options.Live = None,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """Record the stream of a drive, whatever it is doing; nothing is enabled."""
    output = Output(as_json=as_json)
    stated = conditions(operator, serial_number, temperature, instrument or ())
    when = options.wall_time()
    log = FrameLog() if frames else None
    with (
        bundle_folder(out, when, "record") as folder,
        viewing.places(live or (), output) as where,
    ):
        with open_session(
            profile, link, seed=seed, real_time=real_time, note=output.note, frames=log, instruments=False
        ) as session:
            drive = session.drive
            drive.capabilities.require(Capability.STREAM, purpose="a recording")
            process_data = drive.link.process_data
            names = options.listed(channels) or process_data.fitting(drive.dictionary, DEFAULT_CHANNELS)
            # Before there is a folder: what cannot be streamed leaves nothing behind.
            process_data.source(drive, names, rate)
            identity = drive.check()
            begun = when.isoformat(timespec="seconds")
            manifest = manifest_of(
                session,
                identity,
                what="record",
                when=begun,
                wall_s=options.wall_time().timestamp(),
                note=note,
                conditions=stated,
                seed=seed,
                link=link,
                command_line=tuple(sys.argv[1:]),
                details={"state": drive.state().value},
            )
            tell_overdue(output, Calibration.at(session.profile.bench, begun).overdue(names))
            with (
                BundleWriter(folder, manifest) as bundle,
                viewing.stream_view(where, session, folder.name, manifest, output) as view,
            ):
                sinks, takers = [], [EventFile(folder).append]
                if view is not None:
                    takers.append(view.event)
                    sinks.append(viewing.live_sink(view))
                recording = Recording(names, rate, duration, reconnect, log)
                certificate = keep(session, bundle, recording, output.note, sinks, takers)
                if view is not None:
                    viewing.show_certificate(view, certificate)
        _show(output, folder, certificate)
        where.linger(output)
    return 0


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
