"""EMF of a rotor that an alternating current shakes, with the harmonics of its flux.

Per radian of the electrical angle theta the rotor's flux linkage changes, in its own axes, by

    psi_r k(theta),   k = j (1 - 5 a_5 exp(-j 6 theta) + 7 a_7 exp(j 6 theta)),

with the fifth and the seventh harmonic of the flux in shares of it. That is both the torque of a current and
the EMF of a speed: while the current shakes the rotor, it induces

    e = K k integral of (i . k) dt,   K = 3/2 p^2 psi_r^2 / J.

Without harmonics it lies across the rotor flux, as a capacitor in series. With them it couples the axes, the
more, the further the rotor is from where their derivatives cancel: of two shares of 2.5 %, 0.03 rad from the
axis of a phase, by a twentieth of the whole, and at 0.15 rad by a fifth of it. What it takes along the flux,
where nothing else is induced, looks like a smaller L_d.

Of e, three parts are linear about an estimate: e / K, and its derivatives by both shares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

SHARE_STANDARD: Final = 0.02
"""Standard deviation of a share before it is told: windings and magnets leave up to 0.03."""

_MOST_SHARE: Final = 0.05


class Shaking(NamedTuple):
    """The EMF for K = 1, and its derivatives by the shares a_5 and a_7, in V s, shape (n,) each."""

    per_K: NDArray[np.complex128]
    by_fifth: NDArray[np.complex128]
    by_seventh: NDArray[np.complex128]


@dataclass(frozen=True)
class ShakenRotor:
    """K in V/(A s), 0 as long as it is not known, and the shares a_5 and a_7 of the rotor flux.

    `told` is whether the data may tell these.
    """

    K_V_As: float = 0.0
    fifth: float = 0.0
    seventh: float = 0.0
    told: bool = True

    def shaking(
        self, i_dq_A: NDArray[np.complex128], theta_e_rad: NDArray[np.float64], T_s: float
    ) -> Shaking:
        """Return the parts of the EMF, in the rotor's axes, over periods with these currents and angles.

        A K below zero is none of a rotor, and tells nothing of the shares: their derivatives are 0.
        """
        turned = np.exp(6j * theta_e_rad)
        fifth, seventh = -5j * turned.conj(), 7j * turned
        k = 1j + self.fifth * fifth + self.seventh * seventh
        swung = _integral(i_dq_A, k, T_s)
        K = max(0.0, self.K_V_As) if self.told else 0.0
        by_fifth, by_seventh = (K * (_integral(i_dq_A, of, T_s) * k + swung * of) for of in (fifth, seventh))
        return Shaking(swung * k, by_fifth, by_seventh)

    def moved(self, K_V_As: float, by_fifth: float, by_seventh: float) -> Self:
        """Return the next estimate: another K, and shares changed by this much.

        Where the data ask for shares that no winding has, it is not for harmonics that they ask: iron that
        saturates in ways that are not modelled moves as often. Then the shares are given up.
        """
        fifth, seventh = self.fifth + by_fifth, self.seventh + by_seventh
        if not self.told or max(abs(fifth), abs(seventh)) > _MOST_SHARE:
            return replace(self, K_V_As=K_V_As, fifth=0.0, seventh=0.0, told=False)
        return replace(self, K_V_As=K_V_As, fifth=fifth, seventh=seventh)


def _integral(i_A: NDArray[np.complex128], k: NDArray[np.complex128], T_s: float) -> NDArray[np.float64]:
    """Return the integral of i . k over time."""
    found: NDArray[np.float64] = np.cumsum(T_s * (i_A * k.conj()).real)
    return found
