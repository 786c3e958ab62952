"""What a report says at the front and over all cases of what was not measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np

from benchtool.analysis import Measurement
from benchtool.block import Block
from benchtool.recording import Bundle
from benchtool.report.assembly.front import _not_run
from benchtool.report.assembly.plan import _lacking
from benchtool.report.content import Text
from benchtool.results import Assessment, RecordedCase

BLOCK = Block.from_arrays(1000.0, {"torque": "Nm"}, torque=np.zeros(4))
ORDERS = "'theta_m' covers 1.30 mechanical revolutions, at least 2 are needed"


def case(name: str, **refused: str) -> RecordedCase:
    assessment = Assessment(name, Path("bundle"), (), (), {}, {}, BLOCK, None, None)
    titles = {title.replace("_", " "): reason for title, reason in refused.items()}
    return RecordedCase(name, cast(Bundle, SimpleNamespace()), replace(assessment, refused=titles))


def told(*cases: RecordedCase) -> list[str]:
    return [item.text for item in _not_run((), cases) if isinstance(item, Text)]


def test_analyses_that_the_rows_do_not_allow_stand_on_the_first_page() -> None:
    alone = case("A", torque_orders=ORDERS, speed_orders=ORDERS)
    assert told(alone) == [f"Not measured: torque orders, speed orders: {ORDERS}."]
    other = case("B", torque_orders=ORDERS.replace("1.30", "1.31"))
    assert told(case("A", torque_orders=ORDERS), other, case("C")) == [
        f"Not measured: torque orders: {ORDERS} (2 of 3 cases)."
    ]


def test_a_dash_in_the_overview_of_cases_has_its_reason_below() -> None:
    def measured(name: str, reason: str, uncertain: str) -> Assessment:
        found = (
            Measurement.undefined("bandwidth_3dB", "Hz", "", reason),
            Measurement("torque_mean", 1.0, "Nm", "", uncertainty_reason=uncertain),
            Measurement.undefined("elsewhere", "Hz", "", "not in the overview"),
        )
        return Assessment(name, Path("bundle"), found, (), {}, {}, BLOCK, None, None)

    cases = [measured(f"case {n}", "it stays above", "it wanders" if n else "") for n in range(6)]
    assert [each.text for each in _lacking(cases, ["bandwidth_3dB", "torque_mean"])] == [
        "Undefined: bandwidth_3dB of case 0, case 1, case 2, case 3 and 2 more: it stays above.",
        "Without ±: torque_mean of case 1, case 2, case 3, case 4 and 1 more: it wanders.",
    ]
