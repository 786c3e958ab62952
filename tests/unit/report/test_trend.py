"""Trends: which measurements are drawn over what, with which bars, dots and limits."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.markers import CARETDOWNBASE

from benchtool.analysis import Measurement, Uncertainty
from benchtool.block import Block, Channel
from benchtool.plan.cases import cases
from benchtool.plan.model import Plan
from benchtool.report.assembly.figures import run_figures
from benchtool.report.assembly.trends import trend_names, trend_of
from benchtool.report.figures.labels import channel_label, measurement_label, swept_label
from benchtool.report.figures.trend import REPETITION, Point, Trend, draw_trend
from benchtool.results.assessment import Assessment
from benchtool.results.judged_repetitions import limits_alone

CAPTURE = Block((Channel("torque", "Nm"),), 0, 1, 1e-4, np.zeros((10, 1)))


def plan(**changes: Any) -> Plan:
    return Plan.model_validate(
        {
            "title": "a plan",
            "profile": "zhu2011",
            "operating_point": {"omega_m_rad_s": 15.71},
            "record": {"duration_s": 0.1, "channels": ("torque",)},
            "limits": {"torque_ripple_pp": {"max": 0.5}},
            **changes,
        }
    )


def results(of: Plan, *values: float) -> list[Assessment]:
    """An assessment of each case, with these ripples."""
    return [
        Assessment(
            case.name,
            Path(),
            (Measurement("torque_ripple_pp", value, "Nm", "", uncertainty=Uncertainty(0.01, "")),),
            (),
            limits_alone(of, case),
            {},
            CAPTURE,
            None,
            None,
            coordinates=case.coordinates,
        )
        for case, value in zip(cases(of), values, strict=True)
    ]


LOADS = {"setup": {"law": ("tpc", "foc")}, "operating_point": {"load_torque_Nm": (2.0, 0.5)}}


def levels(axes: Axes) -> list[float]:
    return [
        float(np.asarray(line.get_ydata())[0])
        for line in axes.lines
        if str(line.get_label()).startswith("limit")
    ]


def test_a_sweep_has_a_line_for_each_law_over_the_swept_number() -> None:
    swept = plan(sweep=LOADS)
    trend = trend_of(swept, results(swept, 0.1, 0.2, 0.3, 0.4), "torque_ripple_pp")
    assert trend.key == "load_torque_Nm"
    assert {name: [(each.x, each.value) for each in points] for name, points in trend.series.items()} == {
        "tpc": [(2.0, 0.1), (0.5, 0.2)],
        "foc": [(2.0, 0.3), (0.5, 0.4)],
    }
    (axes,) = draw_trend(trend, "title").axes
    assert axes.get_xlabel() == "load torque $T_L$ (Nm)"
    assert axes.get_ylabel() == "torque ripple, peak to peak (Nm)"
    assert levels(axes) == [0.5]
    container = axes.containers[0]
    assert container.has_yerr  # type: ignore[attr-defined]
    bars = np.asarray(container[2][0].get_segments())
    assert np.ptp(bars[0][:, 1]) == pytest.approx(2 * 1.96 * 0.01, rel=1e-3)
    legend = axes.get_legend()
    assert legend is not None
    box = legend.get_window_extent()
    assert box.y0 >= axes.get_window_extent().y1 - 1.0, "the legend is above the data"


def test_lists_that_go_together_are_one_line() -> None:
    sweep = {
        "order": "list",
        "setup": {"u_s_V": (50.0, 60.0, 70.0)},
        "operating_point": {"load_torque_Nm": (0.1, 0.2, 0.3)},
    }
    swept = plan(sweep=sweep)
    trend = trend_of(swept, results(swept, 0.1, 0.2, 0.3), "torque_ripple_pp")
    assert list(map(len, trend.series.values())) == [3]


def test_repetitions_are_a_mean_with_dots() -> None:
    swept = plan(sweep=LOADS, repetitions=3, judge="mean")
    values = [0.1, 0.2, 0.3, *[0.4] * 9]
    trend = trend_of(swept, results(swept, *values), "torque_ripple_pp")
    first, *_ = trend.series["tpc"]
    assert first.value == pytest.approx(0.2)
    assert (first.single, first.greatest) == ((0.1, 0.2, 0.3), 0.5)
    assert first.expanded == pytest.approx(
        4.303 * 0.1 / np.sqrt(3), rel=1e-3
    )  # Student, two degrees of freedom


def test_repetitions_of_one_case_are_drawn_in_their_order() -> None:
    repeated = plan(repetitions=3)
    trend = trend_of(repeated, results(repeated, 0.1, 0.3, 0.2), "torque_ripple_pp")
    assert trend.key == REPETITION
    ((points),) = trend.series.values()
    assert [(each.x, each.value) for each in points] == [(1, 0.1), (2, 0.3), (3, 0.2)]
    assert draw_trend(trend, "title").axes[0].get_xlabel() == "repetition"


def test_variants_without_a_number_stand_by_their_names() -> None:
    varied = plan(variants=({"name": "cold"}, {"name": "warm", "setup": {"R_s_ohm": 0.2}}))
    trend = trend_of(varied, results(varied, 0.1, 0.2), "torque_ripple_pp")
    (axes,) = draw_trend(trend, "title").axes
    assert [text.get_text() for text in axes.get_xticklabels()] == ["cold", "warm"]


def test_limits_of_single_cases_stand_at_their_points() -> None:
    points = (Point(1.0, 0.1, greatest=0.3), Point(2.0, 0.2, greatest=0.4))
    (axes,) = draw_trend(Trend("torque_mean", "Nm", "load_torque_Nm", {"a": points}), "title").axes
    drawn = [np.asarray(line.get_xydata()) for line in axes.lines]
    short = [each for each in drawn if each.shape == (2, 2) and each[0, 1] == each[1, 1]]
    assert [each[0, 1] for each in short] == [0.3, 0.4]
    assert [float(each[:, 0].mean()) for each in short] == [1.0, 2.0]


@pytest.mark.parametrize(
    ("values", "scale"), [((0.1, 0.5), "linear"), ((0.01, 0.5), "log"), ((-0.01, 0.5), "linear")]
)
def test_the_scale_is_logarithmic_over_decades_only(values: tuple[float, float], scale: str) -> None:
    points = tuple(Point(float(place), value) for place, value in enumerate(values))
    assert (
        draw_trend(Trend("torque_mean", "Nm", "x_Nm", {"a": points}), "title").axes[0].get_yscale() == scale
    )


def test_what_is_judged_has_a_trend_whether_or_not_the_plan_asks_for_a_figure() -> None:
    swept = plan(sweep=LOADS)
    found = results(swept, 0.1, 0.2, 0.3, 0.4)
    assert list(run_figures(swept, found)) == ["trend_torque_ripple_pp"]
    assert list(run_figures(plan(sweep=LOADS, figure="sweep"), found)) == ["cases"]
    assert trend_names(swept, found[:1]) == ()
    assert trend_names(plan(sweep=LOADS, limits={}), found) == ("torque_ripple_pp",)  # asked for first


@pytest.mark.parametrize(
    ("key", "label"),
    [
        ("load_torque_Nm", "load torque $T_L$ (Nm)"),
        ("omega_m_rad_s", r"mechanical speed $\omega_m$ (rad/s)"),
        ("R_s_ohm", "stator resistance $R_s$ (ohm)"),
        ("inverter.dead_time_s", "inverter dead time (s)"),
        ("K_p_speed_Nms_rad", "K p speed (Nms/rad)"),
        ("T_k_ratio", "share of the control period $T_k/T_s$"),
        ("i_trip_A", "i trip (A)"),
    ],
)
def test_swept_keys_are_told_in_words_with_their_units(key: str, label: str) -> None:
    assert swept_label(key) == label
    assert "_" not in label.replace("$T_L$", "").replace(r"$\omega_m$", "").replace("$R_s$", "").replace(
        "$T_k/T_s$", ""
    )


def test_channels_and_measurements_are_told_in_words() -> None:
    assert channel_label("torque", "Nm") == "torque $T$ (Nm)"
    assert channel_label("law_clipped", "") == "law clipped"
    assert channel_label("cost$", "A") == r"cost\$ (A)"
    assert (
        measurement_label("transducer_torque_ripple_rms", "Nm")
        == "torque ripple, rms, by the transducer (Nm)"
    )
    assert measurement_label("torque_ripple_percent_of_mean", "%") == "torque ripple, percent of mean (%)"
    assert measurement_label("current_thd_f", "%") == "current THD-F (%)"


def test_what_is_only_known_to_be_less_than_a_bound_is_drawn_there() -> None:
    """Such points were left out without a word."""
    swept = plan(sweep={"operating_point": {"load_torque_Nm": (0.5, 1.0)}})
    found = results(swept, 0.3, math.nan)
    hidden = replace(found[1].measurements[0], below=0.2, uncertainty=None)
    found[1] = replace(found[1], measurements=(hidden,))
    trend = trend_of(swept, found, "torque_ripple_pp")
    ((value, bound),) = trend.series.values()
    assert (value.value, value.is_bound) == (0.3, False)
    assert (bound.value, bound.is_bound) == (0.2, True)
    figure = draw_trend(trend, "title")
    downwards = [line for line in figure.axes[0].lines if line.get_marker() == CARETDOWNBASE]
    assert [np.asarray(line.get_ydata()).tolist() for line in downwards] == [[0.2]]
    assert "triangles: less than at their base" in " ".join(text.get_text() for text in figure.texts)
