"""`benchtool live`."""

from __future__ import annotations

import math
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from benchtool.bench import Session, open_session
from benchtool.cli import live_views, options, proposals
from benchtool.cli.output import Output, warn_unsealed
from benchtool.drive import Capability
from benchtool.drive.parameters import snapshot
from benchtool.errors import UsageError
from benchtool.live import setup_of, show_bundle
from benchtool.profile import load_profile
from benchtool.recording import Manifest
from benchtool.results import recorded_bundles, recorded_runs
from benchtool.telemetry import TelemetryStream, keep_journal

_STEP_S = 0.05
_ROUNDING_S = 1e-9
_RATE_HZ = 250.0
_CHANNELS = (
    *("torque", "torque_reference", "omega_m", "i_a", "i_b"),  # those of a record of five
    *("i_c", "psi_s", "psi_alpha", "psi_beta", "u_dc", "law_clipped", "adc_saturated"),
)


def live(
    run: Annotated[
        Path | None, typer.Argument(metavar="[RUN]", help="A recorded run to look at, instead of a drive.")
    ] = None,
    duration: Annotated[
        float | None,
        typer.Option(metavar="S", min=0.1, help="Seconds of drive time.", show_default="until Ctrl-C"),
    ] = None,
    viewer: Annotated[
        bool, typer.Option("--viewer", help="Rerun's viewer; what there is by default.")
    ] = False,
    web: Annotated[bool, typer.Option("--web", help="Serve the view to a browser on this machine.")] = False,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE.rrd", help="Write a recording, for 'rerun FILE.rrd'.")
    ] = None,
    png: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.png",
            help="Draw it, without a display; a drive at the end of --duration. Needs Vulkan drivers.",
        ),
    ] = None,
    bind: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Where viewers listen; 0.0.0.0 lets others look.")
    ] = "127.0.0.1",
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    channels: Annotated[
        str,
        typer.Option(
            metavar="A,B,C",
            help="Signals to show.",
            show_default="torque,omega_m,i_a,...",
            autocompletion=proposals.channels,
        ),
    ] = "",
    rate: Annotated[float, typer.Option(metavar="HZ", help="Records per second, as of 'record'.")] = _RATE_HZ,
    seed: options.Seed = 0,
    as_json: options.Json = False,
) -> int:
    """Show a drive live in Rerun, whatever it is doing, or a recorded run; nothing is enabled."""
    output = Output(as_json=as_json)
    if save is not None and save.suffix != ".rrd":
        raise UsageError(f"--save {save}: a file that ends in .rrd is expected")
    if png is not None and png.suffix != ".png":
        raise UsageError(f"--png {png}: a file that ends in .png is expected")
    if png is not None and run is None and duration is None:
        raise UsageError(f"--png {png} is drawn at the end, which there is none without --duration: add it")
    if run is not None and (channels, rate, link, seed) != ("", _RATE_HZ, "emulated", 0):
        raise UsageError(
            f"--channels, --rate, --link and --seed are for a drive, and {run} is a recorded run: "
            f"leave them out, or leave out the run"
        )
    if run is not None:
        recorded_bundles(run)  # before a viewer is opened
    asked = [name for name, wanted in (("viewer", viewer), ("web", web)) if wanted]
    asked += [] if save is None else [str(save)]
    with tempfile.TemporaryDirectory() as drawn:
        asked += [] if png is None else [str(Path(drawn) / "view.rrd")]
        with live_views.open_destinations(asked or ["viewer"], output, bind) as where:
            if run is not None:
                shown = _show_run(run, profile, where, output)
            else:
                shown = _show_drive(profile, link, channels, rate, seed, duration, where, output)
            pictures = [] if png is None else live_views.draw(Path(drawn), png, output)
            output.document(shown | ({"pictures": [str(each) for each in pictures]} if pictures else {}))
            if run is not None:
                where.keep_open(output, duration)
    return 0


def _show_drive(
    profile: str,
    link: str,
    channels: str,
    rate_Hz: float,
    seed: int,
    duration_s: float | None,
    where: live_views.LiveDestinations,
    output: Output,
) -> dict[str, Any]:
    # An emulated drive is shown in real time.
    with open_session(
        profile, link, seed=seed, real_time=True, note=output.note, instruments=False
    ) as session:
        drive = session.drive
        drive.capabilities.require(Capability.STREAM, purpose="a live view")
        drive.check()
        fitting = drive.link.process_data.fitting(drive.dictionary, _CHANNELS)
        names = options.listed(channels) or fitting
        now = options.wall_time()
        manifest = Manifest(
            what="live",
            when=now.isoformat(timespec="seconds"),
            parameters=snapshot(drive),
            details={"wall": drive.clock_anchor(now.timestamp())},
        )
        with live_views.stream_view(where, session, profile, manifest, output) as view:
            assert view is not None  # there is a destination in any case
            sink = live_views.live_view_sink(view)
            with (
                keep_journal(drive, [view.event]),
                TelemetryStream(drive, [sink], names, rate_Hz) as stream,
            ):
                output.note("live; Ctrl-C ends it" if duration_s is None else f"live for {duration_s:g} s")
                if duration_s is None:
                    with suppress(KeyboardInterrupt):
                        _watch(session, stream, math.inf)
                else:
                    _watch(session, stream, duration_s)
        report = stream.report()
        dropped = {"queue": sink.rows_dropped, **view.rows_dropped}
    received = report.counters.received
    output.line(f"{received} rows, {sum(dropped.values())} of them not shown")
    return {"rows": received, "rows_lost": report.counters.lost, "rows_not_shown": dropped}


def _watch(session: Session, stream: TelemetryStream, duration_s: float) -> None:
    """Wait, and poll the drive's state and emergencies for the view."""
    drive, clock = session.drive, session.clock
    start_s = clock.now_s()
    drive.poll()
    while (left_s := start_s + duration_s - clock.now_s()) > _ROUNDING_S:
        clock.wait(min(_STEP_S, left_s))
        stream.check()
        drive.emergencies()
        drive.poll()


def _show_run(
    folder: Path, profile: str, where: live_views.LiveDestinations, output: Output
) -> dict[str, Any]:
    """Send every bundle of a run as a recording."""
    cases = [case for each in recorded_runs(folder) for case in each.cases]
    for case in cases:
        case.bundle.require_intact()
    warn_unsealed(output, [case.bundle for case in cases])
    psi_r_Wb = load_profile(profile).motor.psi_r_Wb
    shown = []
    for number, case in enumerate(cases, start=1):
        name = f"{number:03d}" if len(cases) > 1 else ""
        setup = setup_of(case.bundle.manifest, case.bundle.directory.name, psi_r_Wb)
        view = show_bundle(case.bundle, setup, where.of(name), output.note)
        view.close()
        live_views.warn_dropped(view, output)
        shown.append({"bundle": str(case.bundle.directory), "rows_not_shown": view.rows_dropped})
        output.line(f"shown: {case.bundle.directory}")
    return {"shown": shown}
