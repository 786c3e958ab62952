"""Link addresses."""

from __future__ import annotations

import pytest

from benchtool.bench.wires import registry
from benchtool.errors import UsageError
from benchtool.link.port import DEFAULT_BAUDRATE


def test_emulated() -> None:
    address = registry.parse("emulated")
    assert (address.scheme, address.node_id(1), address.number("bitrate")) == ("emulated", 1, None)
    assert registry.parse("emulated?channel=bench-a").options["channel"] == "bench-a"


def test_can_with_a_channel_that_has_colons() -> None:
    address = registry.parse("can:slcan:socket://127.0.0.1:4000?bitrate=500000&node=5")
    assert address.place == ("slcan", "socket://127.0.0.1:4000")
    assert (address.number("bitrate"), address.node_id(1)) == (500_000, 5)


@pytest.mark.parametrize(
    ("url", "port", "baudrate", "node"),
    [
        ("serial:/dev/ttyUSB0", "/dev/ttyUSB0", 921_600, 1),
        ("serial:COM3?baudrate=115200", "COM3", 115_200, 1),
        ("serial:socket://127.0.0.1:5005?node=7", "socket://127.0.0.1:5005", 921_600, 7),
        ("serial:rfc2217://host:1?ign_set_control?node=2", "rfc2217://host:1?ign_set_control", 921_600, 2),
    ],
)
def test_serial_with_a_port_that_has_colons_and_slashes(
    url: str, port: str, baudrate: int, node: int
) -> None:
    address = registry.parse(url)
    assert (address.scheme, registry.carrier(address).name, address.place) == ("serial", "serial", (port,))
    assert (address.number("baudrate") or DEFAULT_BAUDRATE, address.node_id(1)) == (baudrate, node)


def test_the_emulated_drive_has_two_wires() -> None:
    assert registry.carrier(registry.parse("emulated")).name == "can"
    assert registry.carrier(registry.parse("emulated?wire=serial")).name == "serial"
    assert registry.carrier(registry.parse("can:slcan:/dev/ttyACM0")).name == "can"


def test_examples_in_the_help_are_addresses_with_the_defaults_that_there_are() -> None:
    spellings = [part.strip("'.") for part in registry.links_help().replace(" or ", ", ").split(", ")]
    addresses = [registry.parse(each) for each in spellings]
    assert [each.scheme for each in addresses] == ["emulated", "can", "serial", "replay"]
    assert addresses[2].number("baudrate") == DEFAULT_BAUDRATE


@pytest.mark.parametrize(
    ("url", "complaint"),
    [
        ("serial", "is not known: use"),
        ("serial:", "is not known: use"),
        ("serial:/dev/ttyUSB0?baud=9600", "unknown option 'baud', known are baudrate, node"),
        ("serial:/dev/ttyUSB0?baudrate=fast", "option 'baudrate' is 'fast', a whole number is expected"),
        ("emulated?wire=usb", "wire 'usb' is not known, known are can, serial"),
        ("can:slcan", "link 'can:slcan' is not known: use 'can:INTERFACE:CHANNEL?bitrate=500000&node=1'"),
        ("replay:", "use 'replay:DIR' with the folder of a run that was recorded with --frames"),
        (
            "ethernet:foo:bar",
            "is not known: use 'emulated', 'can:INTERFACE:CHANNEL?bitrate=500000&node=1', 's",
        ),
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
        registry.parse(url).node_id(1)
    assert complaint in str(refused.value)
