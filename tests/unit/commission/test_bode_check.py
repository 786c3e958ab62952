"""Which measured margins keep a loop from being saved."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.commission.tuning.bode_check import deviations
from benchtool.commission.tuning.margins import Margins

DESIGN = Margins(
    crossover_rad_s=2.0 * math.pi * 10.0, phase_rad=math.radians(60.0), gain=30.0, sensitivity=1.2
)


def measured(**values: tuple[float, float]) -> dict[str, Measurement]:
    """Numbers of a loop as designed, but for these: value and standard uncertainty."""
    told = {
        "crossover": (10.1, 0.1),
        "phase_margin": (59.0, 1.0),
        "gain_margin": (29.0, 1.0),
        "sensitivity_peak": (1.2, 0.05),
        "attenuation": (40.0, 0.0),
        "sensitivity_seen": (1.1, 0.0),
        **values,
    }
    return {
        f"loop_{name}": Measurement(
            f"loop_{name}", value, "", "", uncertainty=Uncertainty(u, "scatter", 10.0) if u else None
        )
        for name, (value, u) in told.items()
    }


@pytest.mark.parametrize(
    ("values", "wrong"),
    [
        ({}, []),
        ({"crossover": (11.5, 0.1)}, ["crossover"]),
        ({"crossover": (math.nan, 0.0)}, ["crossover"]),
        ({"phase_margin": (66.0, 1.0)}, ["phase margin"]),
        ({"gain_margin": (4.0, 1.0)}, ["gain margin"]),
        ({"gain_margin": (-10.0, 300.0)}, []),
        ({"gain_margin": (-10.0, 300.0), "attenuation": (3.0, 0.0)}, ["attenuation"]),
        ({"sensitivity_peak": (2.4, 0.2)}, ["sensitivity peak"]),
        ({"sensitivity_peak": (9.0, 7.0), "sensitivity_seen": (2.2, 0.0)}, ["sensitivity seen"]),
    ],
)
def test_a_margin_that_is_told_counts_and_else_what_the_frequencies_used_tell(
    values: dict[str, tuple[float, float]], wrong: list[str]
) -> None:
    findings = deviations(measured(**values), "loop", DESIGN)
    assert [name for name in wrong if any(each.what.startswith(name) for each in findings)] == wrong
    assert len(findings) == len(wrong)
    assert all(each.fails for each in findings)
