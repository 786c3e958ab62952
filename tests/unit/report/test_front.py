"""What the page that is signed says of what was not measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np

from benchtool.block import Block
from benchtool.recording import Bundle
from benchtool.report.assembly.front import _not_run
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
