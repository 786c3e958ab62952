"""The catalogue of analyses: each measures what it declares, from the channels that it names."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchtool.analysis import analyze_steady_state
from benchtool.analysis.catalogue import BUILT_IN, CORE, catalogue, measure
from benchtool.analysis.declaration import Analysis, Findings, Measured, Quantity
from benchtool.analysis.orders.orders import TORQUE_ORDERS, OrderSettings
from benchtool.analysis.reference_page import filled, main
from benchtool.analysis.torque.residual import RESIDUAL
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.document import Section
from benchtool.errors import UsageError
from benchtool.plan.analyses import Analyses
from benchtool.plan.operating_point import NAMES as REACHED
from benchtool.report.figures.drawings import BY_HAND
from benchtool.results.analyses import measure_all, planned
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR, response_capture, steady_capture, step_capture
from tests.unit.analysis.excited_machine import excited_capture

PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "measurements.md").read_text(encoding="utf-8")
by_name = pytest.mark.parametrize("analysis", BUILT_IN, ids=lambda analysis: analysis.name)


def _only(block: Block, names: tuple[str, ...]) -> Block:
    kept = [number for number, channel in enumerate(block.channels) if channel.name in names]
    return replace(block, channels=tuple(block.channels[k] for k in kept), data=block.data[:, kept])


def _specimen(analysis: Analysis[Any]) -> tuple[Block, Block | None]:
    if analysis.measured is Measured.STEADY_STATE:
        return steady_capture()
    asked: dict[str, Callable[[], Block]] = {
        "step": step_capture,
        "frequency_response": response_capture,
        "flux_balance": excited_capture,
        "motion_balance": excited_capture,
    }
    return (asked[analysis.name](), None) if analysis.name in asked else steady_capture()


def _found(analysis: Analysis[Any]) -> tuple[Findings, Block]:
    """What an analysis finds of the specimen with no other channels than those that it names."""
    block, transducer = _specimen(analysis)
    only = _only(block, analysis.needs(analysis.settings()) or ("psi_s",))
    shaft = transducer if analysis.transducer else None
    return measure(analysis, Window.of(only, EXAMPLE_MOTOR, shaft), analysis.settings()), only


@by_name
def test_an_analysis_needs_the_channels_that_it_names_and_no_others(analysis: Analysis[Any]) -> None:
    found, _ = _found(analysis)
    names = [each.name for each in found.measurements]
    assert [name for name in names if name in analysis.names] == list(analysis.names)
    assert all(analysis.quantity(name) for name in names)
    settings = analysis.settings()
    channels = frozenset(analysis.needs(settings))
    assert analysis.possible(channels, settings, transducer=True)
    for channel in channels:
        assert not analysis.possible(channels - {channel}, settings, transducer=True)


@by_name
def test_every_measurement_has_the_unit_that_is_declared(analysis: Analysis[Any]) -> None:
    found, block = _found(analysis)
    units = {channel.name: channel.unit for channel in block.channels}
    for each in found.measurements:
        quantity = analysis.quantity(each.name)
        assert isinstance(quantity, Quantity)
        unit = quantity.unit
        declared = unit if isinstance(unit, str) else unit.resolve(analysis.settings(), units)
        assert each.unit == declared, each.name
        assert quantity.definition


@by_name
def test_every_figure_is_drawn_by_hand_or_by_its_analysis(analysis: Analysis[Any]) -> None:
    for drawing in (*analysis.figures, *analysis.comparisons):
        assert drawing.draw is not None or drawing.name in BY_HAND
        assert drawing.caption.endswith(".")


def test_a_steady_state_measures_what_the_catalogue_says_and_nothing_else() -> None:
    block, transducer = steady_capture()
    by_analysis = measure_all(tuple(planned(Analyses(), Window.of(block, EXAMPLE_MOTOR, transducer), None)))
    found = [each.name for findings in by_analysis.values() for each in findings.measurements]
    assert list(by_analysis) == [each.name for each in catalogue().steady]
    assert len(set(found)) == len(found)
    for analysis, findings in by_analysis.items():
        for each in findings.measurements:
            assert [one.name for one in BUILT_IN if one.quantity(each.name)] == [analysis]
    assert {name for analysis in catalogue().steady for name in analysis.names} <= set(found)


def test_rows_of_no_single_tick_leave_numbers_of_every_tick_undefined_with_the_reason() -> None:
    block, _ = steady_capture()
    apart = replace(block, stride=2, data=block.data[::2])
    found = measure_all(tuple(planned(Analyses(), Window.of(apart, EXAMPLE_MOTOR, None), None)))
    assert list(found) == [each.name for each in catalogue().steady if not each.transducer]
    assert {each.reason for each in found[RESIDUAL.name].measurements} == {
        "every control tick is needed, these rows are 2 ticks apart"
    }


def test_too_few_revolutions_leave_every_order_undefined_with_the_reason() -> None:
    """Those of the machine, and those that the settings name."""
    block, _ = steady_capture()
    few = replace(block, data=block.data[:1000])
    findings = TORQUE_ORDERS.measure(Window.of(few, EXAMPLE_MOTOR), OrderSettings(orders=(24, 48)))
    names = [each.name for each in findings.measurements]
    assert names == [*TORQUE_ORDERS.names, "torque_order_24", "torque_order_48"]
    for each in findings.measurements:
        assert math.isnan(each.value)
        assert each.reason.startswith("'theta_m' covers 1.25 mechanical revolutions, at least 2 are needed")


def test_what_analyses_share_is_computed_once() -> None:
    block, _ = steady_capture()
    window = Window.of(block, EXAMPLE_MOTOR)
    computed: list[Window] = []

    def compute(of: Window) -> int:
        computed.append(of)
        return len(computed)

    assert (window.cached(compute), window.cached(compute)) == (1, 1)
    assert computed == [window]


def test_names_that_depend_on_the_data_are_known_by_their_pattern() -> None:
    found = catalogue().measuring("torque_order_118")
    assert found is not None
    assert found.title == "torque orders"
    assert catalogue().measuring("torque_order_0") is None
    assert catalogue().measuring("torque_order_x") is None


def test_no_two_analyses_have_a_name_in_common() -> None:
    names = [each.name for each in BUILT_IN]
    measurements = [name for each in BUILT_IN for name in each.names]
    assert len(set(names)) == len(names)
    assert len(set(measurements)) == len(measurements)
    assert all(issubclass(each.settings, Section) for each in BUILT_IN)
    assert catalogue().analyses[: len(CORE)] == CORE


def test_the_tables_of_the_page_are_those_of_the_catalogue(tmp_path: Path) -> None:
    assert filled(PAGE) == PAGE, "run python -m benchtool.analysis.reference_page"
    page = tmp_path / "measurements.md"
    page.write_text(PAGE.replace("max(x) - min(x)", "max(x)"), encoding="utf-8")
    assert main(["--check"], page) == 1
    assert main([], page) == 0
    assert page.read_text(encoding="utf-8") == PAGE


def test_an_analysis_stands_in_one_table_of_the_page_and_a_new_one_among_the_others() -> None:
    for was, now, odd in ((": step -->", ": step step -->", "step"), (": step -->", ": stpe -->", "stpe")):
        with pytest.raises(UsageError, match=f"{odd}: .*in one table"):
            filled(PAGE.replace(was, now))
    assert "**Speed orders** (`speed_orders`)" not in PAGE
    without = filled(PAGE.replace("torque_orders speed_orders", "torque_orders"))
    assert "**Speed orders** (`speed_orders`)" in without
    assert filled(without) == without


def test_every_name_is_on_the_page() -> None:
    """Written out, or shortened as `plateau_mean`, `_min`."""
    names = {name for analysis in BUILT_IN for name in analysis.names}
    for name in sorted({*names, *REACHED}):
        stem, _, last = name.rpartition("_")
        shortened = re.search(
            rf"`{re.escape(stem.rpartition('_')[0] or stem)}\w*`(, `_\w+`)*, `_{last}`", PAGE
        )
        assert f"`{name}`" in PAGE or shortened, name


def test_without_a_current_nothing_raises_and_the_rest_is_the_same() -> None:
    block, transducer = steady_capture()
    whole = analyze_steady_state(block, pole_pairs=4, torque_rated_Nm=2.0, transducer=transducer)
    for channels in (("torque", "theta_m"), ("psi_s",), ("omega_m",), ("switching_count",)):
        steady = analyze_steady_state(_only(block, channels), pole_pairs=4, torque_rated_Nm=2.0)
        assert steady.names < whole.names
        for each in steady.measurements:
            assert each.value == whole[each.name].value
