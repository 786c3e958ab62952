"""A motor: rating and equivalent circuit."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from benchtool.document import Section

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]


class Motor(Section):
    """Rating and equivalent circuit, as the host and the drive's control believe them."""

    pole_pairs: Annotated[int, Field(gt=0, le=50)]
    R_s_ohm: NotNegative
    L_d_H: Positive
    L_q_H: Positive
    psi_r_Wb: Positive
    J_kgm2: Positive
    T_N_Nm: Positive
    omega_m_N_rad_s: Positive
    I_N_A_rms: Positive
    slots: Annotated[int, Field(gt=0)] | None = None
