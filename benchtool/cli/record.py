"""`benchtool record`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Annotated

import typer

from benchtool.analysis import number, undefined
from benchtool.bench import open_session
from benchtool.bench.wires import registry
from benchtool.cli import live_views, options, proposals
from benchtool.cli.conditions import conditions
from benchtool.cli.exit_codes import ended_by_hand
from benchtool.cli.output import Output, warn_overdue
from benchtool.cli.progress import RecordingLine
from benchtool.recording import BundleWriter, EventFile, require_empty
from benchtool.results import Calibration
from benchtool.run import Ended, Recording, bundle_folder, prepared, record as keep
from benchtool.telemetry import FrameLog


def record(
    duration: Annotated[
        float | None,
        typer.Option(metavar="S", min=0.1, help="Seconds of drive time.", show_default="until Ctrl-C"),
    ] = None,
    out: options.Out = None,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    channels: Annotated[
        str,
        typer.Option(
            metavar="A,B,C",
            help=registry.channels_help(),
            show_default="torque,omega_m,i_q,...",
            autocompletion=proposals.channels,
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
    """Record the stream of a drive, whatever it is doing; nothing is enabled.

    Ctrl-C or SIGTERM ends it early: the bundle is complete then too, and says so. Without --duration the
    emulated drive is paced by the wall clock.
    """
    output = Output(as_json=as_json)
    if out is not None:
        require_empty(out)  # before a drive is opened
    stated = conditions(operator, serial_number, temperature, instrument or ())
    when = options.wall_time()
    log = FrameLog() if frames else None
    with (
        bundle_folder(out, when, "record") as folder,
        live_views.open_destinations(live or (), output) as where,
    ):
        with open_session(
            profile,
            link,
            seed=seed,
            real_time=real_time or duration is None,
            note=output.note,
            frames=log,
            instruments=False,
        ) as session:
            # Before the folder is created: a refused stream leaves no files.
            names, manifest = prepared(
                session,
                options.listed(channels),
                rate,
                when=when,
                link=link,
                seed=seed,
                note=note,
                conditions=stated,
                command_line=tuple(sys.argv[1:]),
            )
            warn_overdue(output, Calibration.at(session.profile.bench, manifest.when).overdue(names))
            with (
                BundleWriter(folder, manifest) as bundle,
                live_views.stream_view(where, session, folder.name, manifest, output) as view,
            ):
                sinks, takers = [], [EventFile(folder).append]
                if view is not None:
                    takers.append(view.event)
                    sinks.append(live_views.live_view_sink(view))
                recording = Recording(names, rate, duration, reconnect, log)
                with ended_by_hand() as is_ended, RecordingLine(output, as_json=as_json) as line:
                    ended = keep(
                        session,
                        bundle,
                        recording,
                        output.note,
                        sinks,
                        takers,
                        show=line.show,
                        is_ended=is_ended,
                    )
                if view is not None:
                    live_views.show_certificate(view, ended.certificate)
        _show(output, folder, ended)
        where.keep_open(output)
    return 0


def _show(output: Output, folder: Path, ended: Ended) -> None:
    certificate = ended.certificate
    rows = [
        (each.name, number(each.value) if each.unit else _count(each.value), each.unit)
        for each in certificate.measurements
        if each.value or not each.name.startswith("link_")
    ]
    output.table("data quality", ("what", ">value", "unit"), rows)
    for reason, names in undefined(certificate.measurements).items():
        output.sentence(f"undefined: {', '.join(names)}: {reason}", "dim")
    output.line(f"complete: {'yes' if certificate.complete else 'no'}")
    if ended.by_hand:
        output.line(f"ended by hand after {ended.past_s:.1f} s")
    output.line(f"bundle: {folder}")
    output.document({"bundle": str(folder), **ended.to_json(), "certificate": certificate.to_json()})


def _count(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "–"
