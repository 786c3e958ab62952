"""Addresses of links, as `--link` takes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import parse_qsl

from benchtool.errors import UsageError

DEFAULT_BAUDRATE = 921_600
"""The fastest that common USB adapters and microcontrollers both have; ports without a line ignore it."""

_WIRES = ("can", "serial")
_OPTIONS = {
    "emulated": {"channel", "node", "wire"},
    "can": {"bitrate", "node"},
    "serial": {"baudrate", "node"},
    "replay": {"node"},
}
_WORDS = ("channel", "wire")


@dataclass(frozen=True)
class Address:
    """`emulated`, `can:INTERFACE:CHANNEL`, `serial:PORT` or `replay:DIR`, followed by options: `?node=1`.

    `interface` and `channel` are python-can's; on an emulated bench `channel` names its virtual bus, of a
    serial line it is the port or a URL of pyserial, of a replay the folder of the bundle.
    """

    kind: str
    interface: str
    channel: str
    options: Mapping[str, str]

    @classmethod
    def parse(cls, url: str) -> Address:
        """Address that `url` spells.

        Raises:
            UsageError: it is of no known form, or an option is unknown or wrong.
        """
        # The URL of a port may have options of its own before ours.
        parts = url.rpartition("?") if url.startswith("serial:") and "?" in url else url.partition("?")
        head, _, query = parts
        kind, *place = head.split(":", 1 if head.startswith(("replay:", "serial:")) else 2)
        options = dict(parse_qsl(query, keep_blank_values=True))
        known_forms = (("emulated", 0), ("can", 2), ("serial", 1), ("replay", 1))
        if (kind, len(place)) not in known_forms or (kind == "serial" and not place[0]):
            raise UsageError(
                f"link '{url}' is not known: use 'emulated', 'can:INTERFACE:CHANNEL?bitrate=500000&node=1', "
                f"'serial:PORT?baudrate={DEFAULT_BAUDRATE}&node=1' or 'replay:DIR' with the folder of a run "
                f"that was recorded with --frames"
            )
        for key, value in options.items():
            if key not in _OPTIONS[kind]:
                known = ", ".join(sorted(_OPTIONS[kind]))
                raise UsageError(f"link '{url}': unknown option '{key}', known are {known}")
            if key not in _WORDS and not value.isdecimal():
                raise UsageError(f"link '{url}': option '{key}' is '{value}', a whole number is expected")
        if options.get("wire", "can") not in _WIRES:
            raise UsageError(f"link '{url}': wire '{options['wire']}' is not known, known are can, serial")
        if kind in ("replay", "serial"):
            return cls(kind, "", place[0], options)
        interface, channel = place or ("virtual", options.get("channel", ""))
        return cls(kind, interface, channel, options)

    def node_id(self, default: int) -> int:
        """The node that the address names, else `default`.

        Raises:
            UsageError: it is not 1 to 126; 127 is the host itself.
        """
        node_id = int(self.options.get("node", default))
        if not 1 <= node_id <= 126:
            raise UsageError(f"node id {node_id} is outside 1 to 126: choose the drive's node id")
        return node_id

    @property
    def bitrate(self) -> int | None:
        """Bit rate in bit/s; None leaves the adapter as it is set."""
        return int(self.options["bitrate"]) if "bitrate" in self.options else None

    @property
    def baudrate(self) -> int:
        """Baud rate of a serial line in bit/s."""
        return int(self.options.get("baudrate", DEFAULT_BAUDRATE))

    @property
    def wire(self) -> str:
        """What the frames of the drive go over: `can` or `serial`."""
        return "serial" if self.kind == "serial" else self.options.get("wire", "can")
