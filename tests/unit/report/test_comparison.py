"""Figures that set cases side by side: a panel for each, the same axes, labels where they belong."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis import SteadyState, analyze_steady_state
from benchtool.analysis.declaration import Panel
from benchtool.block import Block, Channel
from benchtool.report.figures.comparison import draw_spectra, draw_steady_traces, draw_torque_traces

RATE_HZ, P, OMEGA_M = 10_000.0, 4, 15.71


def _capture(seed: int) -> Block:
    rows = np.arange(5200)
    noise = np.random.default_rng(seed).normal(size=(3, len(rows)))
    theta_m = OMEGA_M * rows / RATE_HZ
    columns = {
        Channel("torque", "Nm"): 0.65 + 0.01 * noise[0],
        Channel("torque_reference", "Nm"): np.where(rows < 100, 0.0, 0.65),
        Channel("i_a", "A"): 0.64 * np.cos(P * theta_m) + 0.001 * noise[1],
        Channel("psi_s", "Wb"): 0.1686 + 1e-4 * noise[2],
        Channel("theta_m", "rad"): np.mod(theta_m, 2 * np.pi),
        Channel("omega_m", "rad/s"): np.linspace(0.0, 20.0, len(rows)),
        Channel("switching_count", ""): 3.0 * rows,
    }
    return Block(tuple(columns), 0, 1, 1.0 / RATE_HZ, np.column_stack(list(columns.values())))


@pytest.fixture
def panels() -> list[Panel]:
    captures = [_capture(seed) for seed in (1, 2)]
    return [
        Panel(name, capture, analyze_steady_state(capture, pole_pairs=P, torque_rated_Nm=9.55))
        for name, capture in zip(("first", "second"), captures, strict=True)
    ]


def test_torque_traces_are_stacked_on_the_same_axes(panels: list[Panel]) -> None:
    figure = draw_torque_traces(panels, "title")
    torque = [axes for axes in figure.axes if axes.get_ylabel() == "torque $T$ (Nm)"]
    speed = [axes for axes in figure.axes if axes.get_ylabel() == r"mechanical speed $\omega_m$ (rad/s)"]
    assert (len(torque), len(speed)) == (2, 2)
    assert torque[0].get_ylim() == torque[1].get_ylim()
    assert [axes.get_title(loc="left") for axes in torque] == ["first", "second"]


def test_steady_traces_have_a_column_for_each_case(panels: list[Panel]) -> None:
    figure = draw_steady_traces(panels, "title")
    labels = [axes.get_ylabel() for axes in figure.axes]
    names = ["torque $T$ (Nm)", "phase current $i_a$ (A)", r"stator flux $\psi_s$ (Wb)"]
    assert labels == [names[0], "", names[1], "", names[2], ""]
    torque = np.asarray(figure.axes[0].lines[0].get_xydata())
    assert torque[-1] == pytest.approx((0.5199, panels[0].capture.column("torque")[-1]))  # all of the capture
    assert torque[:, 1].max() == panels[0].capture.column("torque").max()


def test_spectra_name_the_fundamental_and_the_largest_other(panels: list[Panel]) -> None:
    steady = panels[0].steady
    assert isinstance(steady, SteadyState)
    figure = draw_spectra([*panels, Panel("transient", panels[0].capture)], "title")
    assert len(figure.axes) == 2
    assert figure.axes[0].get_title(loc="left").startswith("first: fundamental 0.64 A, largest other")
