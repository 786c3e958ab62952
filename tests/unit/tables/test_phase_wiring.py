"""Three phase currents of which a sensor reads backwards, or two are swapped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.tables import TableQuestion, analyze_table

ROWS = 4_000


@pytest.mark.parametrize(
    ("signs", "phases", "seen"),
    [
        ((1, 1, 1), (0, 1, 2), ""),
        ((1, -1, 1), (0, 1, 2), "with 'ib [A]' the other way"),
        ((-1, 1, 1), (0, 2, 1), "with 'ia [A]' the other way"),
        ((1, 1, 1), (0, 2, 1), "follow each other against the angle 'theta [rad]'"),
        ((1, 1, 1.3), (0, 1, 2), ""),
        ((1, 1, 0.01), (0, 1, 2), ""),
    ],
)
def test_phases_that_are_miswired_are_told(
    tmp_path: Path, signs: tuple[float, ...], phases: tuple[int, ...], seen: str
) -> None:
    time_s, noise = np.arange(ROWS) / 10e3, np.random.default_rng(1)
    theta = 2.0 * np.pi * 10.0 * time_s
    currents = [
        sign * 5.0 * np.cos(4.0 * theta - 2.0 * np.pi * phase / 3.0) + 0.01 * noise.standard_normal(ROWS)
        for sign, phase in zip(signs, phases, strict=True)
    ]
    path, head = tmp_path / "t.csv", "t [s],ia [A],ib [A],ic [A],theta [rad]"
    table = np.column_stack([time_s, *currents, theta % (2.0 * np.pi)])
    np.savetxt(path, table, delimiter=",", header=head, comments="")
    columns = {"current": "ia", "current_b": "ib", "current_c": "ic", "angle": "theta"}
    found = [
        each.text
        for each in analyze_table(TableQuestion(path, "t", columns, pole_pairs=4)).remarks
        if each.kind == "miswired"
    ]
    assert len(found) == bool(seen)
    assert seen in "".join(found)
