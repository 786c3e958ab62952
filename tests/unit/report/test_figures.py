"""Figures: what they show, and that nothing global is touched."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchtool.analysis.catalogue import CORE
from benchtool.analysis.coherent.spectrum import largest_low_component
from benchtool.analysis.declaration import Panel
from benchtool.analysis.flux.trajectory import FLUX_TRAJECTORY
from benchtool.analysis.steady_state import steady_state_of
from benchtool.analysis.window import Window
from benchtool.block import Block, Channel, Gap
from benchtool.errors import AnalysisError, RecordingError
from benchtool.report.figures.drawings import draw_of_case
from benchtool.report.figures.files import save_figures
from benchtool.report.figures.style import literal, new_figure
from benchtool.report.figures.waveforms import fundamental, last_periods

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


def panel(block: Block, shaft: Block | None = None, **limits: tuple[float | None, float | None]) -> Panel:
    """The capture measured, shown with a transducer and judged by limits."""
    window = Window(block, 4, 9.55)
    found = {
        each.name: each.measure(window, each.settings())
        for each in (*CORE, FLUX_TRAJECTORY)
        if each.possible(frozenset(block.names), each.settings(), transducer=False)
    }
    return Panel("a case", block, steady_state_of(found), "a case", shaft, found, limits)


def drawn(
    block: Block, shaft: Block | None = None, **limits: tuple[float | None, float | None]
) -> dict[str, Figure]:
    return draw_of_case(panel(block, shaft, **limits), "a run")


def texts(figure: Figure) -> str:
    return "\n".join(
        [text.get_text() for axes in figure.axes for text in axes.texts]
        + [axes.get_ylabel() for axes in figure.axes]
        + [str(label) for axes in figure.axes for label in axes.get_legend_handles_labels()[1]]
    )


def test_waveforms_show_all_that_was_recorded_and_two_periods_in_detail() -> None:
    block = capture()

    figures = drawn(block, transducer())

    assert list(figures) == ["waveforms", "current_spectrum", "flux_trajectory"]
    torque, torque_detail, current, current_detail, flux, flux_detail = figures["waveforms"].axes
    end_s = (SAMPLES - 1) * TICK_S
    assert flux.get_xlim() == pytest.approx((0.0, end_s))
    assert flux_detail.get_xlim() == pytest.approx((end_s - 0.1, end_s))
    labels = torque.get_legend_handles_labels()[1]
    assert labels == ["shaft transducer", "estimate", "reference"]
    shown = np.asarray(torque_detail.lines[0].get_ydata())
    np.testing.assert_array_equal(shown, block.column("torque")[-len(shown) :])
    estimate = np.asarray(torque.collections[1].get_paths()[0].vertices)[:, 1]
    assert (estimate.min(), estimate.max()) == (block.column("torque").min(), block.column("torque").max())
    for name, unit in {"torque": "Nm", "current": "A", "flux": "Wb"}.items():
        assert any(
            name in label and f"({unit})" in label for label in texts(figures["waveforms"]).split("\n")
        )
    assert [line.get_label() for line in current.lines] == [f"$i_{each}$, fundamental" for each in "abc"]
    raw, fitted = current_detail.lines[0], current_detail.lines[1]
    assert (raw.get_alpha() or 1.0) < 0.5, "the last phase would hide the others"
    assert fitted.get_linewidth() > 2 * raw.get_linewidth()


def test_the_fundamental_is_the_sinusoid_of_the_phase_alone() -> None:
    time_s, current_A = fundamental(capture(), "i_a", 20.0)
    np.testing.assert_allclose(current_A, np.cos(2 * np.pi * 20.0 * time_s), atol=2e-3)


def test_the_limit_that_is_judged_is_drawn_about_what_was_measured() -> None:
    torque, detail, *_ = drawn(capture(), torque_ripple_pp=(None, 0.1), torque_mean=(0.6, None))[
        "waveforms"
    ].axes
    for axes in (torque, detail):
        levels = [
            float(np.asarray(line.get_ydata())[0]) for line in axes.lines if "limit" in str(line.get_label())
        ]
        levels += [
            float(np.asarray(line.get_ydata())[0]) for line in axes.lines if line.get_label() == "_nolegend_"
        ]
        assert sorted(levels) == pytest.approx([0.6, 0.6, 0.7])
    labels = torque.get_legend_handles_labels()[1]
    assert "limit of the ripple, peak to peak" in labels
    assert not any("rms" in label for label in labels)


def test_a_limit_in_percent_is_drawn_in_newton_metres() -> None:
    torque, *_ = drawn(capture(), torque_ripple_percent_of_rated=(None, 1.0))["waveforms"].axes
    levels = [np.asarray(line.get_ydata())[0] for line in torque.lines if line.get_label() != "reference"]
    assert np.ptp(levels) == pytest.approx(0.0955)


def test_the_title_states_the_judged_number_with_its_limit() -> None:
    title = drawn(capture(), torque_ripple_pp=(None, 0.1))["waveforms"].get_suptitle()
    assert "0.06 Nm (limit 0.1) peak to peak" in title


def test_the_detail_follows_the_last_gap() -> None:
    block = capture()
    broken = Block(block.channels, block.first_tick, 1, TICK_S, block.data, (Gap(SAMPLES - 400, 50),))
    detail = last_periods(broken, 20.0)
    assert (len(detail.data), detail.gaps) == (400, ())
    assert detail.first_tick == broken.ticks()[SAMPLES - 400]


def test_the_spectrum_marks_fundamental_and_largest_other_component() -> None:
    block = capture()

    shown = texts(drawn(block)["current_spectrum"])

    assert "fundamental 1 A" in shown
    assert "largest other 0.02" in shown
    assert "at 188 Hz" in shown


def test_the_spectrum_states_what_was_measured_of_its_lines() -> None:
    """A line beside the fifth is in its bin, and not in the harmonic."""
    block = capture()
    data, turns = np.array(block.data), 6.0 * np.arange(SAMPLES) / SAMPLES
    cosine = [np.cos(2 * np.pi * order * turns + 0.3) for order in (1.0, 5.0, 7.0, 5.0 + 0.3 / 6.0)]
    data[:, block.names.index("i_a")] = np.array([1.0, 0.03, 0.035, 0.02]) @ np.array(cosine)
    shown = panel(replace(block, data=data))
    assert shown.steady is not None
    largest = shown.steady["current_max_low_harmonic"]

    stated = texts(draw_of_case(shown, "a run")["current_spectrum"])

    assert largest_low_component(shown.steady.current_spectrum).amplitude > 0.04
    assert f"largest other {largest.value:.3g} A at {largest.basis.frequency_Hz:.4g} Hz" in stated


def test_the_spectrum_has_the_limit_of_the_largest_other_component() -> None:
    low, _ = drawn(capture(), current_max_low_harmonic=(None, 0.03))["current_spectrum"].axes
    (limit,) = (line for line in low.lines if str(line.get_label()).startswith("limit"))
    assert np.asarray(limit.get_ydata())[0] == 0.03


def test_the_flux_circle_has_its_limits() -> None:
    (axes,) = drawn(capture(), flux_ripple_pp=(None, 0.02))["flux_trajectory"].axes
    radii = [float(np.hypot(*np.asarray(line.get_xydata())[0])) for line in axes.lines[2:]]
    assert radii == pytest.approx([0.16, 0.18])


def test_the_flux_circle_is_the_reference() -> None:
    block = capture()

    (axes,) = drawn(block)["flux_trajectory"].axes

    circle = np.hypot(*np.asarray(axes.lines[1].get_data()))
    assert circle == pytest.approx(np.full(len(circle), 0.17))


def test_optional_channels_may_be_absent() -> None:
    block = capture("i_b", "i_c", "torque_reference", "psi_s_reference", "psi_alpha")

    figures = drawn(block)

    assert list(figures) == ["waveforms", "current_spectrum"]
    assert "reference" not in texts(figures["waveforms"])


def test_without_a_flux_reference_the_circle_is_the_mean() -> None:
    block = capture("psi_s_reference")

    (axes,) = drawn(block)["flux_trajectory"].axes

    assert [line.get_label() for line in axes.lines] == ["estimate", "mean"]


def test_a_transducer_of_another_time_is_refused() -> None:
    block = capture()

    with pytest.raises(AnalysisError, match="is needed"):
        drawn(block, transducer(ticks=10))


def test_files_are_pictures_and_the_same_each_time(tmp_path: Path) -> None:
    block = capture()
    figures = drawn(block)
    again = drawn(block)

    paths = save_figures(figures, tmp_path / "plots")

    assert [path.name for path in paths] == ["waveforms.png", "current_spectrum.png", "flux_trajectory.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
    repeated = save_figures(again, tmp_path / "again")
    assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in repeated]


def test_letters_that_the_font_has_not_are_drawn_without_a_warning(tmp_path: Path) -> None:
    """A warning fails the test. Greek is in the font, what a user writes beside it may not be."""
    assert literal("ψ_r = 0.1685 Wb, $5") == r"ψ_r = 0.1685 Wb, \$5"
    title = "\N{CJK UNIFIED IDEOGRAPH-96FB}\N{CJK UNIFIED IDEOGRAPH-6A5F} 2.2 kW"
    assert literal(title) == "\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER} 2.2 kW"
    save_figures({"empty": new_figure(1.0, title, "")}, tmp_path)


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "plots").write_text("a file")
    block = capture()
    figures = drawn(block)

    with pytest.raises(RecordingError, match=r"cannot write .*waveforms\.png") as refused:
        save_figures(figures, tmp_path / "plots")
    assert "\n" not in str(refused.value)


def test_pyplot_with_its_global_state_is_not_imported() -> None:
    code = "import sys, benchtool.report.figures.steady_state; sys.exit('matplotlib.pyplot' in sys.modules)"

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_spectrum_is_drawn_whose_fundamental_is_undefined() -> None:
    block = capture()
    data = np.array(block.data)
    column = block.names.index("i_a")
    data[:, column] = np.minimum(data[:, column], 0.6)
    clipped = panel(replace(block, data=data))
    assert clipped.steady is not None
    assert "the record is clipped" in clipped.steady["current_fundamental"].reason
    assert "current_spectrum" in draw_of_case(clipped, "clipped")
