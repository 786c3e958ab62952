"""What the direction of an encoder says beside what the profile states of it."""

from __future__ import annotations

import pytest

from benchtool.analysis import Measurement
from benchtool.commission.known import Known
from benchtool.commission.steps.encoder import DraggedRotor
from benchtool.profile import load_profile

MOTOR = load_profile("zhu2011").motor


@pytest.mark.parametrize(
    ("counts", "stated", "what"),
    [
        (1.0, None, None),
        (1.0, "forward", None),
        (-1.0, None, "counts down"),
        (-1.0, "forward", "counts down"),
        (-1.0, "reverse", None),
        (1.0, "reverse", "counts up"),
    ],
)
def test_a_direction_is_told_of_unless_the_profile_states_it(
    counts: float, stated: str | None, what: str | None
) -> None:
    held = {} if stated is None else {"encoder_direction": stated}
    known = Known(MOTOR, 1e-4, 120.0, held=held)
    values = {"encoder_direction": counts, "friction_lag": 0.0}
    values |= {f"eccentricity_1_{part}": 0.0 for part in ("cos", "sin")}
    found = {name: Measurement(name, value, "", "") for name, value in values.items()}
    findings = DraggedRotor().findings(found, known)
    assert [what is not None and what in each.what for each in findings] == ([] if what is None else [True])
