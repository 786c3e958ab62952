"""`benchtool params derive`: parameters of a drive that fit the motor of the profile."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from benchtool.cli import options, proposals
from benchtool.cli.output import Output
from benchtool.cli.params import advise, connected, known_settings
from benchtool.drive import RemoteDrive
from benchtool.drive.parameters import require_disabled, write_all
from benchtool.errors import ValueRefused
from benchtool.profile import Derived, Given, derived_parameters, load_profile
from benchtool.protocol.dictionary import Value, parse_quantity, plain, shown

_SAMPLED_S = 0.05  # a drive that has just been powered has read its dc link by then
_WITHIN_RANGE = 0.98  # of the converter's range, at whose end the drive trips in any case
_RANGES = {"i_trip_A": "i_full_scale", "u_dc_max_V": "u_dc_full_scale"}


def derive(
    write: Annotated[
        bool, typer.Option("--write", help="Write them and the profile's motor: all of them, or none.")
    ] = False,
    law: Annotated[
        str,
        typer.Option(
            help="Control law.", show_default="tpc, or foc if L is small", autocompletion=proposals.laws
        ),
    ] = "",
    u_dc: Annotated[
        str,
        typer.Option("--u-dc", metavar="V", help="Nominal dc link.", show_default="as the drive reads it"),
    ] = "",
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Parameters that fit the motor of the profile, each with the rule that gives it, beside the drive's.

    Control period, encoder and ranges are those of the drive.
    """
    output = Output(as_json=as_json)
    stated = load_profile(profile)
    with connected(profile, link, output) as (drive, _):
        given = _given(drive, parse_quantity(u_dc, "V", "--u-dc") if u_dc else None)
        derived = _within_ranges(drive, derived_parameters(stated.motor, given, law))
        rules = {each.key: each.rule for each in derived}
        wanted = known_settings(
            drive.dictionary, stated.motor.parameters | {each.key: each.value for each in derived}
        )
        before = {name: drive.read(name) for name in wanted}
        if write:
            require_disabled(drive, "parameters are derived")
            write_all(drive, {name: value for name, (_, value) in wanted.items()})
    rows = [
        (key, _digits(before[name]), _digits(value), rules.get(key, "[motor] of the profile"))
        for name, (key, value) in wanted.items()
    ]
    done = "before" if write else "drive"
    output.table(f"parameters for {stated.title}", ("parameter", f">{done}", ">derived", "rule"), rows)
    if not write:
        output.note("nothing was written; --write does, 'benchtool profile new' puts them into a profile")
    else:
        advise(output, link, "not stored; benchtool params save keeps it over a reset")
    output.document(
        {
            "written": write,
            "parameters": {
                key: {
                    "before": plain(before[name]),
                    "value": plain(value),
                    "rule": rules.get(key, "[motor] of the profile"),
                }
                for name, (key, value) in wanted.items()
            },
        }
    )
    return 0


def _digits(value: Value) -> str:
    """Return the digits that matter of a derived value."""
    return f"{value:.5g}" if isinstance(value, float) else shown(value)


def _given(drive: RemoteDrive, u_dc_V: float | None) -> Given:
    """Return what the rules rest on, as the drive tells it.

    Raises:
        ValueRefused: it tells no voltage of the dc link, and none is given.
    """
    if u_dc_V is None:
        drive.wait(_SAMPLED_S)
        u_dc_V = _number(drive, "u_dc")
    if not u_dc_V or u_dc_V <= 0.0:
        raise ValueRefused("the drive reads no dc link: power it, or give its nominal voltage with --u-dc")
    usual = Given(u_dc_V, 1)
    return Given(
        u_dc_V,
        round(_number(drive, "encoder_lines") or usual.encoder_lines),
        _number(drive, "control_period") or usual.control_period_s,
        _number(drive, "dead_time_compensation") or 0.0,
    )


def _number(drive: RemoteDrive, name: str) -> float | None:
    return drive.number(name) if name in drive.dictionary else None


def _within_ranges(drive: RemoteDrive, derived: Sequence[Derived]) -> list[Derived]:
    """Return the parameters with trip levels within what the drive's converters read."""
    found = []
    for each in derived:
        most = _number(drive, _RANGES[each.key]) if each.key in _RANGES else None
        level = _WITHIN_RANGE * most if most else None
        beyond = level is not None and isinstance(each.value, float) and each.value > level
        rule = f"{_WITHIN_RANGE:g} of the converter's range; {each.rule}"
        found.append(Derived(each.key, level, rule) if beyond and level is not None else each)
    return found
