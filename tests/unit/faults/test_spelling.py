"""Faults as text: what is spelled is what is read, and what cannot be is refused with the name of the key."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st

from benchtool.emulator.faults.catalogue import FAULTS
from benchtool.emulator.faults.declaration import Fault, Parameter
from benchtool.emulator.faults.injection import _EFFECTS
from benchtool.emulator.faults.spelling import parse_fault
from benchtool.errors import ValueRefused


def test_every_fault_of_the_table_has_an_effect_and_no_other() -> None:
    assert set(_EFFECTS) == set(FAULTS)


def _values(parameter: Parameter) -> st.SearchStrategy[float | str]:
    if isinstance(parameter.default, str):
        return st.sampled_from(parameter.choices or ("psi_r", "R_s"))
    return st.integers(0, 1000).map(
        lambda n: float(f"{parameter.least + (parameter.most - parameter.least) * n / 1000:g}")
    )


@st.composite
def _faults(draw: st.DrawFn) -> Fault:
    kind = FAULTS[draw(st.sampled_from(sorted(FAULTS)))]
    values = {each.name: draw(_values(each)) for each in kind.parameters}
    return Fault(kind, values, float(draw(st.integers(0, 10_000))) / 100.0)


@settings(max_examples=30)
@given(_faults())
def test_what_is_spelled_is_what_is_read(fault: Fault) -> None:
    assert parse_fault(str(fault)) == fault


def test_what_is_left_out_is_its_default_and_begins_at_once() -> None:
    fault = parse_fault("frames_lost:share=0.25")
    assert dict(fault.values) == {"share": 0.25, "way": "both", "duration_s": 0.0}
    assert fault.at_s == 0.0


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("frame_lost", "did you mean 'frames_lost'"),
        ("", "there is no ''"),
        ("frames_lost:share=2", "share = '2', a number from 0 to 1 is expected"),
        ("frames_lost:share=nan", "a number from 0 to 1"),
        ("frames_lost:share", "share = '', a number"),
        ("frames_lost:part=0.1", "'frames_lost' has no 'part'"),
        ("drive_reset:watchdog_s=1", "it takes no parameter"),
        ("phase_open:phase=u", "phase = 'u', one of a, b, c is expected"),
        ("host_killed@soon", "'@soon', seconds of 0 or more are expected"),
        ("host_killed@-1", "seconds of 0 or more"),
        ("host_killed@inf", "seconds of 0 or more"),
    ],
)
def test_what_cannot_be_is_refused(text: str, complaint: str) -> None:
    with pytest.raises(ValueRefused) as refused:
        parse_fault(text)
    assert complaint in str(refused.value)
