"""The catalogue of analyses: each measures what it says with the channels that it names."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from benchtool.analysis import analyze_steady_state
from benchtool.analysis.catalogue import STEADY, Analysis, Window, analyses_of, response_names, step_names
from benchtool.analysis.specimen import SPECIMEN_MOTOR, steady_specimen
from benchtool.block import Block
from benchtool.plan.operating_point import NAMES as REACHED
from benchtool.results.steady_state import assess_steady_state

PAGE = (Path(__file__).parents[3] / "docs" / "measurements.md").read_text(encoding="utf-8")
by_title = pytest.mark.parametrize("analysis", STEADY, ids=lambda analysis: analysis.title)


def _only(block: Block, names: tuple[str, ...]) -> Block:
    kept = [number for number, channel in enumerate(block.channels) if channel.name in names]
    return replace(block, channels=tuple(block.channels[k] for k in kept), data=block.data[:, kept])


@by_title
def test_an_analysis_needs_the_channels_that_it_names_and_no_others(analysis: Analysis) -> None:
    block, transducer = steady_specimen()
    window = Window.of(
        _only(block, analysis.channels or ("psi_s",)),
        SPECIMEN_MOTOR,
        transducer if analysis.transducer else None,
    )
    found = [each.name for each in analysis.measure(window).measurements]
    assert [name for name in found if name in analysis.names] == list(analysis.names)
    assert all(analysis.measures(name) for name in found)
    assert analysis.possible(frozenset(analysis.channels), transducer=True)
    for channel in analysis.channels:
        assert not analysis.possible(frozenset(analysis.channels) - {channel}, transducer=True)


def test_a_steady_state_measures_what_the_catalogue_says_and_nothing_else() -> None:
    block, transducer = steady_specimen()
    steady, further = assess_steady_state(block, SPECIMEN_MOTOR, transducer)
    found = [each.name for each in (*steady.measurements, *further.measurements)]
    assert len(set(found)) == len(found)
    assert all(len(list(analyses_of(name))) == 1 for name in found)
    assert {name for analysis in STEADY for name in analysis.names} <= set(found)


def test_names_that_hang_on_the_data_are_known_by_their_pattern() -> None:
    assert [each.title for each in analyses_of("torque_order_118")] == ["torque orders"]
    assert not list(analyses_of("torque_order_0"))
    assert not list(analyses_of("torque_order_x"))


def test_every_name_is_on_the_page() -> None:
    """Written out, or shortened as `plateau_mean`, `_min`."""
    names = {name for analysis in STEADY for name in analysis.names if not name.startswith("true_torque_")}
    for name in sorted({*names, *step_names(), *response_names(), *REACHED}):
        stem, _, last = name.rpartition("_")
        shortened = re.search(
            rf"`{re.escape(stem.rpartition('_')[0] or stem)}\w*`(, `_\w+`)*, `_{last}`", PAGE
        )
        assert f"`{name}`" in PAGE or shortened, name


def test_without_a_current_nothing_raises_and_the_rest_is_the_same() -> None:
    block, transducer = steady_specimen()
    whole = analyze_steady_state(block, pole_pairs=4, torque_rated_Nm=2.0, transducer=transducer)
    for channels in (("torque", "theta_m"), ("psi_s",), ("omega_m",), ("switching_count",)):
        steady = analyze_steady_state(_only(block, channels), pole_pairs=4, torque_rated_Nm=2.0)
        assert steady.names < whole.names
        for each in steady.measurements:
            assert each.value == whole[each.name].value
