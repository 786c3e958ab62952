"""Every analysis measures odd signals or refuses them with its own error, and warns of nothing."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import pytest

from benchtool.analysis import Analysis, Measurement, catalogue
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
            for each in analysis.measure(window, settings).measurements:
                require_reasons(each)


def require_reasons(measured: Measurement) -> None:
    """Require a value or the reason why there is none, and an uncertainty or the reason why it has none."""
    assert math.isfinite(measured.value) is not bool(measured.reason), measured.name
    if math.isfinite(measured.value):
        uncertainty = measured.uncertainty
        assert (uncertainty is None) is bool(measured.uncertainty_reason), measured.name
        assert uncertainty is None or math.isfinite(uncertainty.standard + uncertainty.expanded), (
            measured.name
        )


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("analysis", catalogue().analyses, ids=lambda each: each.name)
def test_odd_signals_are_measured_or_refused(analysis: Analysis[Any], seed: int) -> None:
    measure(analysis, seed)


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        ("current_spectrum", 1099),  # infinite
        ("current_spectrum", 1117),  # two samples in a period
        ("current_unbalance", 5405),  # a step of 1e-24 of the current
        ("current_unbalance", 7800),  # whole rows in a period
        ("flux_ripple", 10644),  # no extreme that counts
        ("speed_orders", 1784),  # infinite
        ("speed_orders", 10580),  # one revolution, and the begin of another
        ("step", 5555),  # noise that is 4e11 times as large in some places
        ("step", 300_470),  # clicks beside nothing
        ("torque_ripple", 1022),  # turns back for a moment as it begins
        ("torque_ripple", 7455),  # an infinite reference
    ],
)
def test_signals_that_are_odd_in_one_way_are_measured_or_refused(name: str, seed: int) -> None:
    measure(next(each for each in catalogue().analyses if each.name == name), seed)


@pytest.mark.slow
@pytest.mark.parametrize("analysis", catalogue().analyses, ids=lambda each: each.name)
def test_many_odd_signals_are_measured_or_refused(analysis: Analysis[Any]) -> None:
    for seed in range(1000, 2000):
        measure(analysis, seed)
