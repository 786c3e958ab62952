"""A request for a capture, judged before anything is sent."""

from __future__ import annotations

import pytest

from benchtool.drive import CaptureRequest
from benchtool.errors import ValueRefused


@pytest.mark.parametrize("count", [0, 17])
def test_channels_that_a_capture_has_not_are_refused(count: int) -> None:
    with pytest.raises(ValueRefused, match=f"^{count} channels, 1 to 16 are expected; nothing was sent"):
        CaptureRequest(("i_a",) * count, rows=10)


def test_all_channels_of_a_capture_may_be_taken() -> None:
    assert len(CaptureRequest(("i_a",) * 16, rows=10).channels) == 16
