"""`benchtool profile new`: a profile for a motor of one's own, from its nameplate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final, TypeVar

import typer

from benchtool.cli import options, proposals
from benchtool.cli.new_files import write_new
from benchtool.cli.output import Output
from benchtool.document import closest
from benchtool.errors import UsageError, ValueRefused
from benchtool.profile import (
    CONTROL_PERIOD_S,
    LAWS,
    Amplitude,
    Given,
    Nameplate,
    Voltage,
    Winding,
    derived_parameters,
    flux_of_ke,
    flux_of_kt,
    flux_of_kv,
    profile_text,
    rate_fault,
)
from benchtool.protocol.dictionary import parse_quantity

Convention = TypeVar("Convention", bound=StrEnum)

_EXAMPLE: Final = {
    "--pole-pairs": "7",
    "--R-s": "0.2ohm:ll",
    "--L": "100uH:ll",
    "--Kv": "300rpm/V:ll-peak",
    "--J": "0.1kgcm2",
    "--u-dc": "24V",
    "--i-rated": "5A:rms",
}
_ENCODER_LINES = 2500


def new(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="TOML file to write; standard output without one.")
    ] = None,
    title: Annotated[str, typer.Option(help="What a report calls the motor.")] = "",
    pole_pairs: Annotated[str, typer.Option("--pole-pairs", metavar="N", help="Half the magnets.")] = "",
    R_s: Annotated[
        str, typer.Option("--R-s", metavar="OHM:phase|ll", help="Resistance per phase, or line to line.")
    ] = "",
    L: Annotated[
        str, typer.Option("--L", metavar="H:phase|ll", help="Inductance per phase, or line to line.")
    ] = "",
    L_d: Annotated[str, typer.Option("--L-d", metavar="H", help="In the direct axis, in place of --L.")] = "",
    L_q: Annotated[str, typer.Option("--L-q", metavar="H", help="In the quadrature axis, likewise.")] = "",
    Kv: Annotated[
        str,
        typer.Option("--Kv", metavar="RPM/V:OF", help="Speed constant; OF: [ll|phase]-[peak|rms] volts."),
    ] = "",
    Ke: Annotated[
        str,
        typer.Option("--Ke", metavar="V/KRPM:OF", help="Back-EMF constant, in place of --Kv; OF as there."),
    ] = "",
    Kt: Annotated[
        str, typer.Option("--Kt", metavar="NM/A:peak|rms", help="Torque constant, in place of --Kv.")
    ] = "",
    psi_r: Annotated[
        str, typer.Option("--psi-r", metavar="WB", help="Flux linkage, peak per phase, in place of --Kv.")
    ] = "",
    J: Annotated[str, typer.Option("--J", metavar="KGM2", help="Inertia of rotor and coupling.")] = "",
    u_dc: Annotated[str, typer.Option("--u-dc", metavar="V", help="Nominal dc-link voltage.")] = "",
    i_rated: Annotated[
        str, typer.Option("--i-rated", metavar="A:rms|peak", help="Rated phase current.")
    ] = "",
    torque_rated: Annotated[
        str, typer.Option("--torque-rated", metavar="NM", show_default="of --i-rated", help="Rated torque.")
    ] = "",
    speed_rated: Annotated[
        str,
        typer.Option("--speed-rated", metavar="RPM", show_default="what --u-dc allows", help="Rated speed."),
    ] = "",
    dead_time: Annotated[str, typer.Option("--dead-time", metavar="S", help="Of the inverter.")] = "0s",
    control_period: Annotated[
        str, typer.Option("--control-period", metavar="S", help="Of the drive's control: 50us, 100us.")
    ] = f"{CONTROL_PERIOD_S * 1e6:g}us",
    double_update: Annotated[
        bool, typer.Option("--double-update", help="Control runs at both ends of a PWM period.")
    ] = False,
    encoder_lines: Annotated[int, typer.Option(min=1, help="Of the encoder.")] = _ENCODER_LINES,
    law: Annotated[
        str,
        typer.Option(
            help=f"Control law: {', '.join(LAWS)}.",
            show_default="tpc, or foc if L is small",
            autocompletion=proposals.laws,
        ),
    ] = "",
    force: Annotated[bool, typer.Option("--force", help="Replace FILE if it exists.")] = False,
    as_json: options.Json = False,
) -> int:
    """A commented profile of a motor, control gains derived from it, that runs on the emulated bench at once.

    Without any value of a motor it is a template: that of an example, to be filled in. Values have units
    (0.1ohm, 50uH, 300rpm/V). What a nameplate may state in two ways says behind a colon which one it is.
    """
    stated = {
        "--pole-pairs": pole_pairs,
        "--R-s": R_s,
        "--L": L,
        "--L-d": L_d,
        "--L-q": L_q,
        "--Kv": Kv,
        "--Ke": Ke,
        "--Kt": Kt,
        "--psi-r": psi_r,
        "--J": J,
        "--u-dc": u_dc,
        "--i-rated": i_rated,
        "--torque-rated": torque_rated,
        "--speed-rated": speed_rated,
    }
    output = Output(as_json=as_json)
    if law and law not in LAWS:
        raise UsageError(f"--law {law}: {closest(law, LAWS)}")
    given = {option: text for option, text in stated.items() if text}
    plate = read_nameplate(given or _EXAMPLE)
    motor = plate.motor()
    dead_time_s = parse_quantity(dead_time, "s", "--dead-time")
    period_s = parse_quantity(control_period, "s", "--control-period")
    if fault := rate_fault((2.0 if double_update else 1.0) * period_s):
        raise UsageError(f"--control-period {control_period}: {fault}")
    known = Given(plate.u_dc_V, encoder_lines, period_s, dead_time_s, double_update)
    derived = derived_parameters(motor, known, law)
    called = title or (file.stem if file is not None else "motor" if given else "example: fill in your motor")
    for each in plate.contradictions():
        output.warning(each)
    text = profile_text(called, motor, known, derived)
    write_new(file, text, force=force, quiet=as_json)
    if file is not None:
        output.line(f"profile of '{called}' written to {file}")
        output.note(f"a first test of it: benchtool plan new ripple.toml --profile {file}")
    output.document(
        {
            "file": None if file is None else str(file),
            "motor": motor.model_dump(exclude_none=True),
            "parameters": {each.key: {"value": each.value, "rule": each.rule} for each in derived},
        }
    )
    return 0


def read_nameplate(given: Mapping[str, str]) -> Nameplate:
    """Return the nameplate that options state, by option.

    Raises:
        UsageError: all that is missing, wrong or given twice, at once.
    """
    reader = _Reader(given)
    p = reader.pole_pairs()
    flux_options = [each for each in ("--Kv", "--Ke", "--Kt", "--psi-r") if each in given]
    inductances = [each for each in ("--L", "--L-d", "--L-q") if each in given]
    if len(flux_options) > 1:
        reader.complain(f"{' and '.join(flux_options)} state one flux: give one of them")
    elif not flux_options:
        reader.complain(f"--Kv is missing (or --Ke, --Kt, --psi-r): --Kv {_EXAMPLE['--Kv']}")
    if not inductances:
        reader.complain(f"--L is missing (or --L-d and --L-q): --L {_EXAMPLE['--L']}")
    elif inductances not in (["--L"], ["--L-d", "--L-q"]):
        reader.complain(f"{' and '.join(inductances)}: give --L, or --L-d and --L-q")
    R_s = reader.quantity("--R-s", "ohm", Winding, lambda value, of: value * of.per_phase)
    L = reader.optional("--L", "H", Winding, lambda value, of: value * of.per_phase)
    axes = [reader.optional(each, "H") for each in ("--L-d", "--L-q")]
    psi_r = reader.optional("--psi-r", "Wb")
    if p is not None:
        psi_r = (
            psi_r
            or reader.optional("--Kv", "rad/s/V", Voltage, lambda value, of: flux_of_kv(value, of, p))
            or reader.optional("--Ke", "Vs/rad", Voltage, lambda value, of: flux_of_ke(value, of, p))
            or reader.optional("--Kt", "Nm/A", Amplitude, lambda value, of: flux_of_kt(value, of, p))
        )
    J, u_dc = reader.quantity("--J", "kgm2"), reader.quantity("--u-dc", "V")
    I_N = reader.quantity("--i-rated", "A", Amplitude, lambda value, of: value * of.peaks)
    T_N, omega_m_N = reader.optional("--torque-rated", "Nm"), reader.optional("--speed-rated", "rad/s")
    reader.finish()
    assert p  # finish has refused what is missing
    assert psi_r
    return Nameplate(
        pole_pairs=p,
        R_s_ohm=R_s,
        L_d_H=axes[0] or L or 0.0,
        L_q_H=axes[1] or L or 0.0,
        psi_r_Wb=psi_r,
        J_kgm2=J,
        u_dc_V=u_dc,
        I_N_A=I_N,
        T_N_Nm=T_N,
        omega_m_N_rad_s=omega_m_N,
    )


_MEANINGS: Final = {
    "--R-s": "between what it was measured",
    "--L": "between what it was measured",
    "--Kv": "per which volt, hobby motors state ll-peak",
    "--Ke": "of which voltage",
    "--Kt": "per which ampere",
    "--i-rated": "of which amplitude",
}


class _Reader:
    """Reads options, and gathers what is wrong with them."""

    def __init__(self, given: Mapping[str, str]) -> None:
        self._given = given
        self._complaints: list[str] = []

    def complain(self, text: str) -> None:
        """Add to what is wrong."""
        self._complaints.append(text)

    def pole_pairs(self) -> int | None:
        """Return the number of pole pairs; None where it is missing or wrong."""
        text = self._given.get("--pole-pairs", "")
        if not text:
            self.complain("--pole-pairs is missing: half the number of magnets")
        elif not text.isdecimal() or not 1 <= int(text) <= 50:
            self.complain(f"--pole-pairs {text}: a whole number from 1 to 50 is expected")
        else:
            return int(text)
        return None

    def quantity(
        self,
        option: str,
        unit: str,
        conventions: type[Convention] | None = None,
        converted: Callable[[float, Convention], float] = lambda value, _: value,
    ) -> float:
        """As `optional`, of an option that has to be there."""
        if option not in self._given:
            self.complain(f"{option} is missing: {option} {_EXAMPLE[option]}")
        return self.optional(option, unit, conventions, converted) or 0.0

    def optional(
        self,
        option: str,
        unit: str,
        conventions: type[Convention] | None = None,
        converted: Callable[[float, Convention], float] = lambda value, _: value,
    ) -> float | None:
        """Return the value in the unit and the convention that is used inside; None where it is missing or
        wrong."""
        if option not in self._given:
            return None
        text, colon, convention = self._given[option].partition(":")
        try:
            value = parse_quantity(text, unit, option)
        except ValueRefused as refused:
            self.complain(str(refused).replace("; nothing was sent", ""))
            return None
        if not value > 0.0:
            self.complain(f"{option} {text}: a value above 0 is expected")
            return None
        if conventions is None:
            if colon:
                self.complain(
                    f"{option} {self._given[option]}: no ':{convention}' is expected here, leave it out"
                )
            return value
        choices = [each.value for each in conventions]
        if convention in choices:
            return converted(value, conventions(convention))
        asked = f"{_MEANINGS[option]}? write " + " or ".join(f"{text}:{each}" for each in choices)
        self.complain(f"{option} {self._given[option]}: {asked}")
        return None

    def finish(self) -> None:
        """Refuse what was wrong.

        Raises:
            UsageError: something was.
        """
        if self._complaints:
            raise UsageError.of_all(self._complaints)
