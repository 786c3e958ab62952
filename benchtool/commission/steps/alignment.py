"""The current that draws the rotor to an angle before a step measures at standstill."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.drive import CaptureRequest, Stimulus
from benchtool.protocol.dictionary import Value

_DURATION_S: Final = 0.8
_AGAIN_S: Final = 0.3
_ROWS: Final = 200  # which tell no more than the heat of it
_SHARE: Final = 0.6  # of the rated current, peak, at the end of the ramp


def aligning(
    known: Known, parameters: Mapping[str, Value], angle_rad: float = 0.0, *, again: bool = False
) -> Excitation:
    """Return a current that grows along an electrical angle, against phase a, and draws the rotor there.

    `parameters` are to be in force meanwhile, beside a bandwidth of the current loop that damps the rotor.
    With `again` the rotor has been there just before, and there is less to be damped.
    """
    duration_s = _AGAIN_S if again else _DURATION_S
    stride = max(1, round(duration_s / _ROWS / known.control_period_s))
    rows = math.floor(duration_s / (stride * known.control_period_s)) - 1
    amplitude_A = _SHARE * known.I_N_A
    return Excitation(
        "alignment",
        Stimulus(
            quantity="current",
            shape="ramp",
            amplitude_A=amplitude_A,
            duration_s=duration_s,
            angle_rad=angle_rad,
        ),
        CaptureRequest(CURRENTS, rows, stride),
        amplitude_A**2 * duration_s / 3.0,
        {**parameters, "omega_current": known.damping_bandwidth_rad_s},
    )
