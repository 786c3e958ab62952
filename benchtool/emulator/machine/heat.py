"""Heat: temperatures of winding and magnets, an optional part of the bench, and what they change.

Two thermal masses. Copper loss heats the winding, which gives heat to the body of the motor, iron and
magnets; iron loss heats that, and it gives heat to the surroundings:

    C_w dT_w/dt = P_copper - (T_w - T_m) / R_wm
    C_m dT_m/dt = P_iron + (T_w - T_m) / R_wm - (T_m - T_a) / R_ma

Over a tick the losses are constant, for which the equations have a closed form. Resistance and rotor flux
follow once a tick: R_s by +0.393 %/K of copper (IEC 60028: 1/254.5 at 20 degC) and psi_r by -0.11 %/K, of
NdFeB, unless stated otherwise, both from the temperature at which the profile's values hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from benchtool.emulator.jit import njit
from benchtool.errors import ValueRefused

ALPHA_COPPER = 3.93e-3  # 1/K
ALPHA_MAGNET = -1.1e-3


class Heat(NamedTuple):
    """Change of both temperatures in a tick, by both above the surroundings and by both losses."""

    ww: float
    wm: float
    mw: float
    mm: float
    w_copper: float
    w_iron: float
    m_copper: float
    m_iron: float
    T_ambient: float
    T_reference: float
    alpha_R: float
    alpha_psi: float
    R_devices: float  # part of the machine's resistance that is not of copper


@dataclass(frozen=True, kw_only=True)
class HeatTruth:
    """Thermal masses and resistances, and what temperatures change.

    Raises:
        ValueRefused: the winding loses heat to the body so fast that a tick is no small part of it.
    """

    C_winding_J_K: float
    C_body_J_K: float
    R_winding_body_K_W: float
    R_body_ambient_K_W: float
    ambient_degC: float = 25.0
    reference_degC: float = 25.0
    alpha_R_1_K: float = ALPHA_COPPER
    alpha_psi_1_K: float = ALPHA_MAGNET

    def heat(self, T_s: float, R_devices: float) -> Heat:
        """Return the coefficients for ticks of `T_s` seconds."""
        G, G_a = 1.0 / self.R_winding_body_K_W, 1.0 / self.R_body_ambient_K_W
        C = np.array([self.C_winding_J_K, self.C_body_J_K])
        root = np.sqrt(C)
        # Symmetric in sqrt(C) T: its eigenvectors are orthogonal. expm1 keeps all digits of the change.
        rates, modes = np.linalg.eigh(np.array([[-G, G], [G, -G - G_a]]) / np.outer(root, root))
        change = np.expm1(rates * T_s)
        by_state = (modes * change) @ modes.T * np.outer(1.0 / root, root)
        by_loss = (modes * (change / rates)) @ modes.T / np.outer(root, root)
        if not np.isfinite(by_loss).all():
            raise ValueRefused(
                "emulator.motor.heat: its masses and resistances are too far apart to be computed: bring "
                "C_winding_J_K and C_body_J_K, or R_winding_body_K_W and R_body_ambient_K_W, closer together"
            )
        (ww, wm), (mw, mm) = by_state.tolist()
        (w_copper, w_iron), (m_copper, m_iron) = by_loss.tolist()
        return Heat(
            ww,
            wm,
            mw,
            mm,
            w_copper,
            w_iron,
            m_copper,
            m_iron,
            self.ambient_degC,
            self.reference_degC,
            self.alpha_R_1_K,
            self.alpha_psi_1_K,
            R_devices,
        )


@njit
def warm(heat: Heat | None, shaft: Any, copper: float, iron: float, T_s: float) -> None:
    """Change the temperatures by a tick with these losses, in J."""
    if heat is None:
        return
    P_copper, P_iron = copper / T_s, iron / T_s
    w, m = shaft.T_winding - heat.T_ambient, shaft.T_magnet - heat.T_ambient
    shaft.T_winding += heat.ww * w + heat.wm * m + heat.w_copper * P_copper + heat.w_iron * P_iron
    shaft.T_magnet += heat.mw * w + heat.mm * m + heat.m_copper * P_copper + heat.m_iron * P_iron
