"""The machine code of a compiled function for the types of its arguments."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from benchtool.emulator.typed import typed


def compiled() -> Any:
    overloads = {
        (int, float): SimpleNamespace(entry_point=lambda a, b: "of an integer"),
        (float, float): SimpleNamespace(entry_point=lambda a, b: "of a float"),
    }
    return SimpleNamespace(overloads=overloads, typeof_pyval=type)


def test_the_code_is_that_of_the_types_of_all_arguments() -> None:
    assert typed(compiled(), 1, 2.0)(1, 2.0) == "of an integer"
    assert typed(compiled(), 1.0, 2.0)(1.0, 2.0) == "of a float"


def test_types_that_it_was_not_called_with_are_refused() -> None:
    with pytest.raises(KeyError):
        typed(compiled(), "1", 2.0)


def test_a_plain_function_is_called_as_it_is() -> None:
    assert typed(max, 1, 2)(1, 2) == 2
