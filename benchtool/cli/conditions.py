"""The conditions of a recording, as options of a verb state them."""

from __future__ import annotations

from collections.abc import Sequence

from benchtool.cli.options import require_temperature
from benchtool.recording import Conditions


def conditions(
    operator: str, serial_number: str, temperature_degC: float | None, instruments: Sequence[str]
) -> Conditions:
    """Return what the operator states of a test; an empty text states nothing.

    Raises:
        UsageError: the temperature is not finite.
    """
    require_temperature(temperature_degC)
    return Conditions(
        operator=operator,
        test_object_serial_number=serial_number,
        temperature_degC=temperature_degC,
        instruments=tuple(filter(str.strip, instruments)),
    )
