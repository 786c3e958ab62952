"""Client and server against those of the canopen package."""

from __future__ import annotations

# The package has no annotations here.
# mypy: disallow-untyped-calls=False
import io
from collections.abc import Iterator
from typing import Any

import can
import canopen
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from benchtool.clock import RealClock
from benchtool.errors import SdoAbort
from benchtool.link.canopen.link import CanopenLink
from benchtool.protocol.canopen.abort import Abort
from tests.wire.endpoints import NODE, Served

BOUNDARIES = [0, 1, 3, 4, 5, 6, 7, 8, 13, 14, 15, 888, 889, 890, 895, 896, 897, 1777, 1778, 1779, 2000]
SIZES = st.one_of(st.sampled_from(BOUNDARIES), st.integers(0, 2000))


def pattern(size: int) -> bytes:
    return bytes(k * 7 % 251 for k in range(size))


@pytest.fixture
def network(channel: str) -> Iterator[canopen.Network]:
    opened = canopen.Network(can.Bus(interface="virtual", channel=channel))
    opened.NOTIFIER_CYCLE = 0.02
    opened.connect()
    yield opened
    opened.disconnect()


class TestPackageClient:
    @pytest.fixture
    def client(self, served: Served, network: canopen.Network) -> Any:
        return network.add_node(NODE, canopen.ObjectDictionary()).sdo

    @pytest.mark.parametrize("block", [False, True])
    @given(size=SIZES)
    @settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
    def test_reads_every_size(self, served: Served, client: Any, block: bool, size: int) -> None:
        served.objects[0x2042, 0] = pattern(size)
        with client.open(0x2042, 0, "rb", buffering=0, block_transfer=block) as stream:
            assert stream.read() == pattern(size)
        served.bus.settle()
        assert served.sdo.malformed == 0

    @pytest.mark.parametrize("block", [False, True])
    @given(size=SIZES.filter(bool))
    @settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
    def test_writes_every_size(self, served: Served, client: Any, block: bool, size: int) -> None:
        served.writes.clear()
        with client.open(0x2042, 0, "wb", buffering=7, size=size, block_transfer=block) as stream:
            assert isinstance(stream, io.BufferedWriter)
            stream.write(pattern(size))
        assert served.writes == [(0x2042, 0, pattern(size))]
        assert served.sdo.malformed == 0

    def test_is_told_why_a_read_is_refused(self, client: Any) -> None:
        with pytest.raises(canopen.SdoAbortedError) as refused:
            client.upload(0x3000, 0)
        assert refused.value.code == Abort.NO_OBJECT


class TestPackageServer:
    @pytest.fixture
    def node(self, network: canopen.Network) -> canopen.LocalNode:
        dictionary = canopen.ObjectDictionary()
        variable = canopen.objectdictionary.ODVariable("data", 0x2042, 0)
        variable.data_type = canopen.objectdictionary.DOMAIN
        variable.access_type = "rw"
        dictionary.add_object(variable)
        return network.create_node(NODE, dictionary)

    @pytest.fixture
    def link(self, node: canopen.LocalNode, channel: str) -> Iterator[CanopenLink]:
        with CanopenLink(can.Bus(interface="virtual", channel=channel), NODE, RealClock()) as opened:
            yield opened

    @pytest.mark.parametrize("size", BOUNDARIES[1:])
    def test_writes_and_reads_every_size(self, link: CanopenLink, node: canopen.LocalNode, size: int) -> None:
        link.download(0x2042, 0, pattern(size))
        assert node.data_store[0x2042][0] == pattern(size)
        assert link.upload(0x2042, 0) == pattern(size)

    def test_a_server_without_block_upload_is_read_by_segments(
        self, link: CanopenLink, node: canopen.LocalNode
    ) -> None:
        node.set_data(0x2042, 0, pattern(100))
        assert link.upload(0x2042, 0, block=True) == pattern(100)
        assert link.counters.retries == 0

    def test_a_block_write_that_is_refused_is_not_tried_in_another_way(
        self, link: CanopenLink, node: canopen.LocalNode
    ) -> None:
        with pytest.raises(SdoAbort) as refused:
            link.download(0x2042, 0, pattern(100), block=True)
        assert refused.value.code == Abort.COMMAND_SPECIFIER
        assert node.data_store == {}
