"""Waived limits and requirements of plans: they are judged and told, and do not count for the whole."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from benchtool.plan import JudgedLimit, Limit, Verdict, Waived

WAIVED = Waived(reason="new filter", by="ann")


@pytest.mark.parametrize(
    ("value", "verdict", "counted"),
    [
        (0.5, Verdict.PASS, Verdict.PASS),
        (1.5, Verdict.FAIL, Verdict.NONE),
        (None, Verdict.FAIL, Verdict.NONE),
    ],
)
def test_a_waived_limit_is_judged_and_does_not_count(
    value: float | None, verdict: Verdict, counted: Verdict
) -> None:
    limit = Limit(max=1.0, waived=WAIVED, requirement="SRS-1")
    assert limit.judge(value) is verdict
    assert limit.counted(verdict) is counted
    assert Limit(max=1.0).counted(verdict) is verdict


def test_a_limit_says_in_json_who_waives_it() -> None:
    limit = Limit(max=1.0, waived=WAIVED, requirement="SRS-1")
    document = JudgedLimit.of("x", limit, None).to_json()
    assert document["waived"] == {"reason": "new filter", "by": "ann"}
    assert document["requirement"] == "SRS-1"
    assert "waived" not in JudgedLimit.of("x", Limit(max=1.0), None).to_json()


@pytest.mark.parametrize("waived", [{"reason": "", "by": "ann"}, {"reason": "x"}, {"by": "ann"}])
def test_a_waiver_has_a_reason_and_a_name(waived: dict[str, str]) -> None:
    with pytest.raises(ValidationError):
        Limit.model_validate({"max": 1.0, "waived": waived})
