"""Numbers as a report prints them."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given, strategies as st

from benchtool.analysis.numbers import count_of, degrees, number, probability, raw, signed, stated


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (0.05006, "0.05006"),
        (0.65, "0.6500"),
        (-3.616e-5, "−3.616 × 10⁻⁵"),
        (40326.0, "40326"),
        (9999.87, "10000"),
        (1.25e7 + 0.5, "1.250 × 10⁷"),
        (3e-54, "0"),
        (math.nan, "–"),
        (-math.inf, "–"),
    ],
)
def test_four_significant_digits(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "standard", "text"),
    [
        (0.650012, 0.00123, "0.6500 ± 0.0012"),
        (10.0, 0.0996, "10.00 ± 0.10"),
        (1234.5, 56.0, "1234 ± 56"),
        (123456.0, 7890.0, "123500 ± 7900"),
        (1.8e-5, 1.7e-5, "(1.8 ± 1.7) × 10⁻⁵"),
        (0.65, None, "0.6500"),
        (0.65, 0.0, "0.6500"),
        (50.0, 1.2e-7, "50.00000000 ± 0.00000012"),
        (50.0, 1.2e-8, "50.00000000 ± 0.00000002"),
        (50.0, 3e-12, "50.00000000 ± 0.00000001"),
        (1.2345678e7, 1.5e-4, "(1.234567800 ± 0.000000001) × 10⁷"),
        (0.65, math.nan, "0.6500"),
        (math.nan, 0.1, "–"),
        (-3e-5, 0.0041, "0.0000 ± 0.0041"),
        (0.0, 1.2e-54, "0"),
        (0.65, 1e-40, "0.6500"),
    ],
)
def test_the_uncertainty_decides_the_digits(value: float, standard: float | None, text: str) -> None:
    assert stated(value, standard) == text


@given(
    st.floats(-1e12, 1e12, allow_nan=False).filter(lambda value: abs(value) > 1e-12),
    st.floats(1e-4, 1.0),
)
def test_what_is_printed_is_the_value_to_a_tenth_of_its_uncertainty(value: float, share: float) -> None:
    standard = abs(value) * share
    text = stated(value, standard).replace("−", "-")
    power = 0
    if match := re.fullmatch(r"\((.*)\) × 10(.*)", text):
        text = match[1]
        power = int(match[2].translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")))
    shown, _, uncertain = text.partition(" ± ")
    assert float(shown) * 10.0**power == pytest.approx(value, abs=0.0501 * standard)
    assert float(uncertain) * 10.0**power == pytest.approx(standard, rel=0.0501)


def test_differences_have_a_sign_and_settings_no_further_digits() -> None:
    assert signed(0.0123) == "+0.0123"
    assert signed(-0.5) == "−0.500"
    assert raw(0.06) == "0.06"
    assert raw(True) == "true"
    assert raw("tpc") == "tpc"


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1e7, 7, "10000000"),
        (6999.87, 3, "7000"),
        (1e-6, 7, "1 × 10⁻⁶"),
        (-2.5e-7, 7, "−2.5 × 10⁻⁷"),
        (4.5e12, 7, "4.5 × 10¹²"),
        (4294967295.0, 12, "4294967295"),
        (1.0, 7, "1"),
    ],
)
def test_a_number_as_given_has_no_exponent_of_a_programme(value: float, digits: int, text: str) -> None:
    assert raw(value, digits) == text


@pytest.mark.parametrize(
    ("dof", "text"),
    [
        (math.inf, "∞"),
        (18.0, "18"),
        (2.3456, "2.35"),
        (16.0321, "16"),
        (1237.2, "1237"),
        (88353.27, "88353"),
    ],
)
def test_degrees_of_freedom_are_whole_where_they_are_many(dof: float, text: str) -> None:
    assert degrees(dof) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "< 0.001"), (0.0009, "< 0.001"), (0.001, "0.001"), (0.9541, "0.954"), (1.0, "> 0.999")],
)
def test_a_probability_is_never_said_to_be_certain(value: float, text: str) -> None:
    assert probability(value) == text


def test_one_thing_is_not_several() -> None:
    assert count_of(1, "row") == "1 row"
    assert count_of(0, "row") == "0 rows"
    assert count_of(2, "row is", "rows are") == "2 rows are"
