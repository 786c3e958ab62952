"""Figures: what they show, and that nothing global is touched."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchtool.analysis import SteadyState, analyze_steady_state
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError, RecordingError
from benchtool.report.figures.steady_state import draw_steady_state, save_figures

SAMPLES = 3000
TICK_S = 1e-4


def capture(*left_out: str) -> Block:
    number = np.arange(SAMPLES, dtype=np.float64)
    theta_e = 2 * np.pi * 20.0 * number * TICK_S
    psi_s = 0.17 + 0.001 * np.cos(6 * theta_e)
    columns: dict[str, tuple[str, NDArray[np.float64]]] = {
        "theta_m": ("rad", np.mod(theta_e / 4, 2 * np.pi)),
        "i_a": ("A", np.cos(theta_e) + 0.02 * np.cos(9.4 * theta_e)),
        "i_b": ("A", np.cos(theta_e - 2 * np.pi / 3)),
        "i_c": ("A", np.cos(theta_e + 2 * np.pi / 3)),
        "torque": ("Nm", 0.65 + 0.03 * np.cos(6 * theta_e)),
        "torque_reference": ("Nm", np.full(SAMPLES, 0.65)),
        "psi_s": ("Wb", psi_s),
        "psi_s_reference": ("Wb", np.full(SAMPLES, 0.17)),
        "psi_alpha": ("Wb", psi_s * np.cos(theta_e)),
        "psi_beta": ("Wb", psi_s * np.sin(theta_e)),
        "switching_count": ("", 2.0 * number),
    }
    kept = {name: column for name, column in columns.items() if name not in left_out}
    channels = tuple(Channel(name, unit) for name, (unit, _) in kept.items())
    return Block(channels, 500, 1, TICK_S, np.stack([column for _, column in kept.values()], axis=1))


def transducer(ticks: int = SAMPLES) -> Block:
    torque = 0.65 + 0.04 * np.cos(np.arange(20.0 * ticks))
    return Block((Channel("torque_transducer", "Nm"),), 20 * 500, 1, TICK_S / 20, torque[:, np.newaxis])


def analyze(block: Block) -> SteadyState:
    return analyze_steady_state(block, pole_pairs=4, torque_rated_Nm=9.55)


def texts(figure: Figure) -> str:
    return "\n".join(
        [text.get_text() for axes in figure.axes for text in axes.texts]
        + [axes.get_ylabel() for axes in figure.axes]
        + [str(label) for axes in figure.axes for label in axes.get_legend_handles_labels()[1]]
    )


def test_figures_show_the_signals_with_units_over_two_periods() -> None:
    block = capture()

    figures = draw_steady_state(block, analyze(block), transducer(), title="a run")

    assert list(figures) == ["waveforms", "current_spectrum", "flux_trajectory"]
    torque, current, flux = figures["waveforms"].axes
    assert flux.get_xlim() == pytest.approx((0.0, 0.1))
    assert [line.get_label() for line in torque.lines] == ["shaft transducer", "estimate", "reference"]
    assert [line.get_label() for line in current.lines] == ["$i_a$", "$i_b$", "$i_c$"]
    for name, unit in {"torque": "Nm", "current": "A", "flux": "Wb"}.items():
        assert any(
            name in label and f"({unit})" in label for label in texts(figures["waveforms"]).split("\n")
        )
    (band,) = torque.patches
    assert band.get_label() == "mean ± rms ripple"
    assert band.get_zorder() > torque.lines[1].get_zorder(), "the estimate would hide it"
    assert all((line.get_alpha() or 1.0) < 1.0 for line in current.lines), "the last would hide the others"
    shown = np.asarray(torque.lines[1].get_ydata())
    np.testing.assert_array_equal(shown, block.column("torque")[: len(shown)])


def test_the_spectrum_marks_fundamental_and_largest_other_component() -> None:
    block = capture()

    shown = texts(draw_steady_state(block, analyze(block), title="a run")["current_spectrum"])

    assert "fundamental 1 A" in shown
    assert "largest other 0.02" in shown
    assert "at 188 Hz" in shown


def test_the_flux_circle_is_the_reference() -> None:
    block = capture()

    (axes,) = draw_steady_state(block, analyze(block), title="a run")["flux_trajectory"].axes

    circle = np.hypot(*np.asarray(axes.lines[1].get_data()))
    assert circle == pytest.approx(np.full(len(circle), 0.17))


def test_optional_channels_may_be_absent() -> None:
    block = capture("i_b", "i_c", "torque_reference", "psi_s_reference", "psi_alpha")

    figures = draw_steady_state(block, analyze(block), title="a run")

    assert list(figures) == ["waveforms", "current_spectrum"]
    assert "reference" not in texts(figures["waveforms"])


def test_without_a_flux_reference_the_circle_is_the_mean() -> None:
    block = capture("psi_s_reference")

    (axes,) = draw_steady_state(block, analyze(block), title="a run")["flux_trajectory"].axes

    assert [line.get_label() for line in axes.lines] == ["estimate", "mean"]


def test_a_transducer_of_another_time_is_refused() -> None:
    block = capture()

    with pytest.raises(AnalysisError, match="is needed"):
        draw_steady_state(block, analyze(block), transducer(ticks=10), title="a run")


def test_files_are_pictures_and_the_same_each_time(tmp_path: Path) -> None:
    block = capture()
    figures = draw_steady_state(block, analyze(block), title="a run")
    again = draw_steady_state(block, analyze(block), title="a run")

    paths = save_figures(figures, tmp_path / "plots")

    assert [path.name for path in paths] == ["waveforms.png", "current_spectrum.png", "flux_trajectory.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
    repeated = save_figures(again, tmp_path / "again")
    assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in repeated]


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "plots").write_text("a file")
    block = capture()
    figures = draw_steady_state(block, analyze(block), title="a run")

    with pytest.raises(RecordingError, match=r"cannot write .*waveforms\.png") as refused:
        save_figures(figures, tmp_path / "plots")
    assert "\n" not in str(refused.value)


def test_pyplot_with_its_global_state_is_not_imported() -> None:
    code = "import sys, benchtool.report.figures.steady_state; sys.exit('matplotlib.pyplot' in sys.modules)"

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
