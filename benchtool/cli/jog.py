"""`benchtool jog`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from benchtool.bench.session import open_session
from benchtool.cli import options
from benchtool.cli.output import Output, significant
from benchtool.drive import Mode
from benchtool.errors import UsageError
from benchtool.run.jog import jog as run


def jog(
    duration: Annotated[float, typer.Option(metavar="S", min=0.01, help="Seconds to run.")],
    speed: Annotated[float | None, typer.Option(metavar="RAD_S", help="Hold this mechanical speed.")] = None,
    torque: Annotated[float | None, typer.Option(metavar="NM", help="Make this torque.")] = None,
    rate: Annotated[float, typer.Option(metavar="HZ", help="Setpoints per second, 1000 at most.")] = 100.0,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """Turn the shaft: setpoints from this computer, at a rate; Ctrl-C or the end disables the drive."""
    if (speed is None) == (torque is None):
        raise UsageError(
            f"{'neither' if speed is None else 'both'} of --speed and --torque: give one of the two"
        )
    mode, value = (Mode.VELOCITY, speed) if torque is None else (Mode.TORQUE, torque)
    output = Output(as_json=as_json)
    with open_session(
        profile, link, seed=seed, real_time=real_time, note=output.note, instruments=False
    ) as session:
        session.drive.connect()
        if unsupervised := session.drive.supervision.unsupervised:
            output.note(f"without link supervision, as the profile allows: {unsupervised}")
        output.note(f"{'speed' if torque is None else 'torque'} for {duration:g} s; Ctrl-C stops")
        result = run(
            session.drive,
            session.profile.motor,
            mode,
            lambda _: value or 0.0,
            duration_s=duration,
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
    return "–" if value is None else significant(value)
