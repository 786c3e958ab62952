"""What a case of a plan does not measure has a reason: by title, and by name where a limit asks for it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from benchtool.plan import Plan
from benchtool.plan.limits import Verdict
from benchtool.results.case_assessment import assess
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR, steady_capture


def test_orders_of_too_few_revolutions_are_told_once_and_where_they_are_limited() -> None:
    block, _ = steady_capture()
    plan = Plan.model_validate(
        {
            "title": "x",
            "profile": "zhu2011",
            "operating_point": {"omega_m_rad_s": 78.54},
            "record": {"duration_s": 0.1, "channels": ["torque", "omega_m", "theta_m"]},
            "limits": {"torque_order_6p": {"max": 1.0}},
        }
    )
    found = assess(plan, "", EXAMPLE_MOTOR, Path(), replace(block, data=block.data[:1000]), None)
    reason = (
        "'theta_m' covers 1.25 mechanical revolutions, at least 2 are needed for orders: "
        "record a longer window"
    )
    assert found.refused == {"torque orders": reason, "speed orders": reason}
    document = found.to_json()
    assert document["refused"] == {"torque orders": reason, "speed orders": reason}
    assert document["not_measured"] == {}  # which has the channels that an analysis lacks
    assert [name for name in found.found if "torque_order" in name] == ["torque_order_6p"]
    assert math.isnan(found.found["torque_order_6p"].value)
    assert found.found["torque_order_6p"].reason == reason
    assert found.verdicts["torque_order_6p"] is Verdict.FAIL
    assert any(reason in str(each) for each in found.missed)
