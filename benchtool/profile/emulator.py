"""The emulated bench as a profile states it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from benchtool.document import Section
from benchtool.profile.motor import NotNegative, Positive


class TrueMotor(Section):
    """The machine as it really is on the emulated bench; what is left out is as in `[motor]`."""

    R_s_ohm: NotNegative | None = None
    L_d_H: Positive | None = None
    L_q_H: Positive | None = None
    psi_r_Wb: Positive | None = None
    J_kgm2: Positive | None = None
    friction_Nms: NotNegative = 0.0
    coulomb_Nm: NotNegative = 0.0
    cogging_Nm: NotNegative = 0.0
    cogging_order: Annotated[int, Field(ge=0)] = 0


class Inverter(Section):
    """The emulated power stage."""

    u_dc_V: Positive
    dc_link_R_ohm: NotNegative = 0.0
    dead_time_s: NotNegative = 0.0
    device_drop_V: NotNegative = 0.0


class Sensors(Section):
    """The emulated current, voltage and position measurement."""

    adc_bits: Annotated[int, Field(ge=4, le=24)] = 10
    i_full_scale_A: Positive
    u_full_scale_V: Positive
    current_noise_A_rms: NotNegative = 0.0
    encoder_lines: Annotated[int, Field(gt=0)] = 2500
    encoder_offset_rad: float = 0.0

    def full_scales(self) -> Mapping[str, float]:
        """Ends of the converter's ranges, by the keys of the objects that tell of them."""
        return {"i_full_scale_A": self.i_full_scale_A, "u_dc_full_scale_V": self.u_full_scale_V}


class Emulator(Section):
    """The emulated bench: true values, which control never sees."""

    motor: TrueMotor = TrueMotor()
    inverter: Inverter
    sensors: Sensors
