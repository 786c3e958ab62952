"""`benchtool demo`."""

from __future__ import annotations

from benchtool.cli import options
from benchtool.cli.run import RunOptions, run_named

PLAN = "zhu2011/ripple"


def demo(
    out: options.Out = None,
    live: options.Live = None,
    web: options.Web = False,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """A torque-ripple test on the emulated drive, over CANopen frames: needs no hardware."""
    return run_named(
        PLAN,
        RunOptions(out=out, seed=seed, real_time=real_time, as_json=as_json, live=tuple(live or ()), web=web),
    )
