"""Wrong set-ups for a commissioning, and whether it names them.

`python -m benchmarks.commissioning --series wrong` tries them.

Each case changes one thing of an emulated bench whose sensors have flaws and whose nameplate is right; the
commissioning runs as far as the step that has to name it. A case is named if one of its findings has a cause
with the words of the case, and a remedy, and the commissioning has not passed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from benchtool.bench import Session
from benchtool.errors import BenchError

Profile = dict[str, Any]
FOUR_MOTORS: Final = ("xnova_4530", "gbm2804h", "teknic_m2310p", "ipmsm_2_2kw")
"""The one of the smallest resistance and inductance, a gimbal motor, a servo motor, a salient one."""

_ENCODER, _RESISTANCE, _SHAFT = "encoder", "resistance", "mechanics"


@dataclass(frozen=True)
class WrongSetUp:
    """A wrong set-up: what changes the profile, what is done to the bench once connected, the last step that
    is run, and the words of which a finding has to have one."""

    name: str
    words: tuple[str, ...]
    step: str
    profile: Callable[[Profile], None] = lambda _: None
    bench: Callable[[Session], None] = lambda _: None


def _motor(**factors: float) -> Callable[[Profile], None]:
    """Return what multiplies values of the nameplate; the machine stays as it is."""

    def change(profile: Profile) -> None:
        profile["emulator"]["motor"].setdefault("pole_pairs", profile["motor"]["pole_pairs"])
        for key, factor in factors.items():
            profile["motor"][key] *= factor

    return change


def _pole_pairs(profile: Profile) -> None:
    true = profile["motor"]["pole_pairs"]
    profile["emulator"]["motor"]["pole_pairs"] = true
    profile["motor"]["pole_pairs"] = true + 1


def _rated_current(profile: Profile) -> None:
    profile["motor"]["I_N_A_rms"] *= 10.0


def _encoder(**flaws: float | bool) -> Callable[[Profile], None]:
    def change(profile: Profile) -> None:
        profile["emulator"]["sensors"]["encoder"] |= flaws

    return change


def _lines(profile: Profile) -> None:
    profile["emulator"]["sensors"]["encoder_lines"] = 2048


def _current_sign(profile: Profile) -> None:
    for phase in "abc":
        profile["emulator"]["sensors"][f"i_{phase}"]["gain"] *= -1.0


def _shorted(profile: Profile) -> None:
    """Short most turns of phase b: what is left of it is that of all, and the others have the rest in
    series."""
    true, left = profile["emulator"]["motor"], 0.1
    rest_R, rest_L = (1.0 - left) * true["R_s_ohm"], (1.0 - left) * true["L_d_H"]
    true |= {"series_R_ohm": [rest_R, 0.0, rest_R], "series_L_H": [rest_L, 0.0, rest_L]}
    true |= {"psi_of_phase": [1.0, left, 1.0], "R_s_ohm": left * true["R_s_ohm"]}
    true |= {"L_d_H": left * true["L_d_H"], "L_q_H": left * true["L_q_H"]}


def _low_link(profile: Profile) -> None:
    profile["emulator"]["inverter"]["u_dc_V"] *= 0.3
    profile["drive"]["parameters"]["u_dc_min_V"] *= 0.2


def _load(profile: Profile) -> None:
    true = profile["emulator"]["motor"]
    profile["emulator"]["shaft"] = {"J_load_kgm2": 2.0 * true["J_kgm2"]}
    true["coulomb_Nm"] += 0.15 * profile["motor"]["T_N_Nm"]


def _locked(session: Session) -> None:
    if session.load is None:
        raise BenchError("this bench has no load machine to lock the shaft with: choose an emulated one")
    session.load.hold(0.0)


def _fault(text: str) -> Callable[[Session], None]:
    def inject(session: Session) -> None:
        if session.faults is None:
            raise BenchError(f"this bench cannot have the fault '{text}': choose an emulated one")
        session.faults.inject(text)

    return inject


def _open_phase(session: Session) -> None:
    """Open phase a, by a resistance with which a machine of small inductance can still be computed."""
    R_ohm = min(1000.0, 1e6 * session.profile.motor.L_d_H)
    _fault(f"phase_open:R_ohm={R_ohm:g}")(session)


CASES: Final = (
    WrongSetUp("swapped phases", ("phases are swapped",), _ENCODER, bench=_fault("phases_swapped")),
    WrongSetUp("encoder reversed", ("encoder is reversed",), _ENCODER, _encoder(reversed=True)),
    WrongSetUp("encoder slipping", ("slips",), _ENCODER, _encoder(slip=0.03)),
    WrongSetUp("line count", ("lines",), _ENCODER, _lines),
    WrongSetUp("open phase", ("is open",), _RESISTANCE, bench=_open_phase),
    WrongSetUp("shorted phase", ("shorted",), _RESISTANCE, _shorted),
    WrongSetUp("locked rotor", ("locked",), _ENCODER, bench=_locked),
    WrongSetUp("load on the shaft", ("load on the shaft",), _SHAFT, _load),
    WrongSetUp("pole pairs", ("pole pairs are wrong",), _ENCODER, _pole_pairs),
    WrongSetUp("dc link too low", ("dc link is too low",), "preflight", _low_link),
    WrongSetUp("rated current", ("rated current is",), "preflight", _rated_current),
    WrongSetUp("R line to line", ("between two terminals",), _RESISTANCE, _motor(R_s_ohm=2.0)),
    WrongSetUp("Kv convention", ("another convention",), "flux_linkage", _motor(psi_r_Wb=math.sqrt(3.0))),
    WrongSetUp("current sign", ("sign of the current",), _RESISTANCE, _current_sign),
    WrongSetUp("gearbox", ("gearbox",), _ENCODER, _encoder(slip=1.0 - 1.0 / 3.5)),
    WrongSetUp("L line to line", ("between two terminals",), "inductance", _motor(L_d_H=2.0, L_q_H=2.0)),
)
"""The last is the second form of one: of R and L either may be stated line to line."""


def named(case: WrongSetUp, document: Mapping[str, Any]) -> bool:
    """Return whether a document names a wrong set-up, with a remedy, and does not pass."""
    found: Sequence[Mapping[str, str]] = document["findings"]
    return document["verdict"] == "fail" and any(
        word in f"{each['what']} {each['cause']}" and bool(each["remedy"])
        for each in found
        for word in case.words
    )
