"""The emulated serial CAN adapter against real clients, over pseudo-terminals and TCP."""

from __future__ import annotations

# The canopen package has no annotations here.
# mypy: disallow-untyped-calls=False
import socket
from collections.abc import Iterator

import can
import canopen
import pytest

from benchtool.bench.session import open_session
from benchtool.clock import RealClock
from benchtool.emulator.ports.pty import PtyPort
from benchtool.emulator.servers.slcan import SlcanAdapter
from benchtool.errors import LinkClosed, LinkError, SdoAbort
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.canopen.slcan import SlcanBus, open_slcan
from benchtool.link.interface import Frame
from benchtool.link.port import PyserialPort, open_port
from tests.wire.endpoints import NODE
from tests.wire.slcan_endpoints import READS, AcceptedPort, Drive

LONG = bytes(k * 7 % 251 for k in range(5000))


@pytest.fixture
def port() -> PtyPort:
    return PtyPort()


@pytest.fixture(params=[True, False], ids=["acknowledging", "silent"])
def drive(port: PtyPort, request: pytest.FixtureRequest) -> Iterator[Drive]:
    served = Drive(SlcanAdapter(port, acknowledge=request.param))
    served.objects = {(0x1000, 0): b"\x92\x01\x02\x00", (0x2042, 0): LONG}
    yield served
    served.close()
    assert served.failure is None


def connected(port: PtyPort) -> CanopenLink:
    return CanopenLink(open_slcan(port.path, 500_000), NODE, RealClock())


class TestOurBus:
    def test_it_reads_and_writes_objects(self, port: PtyPort, drive: Drive) -> None:
        with connected(port) as link:
            assert link.upload(0x1000, 0) == b"\x92\x01\x02\x00"
            assert link.upload(0x2042, 0, block=True) == LONG
            link.download(0x2043, 0, LONG, block=True)
            assert drive.objects[0x2043, 0] == LONG
            with pytest.raises(SdoAbort):
                link.upload(0x3000, 0)
            assert link.counters.frames_dropped == 0
            assert link.counters.retries == 0
        assert drive.adapter.malformed == {}

    def test_thousands_of_frames_come_in_order_and_none_is_lost(self, port: PtyPort, drive: Drive) -> None:
        bus = open_slcan(port.path, 1_000_000)
        # Nothing tells the host of a silent adapter when its channel is open.
        for _ in range(READS):
            if drive.adapter.is_open:
                break
            assert bus.recv(0.0) is None
        numbers: list[int] = []
        sent = 0
        while len(numbers) < 20_000:
            for _ in range(500):  # fewer than the adapter holds
                drive.send(0x185, sent.to_bytes(4, "little"))
                sent += 1
            while len(numbers) < sent:
                got = bus.recv(1.0)
                assert got is not None
                numbers.append(int.from_bytes(got.data, "little"))
        assert numbers == list(range(20_000))
        assert (bus.malformed, bus.refused, drive.adapter.dropped) == (0, 0, 0)
        bus.shutdown()

    def test_a_subscriber_gets_the_frames_of_a_link(self, port: PtyPort, drive: Drive) -> None:
        got: list[Frame] = []
        with connected(port) as link:
            link.subscribe([0x185], got.append)
            link.upload(0x1000, 0)  # an answer: the channel is open, which a silent adapter does not say
            for number in range(100):
                drive.send(0x185, bytes([number]))
            link.upload(0x1000, 0)  # answered behind them
        assert [each.data for each in got] == [bytes([number]) for number in range(100)]

    def test_clients_come_and_go(self, port: PtyPort, drive: Drive) -> None:
        for _ in range(3):
            with connected(port) as link:
                assert link.upload(0x1000, 0) == b"\x92\x01\x02\x00"

    def test_a_client_that_left_without_a_word_does_not_hinder_the_next(
        self, port: PtyPort, drive: Drive
    ) -> None:
        client = PyserialPort(port.path)
        client.write(b"\rC\rS6\rO\rt605")
        for _ in range(READS):
            if drive.adapter.is_open:
                break
            client.read()
        for number in range(3000):
            drive.send(0x185, number.to_bytes(8, "little"))
        client.close()
        with connected(port) as link:
            assert link.upload(0x1000, 0) == b"\x92\x01\x02\x00"

    def test_an_adapter_that_is_switched_off_closes_the_link(self, port: PtyPort) -> None:
        served = Drive(SlcanAdapter(port))
        with connected(port) as link:
            served.close()
            with pytest.raises(LinkClosed, match="stopped working: the adapter is gone"):
                link.upload(0x1000, 0)

    def test_a_link_address_names_it(self, port: PtyPort, drive: Drive) -> None:
        url = f"can:slcan:{port.path}?bitrate=300000"
        with pytest.raises(LinkError, match="is none that slcan has: choose"), open_session("zhu2011", url):
            pass

    def test_over_tcp(self) -> None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            url = f"socket://127.0.0.1:{server.getsockname()[1]}"
            client = open_port(url)
            accepted, _ = server.accept()
            served = Drive(SlcanAdapter(AcceptedPort(accepted)))
            served.objects[0x2042, 0] = LONG
            bus = SlcanBus(client, 500_000, acknowledged=True, identify=True)
            assert (bus.version, bus.serial_number) == ("1010", "BT01")
            with CanopenLink(bus, NODE, RealClock()) as link:
                assert link.upload(0x2042, 0, block=True) == LONG
            served.close()


class TestPythonCan:
    def open(self, port: PtyPort) -> can.BusABC:
        return can.Bus(interface="slcan", channel=port.path, bitrate=500_000, sleep_after_open=0.0)

    @pytest.mark.parametrize("drive", [True], indirect=True)
    def test_it_identifies_the_adapter(self, port: PtyPort, drive: Drive) -> None:
        bus = self.open(port)
        assert bus.get_version(2.0) == (10, 10)  # type: ignore[attr-defined]
        assert bus.get_serial_number(2.0) == "BT01"  # type: ignore[attr-defined]
        bus.shutdown()

    def test_a_link_above_it_reads_objects(self, port: PtyPort, drive: Drive) -> None:
        with CanopenLink(self.open(port), NODE, RealClock()) as link:
            assert link.upload(0x1000, 0) == b"\x92\x01\x02\x00"
            assert link.upload(0x2042, 0, block=True) == LONG

    def test_the_canopen_package_above_it_reads_and_writes_objects(self, port: PtyPort, drive: Drive) -> None:
        network = canopen.Network(self.open(port))
        network.NOTIFIER_CYCLE = 0.02
        network.connect()
        sdo = network.add_node(NODE, canopen.ObjectDictionary()).sdo
        sdo.RESPONSE_TIMEOUT = 5.0  # a busy machine takes longer than the package waits
        assert sdo.upload(0x1000, 0) == b"\x92\x01\x02\x00"
        sdo.download(0x2043, 0, LONG)
        assert drive.objects[0x2043, 0] == LONG
        network.disconnect()
