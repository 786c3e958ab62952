"""Every analysis measures odd signals or refuses them with its own error, and warns of nothing."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import pytest

from benchtool.analysis import Analysis, catalogue
from benchtool.analysis.window import Window
from benchtool.errors import AnalysisError
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR
from tests.unit.analysis.odd_signals import odd_block

SETTINGS: dict[str, dict[str, Any]] = {
    "frequency_response": {"input": "torque_reference", "output": "torque"}
}


def measure(analysis: Analysis[Any], seed: int) -> None:
    window = Window.of(odd_block(seed), EXAMPLE_MOTOR)
    settings = analysis.settings(**SETTINGS.get(analysis.name, {}))
    if analysis.possible(frozenset(window.block.names), settings, transducer=False):
        with suppress(AnalysisError):
            analysis.measure(window, settings)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("analysis", catalogue().analyses, ids=lambda each: each.name)
def test_odd_signals_are_measured_or_refused(analysis: Analysis[Any], seed: int) -> None:
    measure(analysis, seed)


@pytest.mark.slow
@pytest.mark.parametrize("analysis", catalogue().analyses, ids=lambda each: each.name)
def test_many_odd_signals_are_measured_or_refused(analysis: Analysis[Any]) -> None:
    for seed in range(1000, 2000):
        measure(analysis, seed)
