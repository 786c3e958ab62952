"""Link addresses."""

from __future__ import annotations

import pytest

from benchtool.errors import UsageError
from benchtool.link.address import Address


def test_emulated() -> None:
    address = Address.parse("emulated")
    assert (address.kind, address.node_id(1), address.bitrate) == ("emulated", 1, None)
    assert Address.parse("emulated?channel=bench-a").channel == "bench-a"


def test_can_with_a_channel_that_has_colons() -> None:
    address = Address.parse("can:slcan:socket://127.0.0.1:4000?bitrate=500000&node=5")
    assert (address.interface, address.channel) == ("slcan", "socket://127.0.0.1:4000")
    assert (address.bitrate, address.node_id(1)) == (500_000, 5)


@pytest.mark.parametrize(
    ("url", "complaint"),
    [
        ("can:slcan", "link 'can:slcan' is not known"),
        ("ethernet:foo:bar", "is not known: use"),
        ("", "is not known"),
        ("emulatedx", "is not known"),
        ("can:virtual:a?speed=1", "unknown option 'speed', known are bitrate, node"),
        ("can:virtual:a?bitrate=fast", "option 'bitrate' is 'fast', a whole number is expected"),
        ("emulated?node=0", "node id 0 is outside 1 to 126"),
        ("emulated?node=127", "node id 127 is outside 1 to 126"),
    ],
)
def test_mistakes(url: str, complaint: str) -> None:
    with pytest.raises(UsageError) as refused:
        Address.parse(url).node_id(1)
    assert complaint in str(refused.value)
