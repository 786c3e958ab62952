"""`benchtool jog`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from benchtool.cli import options
from benchtool.cli.output import Output, significant


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
    from benchtool.bench.session import open_session
    from benchtool.clock import RealClock
    from benchtool.drive import Mode
    from benchtool.errors import UsageError
    from benchtool.run.jog import jog as run

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
        output.note(f"{'speed' if torque is None else 'torque'} for {duration:g} s; Ctrl-C stops")
        result = run(
            session.drive,
            session.profile.motor,
            mode,
            lambda _: value or 0.0,
            duration_s=duration,
            rate_Hz=rate,
        )
    pacing = result.pacing
    clock = "real" if isinstance(session.clock, RealClock) else "virtual, always even"
    rows = [
        ("omega_m at the end", significant(result.omega_m_rad_s), "rad/s"),
        ("torque at the end", significant(result.torque_Nm), "Nm"),
        ("setpoints sent", str(pacing.sent), ""),
        ("period, mean", f"{pacing.period_mean_s * 1e3:.4f}", "ms"),
        ("period, rms deviation", f"{pacing.period_rms_s * 1e3:.4f}", "ms"),
        ("period, longest", f"{pacing.period_max_s * 1e3:.4f}", "ms"),
        ("late periods", str(pacing.late), ""),
        ("clock", clock, ""),
    ]
    output.table(f"jog of profile {profile}", ("what", ">value", "unit"), rows)
    output.document(
        {
            "omega_m_rad_s": result.omega_m_rad_s,
            "torque_Nm": result.torque_Nm,
            "pacing": asdict(pacing),
            "clock": clock.partition(",")[0],
        }
    )
    return 0
