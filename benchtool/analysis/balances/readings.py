"""What errors of the sensors that a balance reads do to its numbers.

A drive makes a voltage by its reading of the dc link: one that is too small makes it too large by the same
factor, and every flux, impedance and torque with it. The common gain of the current sensors scales impedances
and torque, a third of each one's. What offsets and steps of currents and angle do depends on what is
captured, and is measured again. A gain of one phase beside the others, and the zero of the encoder, are
themselves found by a balance, and no errors of it.
"""

from __future__ import annotations

from typing import Final

from benchtool.analysis.balances.flux_model import PHASES
from benchtool.analysis.sensitivity import Error, Sensitivities, Sensitivity
from benchtool.analysis.sensors.mean_reading import MeanReading

_OF_CURRENT: Final = frozenset({Error.OFFSET, Error.RESOLUTION})
_OF_ANGLE: Final = frozenset({Error.RESOLUTION})


def of_readings(value: float, link: MeanReading | None, power_of_current: int) -> Sensitivities:
    """Return the sensitivities of a number by a balance.

    Args:
        value: the number.
        link: the mean dc link, if the number is proportional to it.
        power_of_current: 1 where it is proportional to the common gain of the current sensors, -1 where it is
            to the inverse, 0 of others.
    """
    by_link = () if link is None else (Sensitivity.of_factor(link.channel, value, link.mean),)
    gain = power_of_current * value / len(PHASES)
    by_phase = (Sensitivity(phase, gain, again=_OF_CURRENT) for phase in PHASES)
    return Sensitivities((*by_link, *by_phase, Sensitivity("theta_m", again=_OF_ANGLE)))
