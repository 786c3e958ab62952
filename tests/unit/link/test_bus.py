"""What python-can raises where an adapter's driver is not there ends as one line of benchtool's."""

from __future__ import annotations

import can
import pytest

from benchtool.errors import LinkError
from benchtool.link.canopen.bus import open_bus


@pytest.mark.parametrize(
    "failure", [NameError("name 'canOpen' is not defined"), ImportError("no library"), OSError]
)
def test_an_adapter_without_its_driver(failure: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(**_options: object) -> can.BusABC:
        raise failure

    monkeypatch.setattr(can, "Bus", refuse)
    with pytest.raises(
        LinkError, match=r"cannot open can:kvaser:0: .*check the interface's name, its driver"
    ):
        open_bus("kvaser", "0", 500_000)
