"""What a report says of a number: its uncertainty, what it rests on, and how limits were met."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis.measurement import Basis, Correction, Measurement
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined
from benchtool.plan import Verdict
from benchtool.report.assembly.front import banner
from benchtool.report.content import Text
from benchtool.report.results import basis_text, budgets_section, measurement_notes


@pytest.mark.parametrize(
    ("uncertainty", "told"),
    [
        (Uncertainty(0.0, "a count"), "Without uncertainty: a count."),
        (Uncertainty(0.012, "noise"), "U = 0.024 Nm covers 95 %, k = 1.96, u = 0.012 Nm: noise."),
        (
            combined([Contribution("a", "A", 0.2 * math.sqrt(2.0), 4.0, of_student=True)], "few values"),
            "U = 0.56 Nm covers 95 %, 2.78 times the experimental standard uncertainty 0.20 Nm, 4 "
            "degrees of freedom; with what few observations add, u = 0.28 Nm and k = U/u = 1.96: "
            "few values.",
        ),
        (
            Uncertainty(0.1, "an extreme", 1237.2, half_width=0.106),
            "U = 0.11 Nm covers 95 %, half of the interval of a derived distribution; u = 0.10 Nm, "
            "k = U/u = 1.06: an extreme.",
        ),
    ],
)
def test_an_uncertainty_says_what_k_and_the_degrees_of_freedom_belong_to(
    uncertainty: Uncertainty, told: str
) -> None:
    *_, note = measurement_notes(Measurement("torque_mean", 1.0, "Nm", "a mean", uncertainty=uncertainty))
    assert note == told


def test_a_correction_shows_in_the_value_as_read() -> None:
    """0.6432 A was corrected by 4.0 × 10⁻¹⁰ from 0.6432 A."""
    measured = Measurement("i", 0.6432, "A", "", correction=Correction(4.04e-7, "a lag"))
    *_, note = measurement_notes(measured)
    assert note == "Corrected by 4.0 × 10⁻⁷ A from 0.64319960 A as read: a lag."


@pytest.mark.parametrize(
    ("basis", "told"),
    [
        (Basis(samples=9500.000000148917, sample_rate_Hz=1e4), "Basis: 9500 samples at 10000 Hz."),
        (Basis(samples=1.0), "Basis: 1 sample."),
        (Basis(gaps=1), "Basis: 1 gap."),
    ],
)
def test_samples_are_whole(basis: Basis, told: str) -> None:
    assert basis_text(basis) == told


@pytest.mark.parametrize(
    ("verdicts", "told"),
    [
        (("pass", "marginal", "undecided", "fail"), "2 of 4 limits met (1 of them marginally), 1 undecided."),
        (("pass",), "1 of 1 limit met."),
    ],
)
def test_the_summary_counts_what_is_met_first(verdicts: tuple[str, ...], told: str) -> None:
    found = banner(Verdict.FAIL, Verdict.NONE, [], [Verdict(each) for each in verdicts])
    assert found.summary == told


@pytest.mark.parametrize(
    ("uncertainty", "said", "not_said"),
    [
        (Uncertainty(0.1, "noise"), ("U = t s", "u = s"), ("Where few do", "Without t")),
        (
            Uncertainty(0.1, "an extreme", half_width=0.2),
            ("Without t, U is half", "u = s"),
            ("U = t s", "Where few do"),
        ),
        (
            combined([Contribution("a", "A", 0.2 * math.sqrt(2.0), 4.0, of_student=True)], "few values"),
            ("U = t s", "Where few do, it is larger"),
            ("Without t", "u = s, the standard"),
        ),
    ],
)
def test_notes_below_budgets_are_those_of_the_numbers_there(
    uncertainty: Uncertainty, said: tuple[str, ...], not_said: tuple[str, ...]
) -> None:
    """That u is larger than s stood below a peak-to-peak value of which it is not."""
    section = budgets_section([Measurement("x", 1.0, "Nm", "", uncertainty=uncertainty)])
    assert section is not None
    notes = " ".join(item.text for item in section.items if isinstance(item, Text))
    assert all(each in notes for each in said)
    assert not any(each in notes for each in not_said)
