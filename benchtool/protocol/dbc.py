"""Messages of instruments on a CAN bus, as a DBC file describes them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchtool.document import closest
from benchtool.errors import ProfileError

if TYPE_CHECKING:
    from cantools.database import Message
    from cantools.database.can import Signal


@dataclass(frozen=True)
class SignalRange:
    """Range of one signal: its unit, the value of one bit and the limits that its DBC file states.

    Values are physical, in `unit` as the file spells it. `minimum` and `maximum` are infinite where the file
    states no range.
    """

    name: str
    unit: str
    resolution: float
    minimum: float
    maximum: float

    def holds(self, value: float) -> bool:
        """Return whether a finite value is within the range, with half a bit of rounding allowed."""
        slack = 0.5 * self.resolution
        return math.isfinite(value) and self.minimum - slack <= value <= self.maximum + slack


class DbcMessage:
    """One message of a DBC file and some of its signals.

    Args:
        path: the file.
        name: the message's.
        signals: names of the signals, each a physical number.

    Raises:
        ProfileError: the file cannot be read or is not a DBC file, or lacks the message or a signal.
    """

    def __init__(self, path: Path, name: str, signals: Sequence[str]) -> None:
        self._message = _load(path, name)
        self._path = path
        self.name = name
        self.can_id: int = self._message.frame_id
        self.extended: bool = self._message.is_extended_frame
        self.is_fd: bool = self._message.is_fd
        self.length: int = self._message.length
        self.ranges: Mapping[str, SignalRange] = {each: _range(self._signal(each)) for each in signals}

    def decode(self, data: bytes) -> Mapping[str, float] | None:
        """Return the physical values of the signals; None for bytes that are not this message.

        Too few bytes, a multiplexer that selects other signals and other undecodable data give None. More
        bytes than the message has are the padding of CAN FD. Never raises.
        """
        if len(data) < self.length:
            return None
        try:
            found = self._message.decode_simple(data, decode_choices=False)
            return {name: float(found[name]) for name in self.ranges}  # type: ignore[arg-type]
        except Exception:  # noqa: BLE001 # bytes from outside: whatever the decoder makes of them
            return None

    def encode(self, values: Mapping[str, float]) -> bytes:
        """Return the message with these physical values, each held within its range; other signals are as
        initial.

        Used by emulated instruments.
        """
        content = {each.name: each.initial or 0 for each in self._message.signals}
        for name, value in values.items():
            each = self.ranges[name]
            content[name] = min(max(value, each.minimum), each.maximum)
        return self._message.encode(content, strict=False)

    def _signal(self, name: str) -> Signal:
        for signal in self._message.signals:
            if signal.name == name:
                return signal
        names = [signal.name for signal in self._message.signals]
        raise ProfileError(
            f"{self._path}: message '{self.name}' has no signal '{name}': {closest(name, names)}"
        )


def _load(path: Path, name: str) -> Message:
    import cantools  # takes half a second, and few benches need it
    from cantools.database.can import Database

    try:
        database = cantools.database.load_file(path, database_format="dbc", strict=True)
    except OSError as reason:
        raise ProfileError(f"cannot read {path}: {reason.strerror}; a DBC file is expected") from None
    except Exception as reason:  # noqa: BLE001  the parser raises various exceptions
        raise ProfileError(f"{path} is no DBC file: {reason}; export it again from the instrument") from None
    assert isinstance(database, Database)
    for message in database.messages:
        if message.name == name:
            return message
    names = [message.name for message in database.messages]
    raise ProfileError(f"{path} has no message '{name}': {closest(name, names)}")


def _range(signal: Signal) -> SignalRange:
    resolution = abs(float(signal.scale))
    minimum, maximum = signal.minimum, signal.maximum
    return SignalRange(
        signal.name,
        signal.unit or "",
        0.0 if signal.is_float else resolution,
        -math.inf if minimum is None else float(minimum),
        math.inf if maximum is None else float(maximum),
    )
