"""A motor: rating and equivalent circuit."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from benchtool.document import Section

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]


class Motor(Section):
    """Rating and equivalent circuit, as the host and the drive's control assume them."""

    pole_pairs: Annotated[int, Field(gt=0, le=50)]
    """Number of pole pairs p; the electrical speed is p times the mechanical one."""
    R_s_ohm: NotNegative
    """Stator resistance of one phase (half of the resistance between two terminals in star connection)."""
    L_d_H: Positive
    """Inductance of one phase along the rotor flux."""
    L_q_H: Positive
    """Inductance of one phase across the rotor flux; equal to `L_d_H` for surface magnets."""
    psi_r_Wb: Positive
    """Rotor flux linkage, peak: the peak phase back-EMF over the electrical speed."""
    J_kgm2: Positive
    """Moment of inertia of everything that turns: rotor, coupling, load machine."""
    T_N_Nm: Positive
    """Rated torque. Plans beyond it are refused; ripple in percent of rated refers to it."""
    omega_m_N_rad_s: Positive
    """Rated mechanical speed: rpm times 0.10472. Plans beyond it are refused."""
    I_N_A_rms: Positive
    """Rated phase current, rms."""
    slots: Annotated[int, Field(gt=0)] | None = None
    """Number of stator slots, which adds the cogging order to the torque orders."""

    @property
    def parameters(self) -> dict[str, float | str]:
        """What a drive holds of it, by TOML key; slots are for the host alone."""
        rated = {"motor_rated_current_A": self.I_N_A_rms}
        return {**self.model_dump(exclude={"I_N_A_rms", "slots"}), **rated}
