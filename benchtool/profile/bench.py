"""The `[bench]` section of a profile: equipment, sensors and their certificates."""

from __future__ import annotations

import math
import re
from datetime import date
from typing import Annotated, Any, Final, Self

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)

from benchtool.document import Section
from benchtool.profile.equipment import Load, Supply, Temperature, Transducer
from benchtool.profile.motor import NotNegative, Positive

UNITS: Final = {"A": "A", "V": "V", "Nm": "Nm", "Wb": "Wb", "rad": "rad", "rad_s": "rad/s"}
"""Units of channels, by the end of a key."""

_WITH_UNIT: Final = ("offset_U", "offset_limit", "resolution")
_ANGLE: Final = "theta_m"
_GAIN_OF_AN_ANGLE: Final = (
    "has an uncertainty of its gain, and an angle is exact after a whole revolution: state that of its offset"
)
_ROOT_3: Final = math.sqrt(3.0)


class Instrument(Section):
    """Identification of an instrument, and the validity of its calibration.

    `k` is the coverage factor with which its certificate states an expanded uncertainty U; `due` is the day
    of the next calibration.
    """

    sensor: str = ""
    """Type of the instrument."""
    serial_number: str = ""
    """Its serial number."""
    certificate: str = ""
    """Number of its calibration certificate."""
    calibrated: date | None = None
    """Day of its calibration."""
    due: date | None = None
    """Day of its next calibration; reports tell of one that is overdue."""
    k: Annotated[float, Field(ge=1.0, le=5.0)] = 2.0
    """Coverage factor of the expanded uncertainties that the certificate states."""

    @field_validator("calibrated", "due", mode="before")
    @classmethod
    def _is_a_date(cls, due: object, info: ValidationInfo) -> object:
        if not isinstance(due, str):
            return due
        if info.mode == "json":  # which has no dates
            return date.fromisoformat(due)
        raise ValueError("a date without quotes is expected, such as 2027-03-01")

    @model_validator(mode="after")
    def _due_after_calibration(self) -> Self:
        if self.calibrated is not None and self.due is not None and self.due < self.calibrated:
            raise ValueError(f"due on {self.due}, before it was calibrated on {self.calibrated}: correct one")
        return self

    @property
    def label(self) -> str:
        """Sensor, serial number and certificate in words; empty where none is stated."""
        number = f"no. {self.serial_number}" if self.serial_number else ""
        certificate = f"certificate {self.certificate}" if self.certificate else ""
        return ", ".join(part for part in (self.sensor, number, certificate) if part)

    def overdue(self, on: date) -> bool:
        """Return whether the next calibration was due before this day."""
        return self.due is not None and self.due < on


class Sensor(Instrument):
    """Sensor of one channel and its errors (JCGM 100:2008, 4.3).

    The reading is (1 + gain error) x value + offset error. Each error is stated in one of two ways: as an
    expanded uncertainty of a certificate (`gain_U_percent`, `offset_U_A`; u = U / k, 4.3.3), or as the limits
    of error of a data sheet (`gain_limit_percent`, `offset_limit_A`: a half-width, rectangular,
    u = limit / sqrt(3), 4.3.7). The gain is relative to the reading, offset and `resolution_A` are in the
    channel's unit, in which their keys end. `bandwidth_Hz` is where the sensor has lost 3 dB: a guarantee,
    and half of what it may have taken off is corrected, unless `bandwidth_tolerance_percent` states that its
    response is that of a first-order lag, and how well it is known; its whole loss is corrected then.
    """

    gain_U_percent: NotNegative | None = None
    """Expanded uncertainty of the gain, of the reading, by the certificate."""
    gain_limit_percent: NotNegative | None = None
    """Limits of error of the gain, of the reading, by the data sheet."""
    offset_U: NotNegative | None = None
    """Expanded uncertainty of the offset. The key ends in the channel's unit: `offset_U_A`."""
    offset_limit: NotNegative | None = None
    """Limits of error of the offset. The key ends in the channel's unit: `offset_limit_A`."""
    resolution: NotNegative | None = None
    """Step of the reading. The key ends in the channel's unit: `resolution_A`."""
    bandwidth_Hz: Positive | None = None
    """Where the sensor has lost 3 dB at most: a guarantee, or with `bandwidth_tolerance_percent` where its
    response, that of a first-order lag, has lost them."""
    bandwidth_tolerance_percent: Annotated[float, Field(ge=0, le=50)] | None = None
    """Limits of error of the bandwidth, of a response that was found to be a first-order lag's."""
    unit: str = ""
    """Unit of the keys."""

    @model_validator(mode="before")
    @classmethod
    def _units_of_keys(cls, content: Any) -> Any:
        """Take the unit off `offset_U_A`, `offset_limit_A` and `resolution_A`."""
        if not isinstance(content, dict):
            return content
        found: dict[str, Any] = {}
        units: dict[str, str] = {}
        for key, value in content.items():
            stem = next((each for each in _WITH_UNIT if re.fullmatch(f"{each}(_.*)?", str(key))), "")
            if not stem:
                found[key] = value
                continue
            ending = str(key)[len(stem) + 1 :]
            if ending not in UNITS:
                known = ", ".join(f"{stem}_{each}" for each in UNITS)
                raise ValueError(f"'{key}' does not end in its channel's unit, one of {known} is expected")
            found[stem], units[key] = value, UNITS[ending]
        if len(set(units.values())) > 1:
            raise ValueError(f"{', '.join(units)} end in different units, those of one channel are expected")
        if "unit" in content:
            raise ValueError("the unit is that of the keys, such as offset_U_A: leave out 'unit'")
        return found | ({"unit": next(iter(units.values()))} if units else {})

    @model_serializer(mode="wrap")
    def _keys_with_units(self, fields: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Put the unit behind the keys again, as a document has them."""
        ending = next((ending for ending, unit in UNITS.items() if unit == self.unit), "")
        return {
            f"{key}_{ending}" if key in _WITH_UNIT else key: value
            for key, value in fields(self).items()
            if key != "unit" and not (key in _WITH_UNIT and value is None)
        }

    @model_validator(mode="after")
    def _stated_once(self) -> Sensor:
        for of, pair in (
            ("gain", (self.gain_U_percent, self.gain_limit_percent)),
            ("offset", (self.offset_U, self.offset_limit)),
        ):
            if None not in pair:
                raise ValueError(
                    f"both {of}_U and {of}_limit: state what the certificate says, or the limits"
                )
        if self.bandwidth_tolerance_percent is not None and self.bandwidth_Hz is None:
            raise ValueError("bandwidth_tolerance_percent without a bandwidth_Hz: state both, or neither")
        return self

    @property
    def gain_standard(self) -> float:
        """Standard uncertainty of the gain, relative; 0 where nothing is stated."""
        return 0.01 * self._standard(self.gain_U_percent, self.gain_limit_percent)

    @property
    def offset_standard(self) -> float:
        """Standard uncertainty of the offset in the channel's unit; 0 where nothing is stated."""
        return self._standard(self.offset_U, self.offset_limit)

    def misfit(self, unit: str) -> str:
        """Return why this cannot be the sensor of a channel in a unit, as half a sentence behind its name;
        empty if it can."""
        if self.unit and not unit:
            return f"has no unit, its offset or resolution is in {self.unit}: leave them out"
        if self.unit and self.unit != unit:
            return f"is in {unit}, its offset or resolution in {self.unit}: state them in the channel's unit"
        return _GAIN_OF_AN_ANGLE if unit == UNITS["rad"] and self.gain_standard > 0.0 else ""

    @property
    def gain_text(self) -> str:
        """What is stated of the gain."""
        return self._text(self.gain_U_percent, self.gain_limit_percent, "%")

    @property
    def offset_text(self) -> str:
        """What is stated of the offset."""
        return self._text(self.offset_U, self.offset_limit, self.unit)

    def _standard(self, expanded: float | None, limit: float | None) -> float:
        if expanded is not None:
            return expanded / self.k
        return 0.0 if limit is None else limit / _ROOT_3

    def _text(self, expanded: float | None, limit: float | None, unit: str) -> str:
        if expanded is not None:
            return f"U = {expanded:g} {unit}, k = {self.k:g}"
        return "" if limit is None else f"limits of {limit:g} {unit}, rectangular"


class ReferenceClock(Instrument):
    """The clock by which the drive samples: the limits of its relative error, rectangular."""

    tolerance_ppm: NotNegative
    """Limits of the relative error of the drive's clock."""

    @property
    def relative_standard(self) -> float:
        """Standard uncertainty of its period, relative."""
        return 1e-6 * self.tolerance_ppm / _ROOT_3


class Bench(Section):
    """The bench: its equipment, the sensor of each channel, by the channel's name, and the drive's clock.

    Equipment is None where the profile leaves its table out, see `benchtool.profile.equipment`.

    The drive's channels are those of its dictionary, its estimates among them; that of a torque transducer is
    `torque_transducer`.
    """

    load: Load | None = None
    """What loads the shaft."""
    transducer: Transducer | None = None
    """The torque transducer on the shaft."""
    supply: Supply | None = None
    """The instrument that measures the dc link."""
    temperature: Temperature | None = None
    """The thermometers."""
    channels: dict[str, Sensor] = Field(default_factory=dict)
    """The sensor of each channel, by the channel's name."""
    clock: ReferenceClock | None = None
    """The clock by which the drive samples."""

    @model_validator(mode="after")
    def _an_angle_has_no_gain(self) -> Bench:
        angle = self.channels.get(_ANGLE)
        if angle is not None and angle.gain_standard > 0.0:
            raise ValueError(f"channels.{_ANGLE} {_GAIN_OF_AN_ANGLE}")
        return self
