"""Addresses of links, as `--link` takes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import parse_qsl

from benchtool.errors import UsageError

_OPTIONS = {"emulated": {"channel", "node"}, "can": {"bitrate", "node"}, "replay": {"node"}}


@dataclass(frozen=True)
class Address:
    """`emulated`, `can:INTERFACE:CHANNEL` or `replay:DIR`, followed by options: `?bitrate=500000&node=1`.

    `interface` and `channel` are python-can's; on an emulated bench `channel` names its virtual bus, of a
    replay it is the folder of the bundle.
    """

    kind: str
    interface: str
    channel: str
    options: Mapping[str, str]

    @classmethod
    def parse(cls, url: str) -> Address:
        """Address that `url` spells.

        Raises:
            UsageError: it is of neither form, or an option is unknown or wrong.
        """
        head, _, query = url.partition("?")
        kind, *place = head.split(":", 1 if head.startswith("replay:") else 2)
        options = dict(parse_qsl(query, keep_blank_values=True))
        if (kind, len(place)) not in (("emulated", 0), ("can", 2), ("replay", 1)):
            raise UsageError(
                f"link '{url}' is not known: use 'emulated', 'can:INTERFACE:CHANNEL?bitrate=500000&node=1' "
                f"or 'replay:DIR' with the folder of a run that was recorded with --frames"
            )
        for key, value in options.items():
            if key not in _OPTIONS[kind]:
                known = ", ".join(sorted(_OPTIONS[kind]))
                raise UsageError(f"link '{url}': unknown option '{key}', known are {known}")
            if key != "channel" and not value.isdecimal():
                raise UsageError(f"link '{url}': option '{key}' is '{value}', a whole number is expected")
        if kind == "replay":
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
