"""`benchtool live`."""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from benchtool.bench.session import Session, open_session
from benchtool.cli import options, viewing
from benchtool.cli.output import Output, tell_unsealed
from benchtool.drive.capabilities import Capability
from benchtool.drive.parameters.transaction import snapshot
from benchtool.errors import UsageError
from benchtool.live import setup_of, show_bundle
from benchtool.profile import load_profile
from benchtool.recording import Manifest
from benchtool.results.runs import recorded_runs
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
    bind: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Where viewers listen; 0.0.0.0 lets others look.")
    ] = "127.0.0.1",
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    channels: Annotated[
        str, typer.Option(metavar="A,B,C", help="Signals to show.", show_default="torque,omega_m,i_a,...")
    ] = "",
    rate: Annotated[float, typer.Option(metavar="HZ", help="Records per second, as of 'record'.")] = _RATE_HZ,
    seed: options.Seed = 0,
    as_json: options.Json = False,
) -> int:
    """Show a drive live in Rerun, whatever it is doing, or a recorded run; nothing is enabled."""
    output = Output(as_json=as_json)
    if save is not None and save.suffix != ".rrd":
        raise UsageError(f"--save {save}: a file that ends in .rrd is expected")
    if run is not None and (channels, rate, link, seed) != ("", _RATE_HZ, "emulated", 0):
        raise UsageError(
            f"--channels, --rate, --link and --seed are for a drive, and {run} is a recorded run: "
            f"leave them out, or leave out the run"
        )
    asked = [name for name, wanted in (("viewer", viewer), ("web", web)) if wanted]
    asked += [] if save is None else [str(save)]
    with viewing.places(asked or ["viewer"], output, bind) as where:
        if run is not None:
            return _show_run(run, profile, where, output, duration)
        return _show_drive(profile, link, channels, rate, seed, duration, where, output)


def _show_drive(
    profile: str,
    link: str,
    channels: str,
    rate_Hz: float,
    seed: int,
    duration_s: float | None,
    where: viewing.Places,
    output: Output,
) -> int:
    # An emulated drive is looked at in the time that it would take.
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
            details={"wall": drive.wall_mark(now.timestamp())},
        )
        with viewing.stream_view(where, session, profile, manifest, output) as view:
            assert view is not None  # there is a destination in any case
            sink = viewing.live_sink(view)
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
    output.document({"rows": received, "rows_lost": report.counters.lost, "rows_not_shown": dropped})
    return 0


def _watch(session: Session, stream: TelemetryStream, duration_s: float) -> None:
    """Wait, and ask for the drive's state and its emergencies, which the view is told of."""
    drive, clock = session.drive, session.clock
    start_s = clock.now_s()
    drive.look()
    while (left_s := start_s + duration_s - clock.now_s()) > _ROUNDING_S:
        clock.wait(min(_STEP_S, left_s))
        stream.check()
        drive.emergencies()
        drive.look()


def _show_run(
    folder: Path, profile: str, where: viewing.Places, output: Output, duration_s: float | None
) -> int:
    """Send every bundle of a run, each as a recording of its own."""
    cases = [case for each in recorded_runs(folder) for case in each.cases]
    for case in cases:
        case.bundle.require_intact()
    tell_unsealed(output, [case.bundle for case in cases])
    psi_r_Wb = load_profile(profile).motor.psi_r_Wb
    shown = []
    for number, case in enumerate(cases, start=1):
        name = f"{number:03d}" if len(cases) > 1 else ""
        setup = setup_of(case.bundle.manifest, case.bundle.directory.name, psi_r_Wb)
        view = show_bundle(case.bundle, setup, where.of(name), output.note)
        view.close()
        viewing.tell_drops(view, output)
        shown.append({"bundle": str(case.bundle.directory), "rows_not_shown": view.rows_dropped})
        output.line(f"shown: {case.bundle.directory}")
    output.document({"shown": shown})
    where.linger(output, duration_s)
    return 0
