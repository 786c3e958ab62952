"""`benchtool jog`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from benchtool.analysis import number
from benchtool.bench import open_session
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import UsageError
from benchtool.protocol import Mode
from benchtool.protocol.dictionary import parse_quantity
from benchtool.run import check_parameters, jog as run

_SHORTEST_S = 0.01


def jog(
    duration: Annotated[str, typer.Option(metavar="S", help="Time to run: 2, 2s or 500ms.")],
    speed: Annotated[
        str, typer.Option(metavar="RAD_S", help="Hold this mechanical speed: 15.7 or 150rpm.")
    ] = "",
    torque: Annotated[str, typer.Option(metavar="NM", help="Make this torque: 0.5 or 500mNm.")] = "",
    rate: Annotated[float, typer.Option(metavar="HZ", help="Setpoints per second, 1000 at most.")] = 100.0,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    allow_different: Annotated[
        bool,
        typer.Option("--allow-different", help="Turn a drive whose parameters contradict the profile."),
    ] = False,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """Turn the shaft: setpoints from this computer, at a rate; Ctrl-C or the end disables the drive."""
    if bool(speed) == bool(torque):
        raise UsageError(f"{'both' if speed else 'neither'} of --speed and --torque: give one of the two")
    if speed:
        mode, value = Mode.VELOCITY, parse_quantity(speed, "rad/s", "--speed")
    else:
        mode, value = Mode.TORQUE, parse_quantity(torque, "Nm", "--torque")
    duration_s = parse_quantity(duration, "s", "--duration")
    if duration_s < _SHORTEST_S:
        raise UsageError(f"--duration {duration}: {_SHORTEST_S:g} s at least are expected")
    output = Output(as_json=as_json)
    with open_session(
        profile, link, seed=seed, real_time=real_time, note=output.note, instruments=False, enabling=True
    ) as session:
        session.drive.connect()
        if unsupervised := session.drive.supervision.unsupervised:
            output.note(f"without link supervision, as the profile allows: {unsupervised}")
        check = check_parameters(session.drive, session.profile, ())
        if not allow_different:
            check.require_equal()
        for line in check.lines():
            output.note(line)
        output.note(f"{'speed' if speed else 'torque'} for {duration_s:g} s; Ctrl-C stops")
        result = run(
            session.drive,
            session.profile.motor,
            mode,
            lambda _: value,
            duration_s=duration_s,
            rate_Hz=rate,
        )
        supervision = session.drive.supervision.to_json()
    pacing = result.pacing
    clock = "virtual" if session.clock.virtual else "real"
    rows = [
        ("omega_m at the end", _shown(result.omega_m_rad_s), "rad/s"),
        ("torque at the end", _shown(result.torque_Nm), "Nm"),
        ("setpoints sent", str(pacing.sent), ""),
        ("period, mean", f"{pacing.period_mean_s * 1e3:.4f}", "ms"),
        ("period, rms deviation", f"{pacing.period_rms_s * 1e3:.4f}", "ms"),
        ("period, longest", f"{pacing.period_max_s * 1e3:.4f}", "ms"),
        ("late periods", str(pacing.late), ""),
        ("clock", f"{clock}, always even" if session.clock.virtual else clock, ""),
    ]
    output.table(f"jog of profile {profile}", ("what", ">value", "unit"), rows)
    output.document(
        {
            "omega_m_rad_s": result.omega_m_rad_s,
            "torque_Nm": result.torque_Nm,
            "pacing": asdict(pacing),
            "clock": clock,
            **({"supervision": supervision} if supervision else {}),
        }
    )
    return 0


def _shown(value: float | None) -> str:
    return "–" if value is None else number(value)
