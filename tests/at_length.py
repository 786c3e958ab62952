"""Parameters that only the slow tests try: the quicker ones try one of their kind."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from _pytest.mark.structures import ParameterSet


def at_length(*parameters: Any) -> Iterator[ParameterSet]:
    """Yield parameters of `parametrize`, each a value or a tuple of values, marked as slow."""
    for each in parameters:
        values = each if isinstance(each, tuple) else (each,)
        yield pytest.param(*values, marks=pytest.mark.slow)
