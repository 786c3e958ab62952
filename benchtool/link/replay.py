"""A recorded session as a link: the same frames at the same times, answers where the recording has them."""

from __future__ import annotations

import io
from collections import defaultdict, deque
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import can
from can.io import CanutilsLogReader

from benchtool.clock import VirtualClock
from benchtool.errors import LinkClosed, LinkError, NoAnswer, SdoAbort
from benchtool.link.canopen.process_data import PdoProcessData
from benchtool.link.canopen.sdo_transcript import Kind, Transfer, transfers
from benchtool.link.interface import Frame, FrameReceiver, LinkCounters, ReceivedEmergency
from benchtool.protocol.canopen import Emergency, NmtCommand, NmtState, abort_text, cob_id, heartbeat_state

FRAMES = Path("data", "frames.log")
"""Where a bundle keeps its frames, in the format of `candump -L`."""

_ROUNDING_S = 1e-6  # of the times in the file
_AFTER_THE_END_S = 0.5


class ReplayLink:
    """A `FrameLink` that plays the frames of a bundle; time passes by waiting.

    A read gets the recorded answer at its recorded time: the first read the first answer, each further one
    the next, and when there are no more the value last read or written. A write is confirmed if the recording
    has the same; nothing else can be commanded.

    Args:
        bundle: folder of the bundle.
        node_id: the recorded drive's.
        clock: whose waiting plays the frames.

    Raises:
        LinkError: the bundle has no frames, or they cannot be read.
    """

    def __init__(self, bundle: Path, node_id: int, clock: VirtualClock) -> None:
        self._bundle = bundle
        self._node_id = node_id
        self.clock = clock
        self._frames = _read_frames(bundle)
        self._position = 0
        self._receivers: dict[int, FrameReceiver] = {}
        self._state: NmtState | None = None
        self._emergencies: deque[ReceivedEmergency] = deque()
        self._counters = LinkCounters()
        self._reads: dict[tuple[int, int], deque[Transfer]] = defaultdict(deque)
        self._writes: dict[tuple[tuple[int, int], bytes], deque[Transfer]] = defaultdict(deque)
        self._known: dict[tuple[int, int], bytes] = {}
        self._closed = False
        self._sort_transfers()
        clock.follow(self._advance_to)

    @property
    def node_id(self) -> int:
        return self._node_id

    @property
    def counters(self) -> LinkCounters:
        return self._counters

    def upload(self, index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        """See `Link.upload`.

        Raises:
            NoAnswer: the recording has none for this object.
        """
        self._require_open()
        key = index, sub
        if not self._reads.get(key):
            if key in self._known:
                return self._known[key]
            raise NoAnswer(
                f"the recording {self._bundle} has no answer of node {self._node_id} for "
                f"0x{index:04X}:{sub}: a replay can tell only what was read then; ask for that, or use the "
                f"drive's link"
            )
        transfer = self._next(self._reads[key])
        if transfer.kind is Kind.ABORTED:
            code = int.from_bytes(transfer.data, "little")
            self._count(sdo_aborts=1)
            raise SdoAbort(
                f"node {self._node_id} refused reading 0x{index:04X}:{sub}: {abort_text(code)}", code
            )
        self._known[key] = transfer.data if transfer.sized else transfer.data[:length]
        return self._known[key]

    def download(self, index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        """See `Link.download`.

        Raises:
            LinkError: the recording has no such write.
        """
        self._require_open()
        key = index, sub
        recorded = self._writes.get((key, data))
        if recorded is None:
            raise LinkError(
                f"the recording {self._bundle} has no write of {data.hex(' ')} to 0x{index:04X}:{sub}: "
                f"a replay does only what was done then; use the same options, or the drive's link"
            )
        if recorded:
            self._next(recorded)
        self._known[key] = data

    def nmt(self, command: NmtCommand) -> None:
        """See `Link.nmt`; the effect is in the recording."""
        self._require_open()

    def send_heartbeat(self) -> None:
        """See `Link.send_heartbeat`; does nothing in a replay."""
        self._require_open()

    def send_pdo(self, can_id: int, data: bytes) -> None:
        """See `FrameLink.send_pdo`.

        Raises:
            LinkError: always, as there is no drive.
        """
        raise LinkError(f"the recording {self._bundle} takes no setpoints: use the drive's link")

    @property
    def process_data(self) -> PdoProcessData:
        """See `Link.process_data`."""
        return PdoProcessData(self)

    def heartbeat_state(self) -> NmtState | None:
        """See `Link.heartbeat_state`.

        Raises:
            LinkClosed: the recording is over.
        """
        self._require_open()
        end_s = self._frames[-1].timestamp
        if self.clock.now_s() > end_s + _AFTER_THE_END_S:
            raise LinkClosed(f"the recording {self._bundle} ends after {end_s:.2f} s: ask for less")
        return self._state

    def wait_heartbeat(self, timeout_s: float) -> NmtState:
        """See `Link.wait_heartbeat`."""
        heard = self._counters.heartbeats_received
        end_s = self.clock.now_s() + timeout_s
        while self.clock.now_s() < end_s:
            self.clock.wait(min(0.01, timeout_s))
            state = self.heartbeat_state()
            if state is not None and self._counters.heartbeats_received != heard:
                return state
        raise NoAnswer(f"the recording {self._bundle} has no heartbeat of node {self._node_id} at this time")

    def emergencies(self) -> tuple[ReceivedEmergency, ...]:
        """See `Link.emergencies`."""
        self._require_open()
        return tuple(self._emergencies.popleft() for _ in range(len(self._emergencies)))

    def subscribe(self, can_ids: Iterable[int], receiver: FrameReceiver) -> None:
        """See `FrameLink.subscribe`."""
        self._receivers |= dict.fromkeys(can_ids, receiver)

    def unsubscribe(self, can_ids: Iterable[int]) -> None:
        """See `FrameLink.unsubscribe`."""
        for can_id in can_ids:
            self._receivers.pop(can_id, None)

    def close(self) -> None:
        """See `Link.close`."""
        self._closed = True
        self.clock.unregister(self._advance_to)

    # ---- playing -------------------------------------------------------------------------------------------

    def _advance_to(self, now_s: float) -> None:
        while (
            self._position < len(self._frames)
            and self._frames[self._position].timestamp <= now_s + _ROUNDING_S
        ):
            self._play(self._frames[self._position])
            self._position += 1

    def _play(self, frame: can.Message) -> None:
        if not frame.is_rx:
            return
        can_id, data = frame.arbitration_id, bytes(frame.data)
        self._count(frames_received=1)
        if (receiver := self._receivers.get(can_id)) is not None:
            receiver(Frame(can_id, data, frame.timestamp))
        elif can_id == cob_id.HEARTBEAT + self._node_id and (state := heartbeat_state(data)) is not None:
            self._state = state
            self._count(heartbeats_received=1)
        elif can_id == cob_id.EMCY + self._node_id and (emergency := Emergency.decode(data)) is not None:
            self._emergencies.append(ReceivedEmergency(emergency, frame.timestamp))
            self._count(emcy_received=1)

    def _next(self, recorded: deque[Transfer]) -> Transfer:
        """Return the next of these transfers, in its time."""
        transfer = recorded.popleft()
        ahead_s = self._frames[transfer.position].timestamp - self.clock.now_s()
        if ahead_s > 0.0:
            self.clock.wait(ahead_s)
        return transfer

    def _sort_transfers(self) -> None:
        answer, request = cob_id.SDO_RESPONSE + self._node_id, cob_id.SDO_REQUEST + self._node_id
        sdo = (
            (position, frame.arbitration_id == answer, bytes(frame.data))
            for position, frame in enumerate(self._frames)
            if frame.arbitration_id in (answer, request)
        )
        for transfer in transfers(sdo):
            if transfer.kind is Kind.WRITTEN:
                self._writes[transfer.key, transfer.data].append(transfer)
            else:
                self._reads[transfer.key].append(transfer)

    def _count(self, **more: int) -> None:
        counts = {name: getattr(self._counters, name) + number for name, number in more.items()}
        self._counters = replace(self._counters, **counts)

    def _require_open(self) -> None:
        if self._closed:
            raise LinkClosed(f"the replay of {self._bundle} is closed: open it again")


def _read_frames(bundle: Path) -> list[can.Message]:
    """Return the frames of a bundle, with the time since the first; a last line that is half written is left
    out."""
    path = bundle / FRAMES
    try:
        text = path.read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError) as reason:
        why = reason.strerror if isinstance(reason, OSError) else "it is not text"
        raise LinkError(
            f"cannot replay {bundle}: {path}: {why}; the folder of a run that was recorded with --frames is "
            f"expected"
        ) from None
    try:
        with CanutilsLogReader(io.StringIO(text[: text.rfind("\n") + 1])) as reader:
            frames = list(reader)
    except (ValueError, IndexError) as reason:
        raise LinkError(
            f"cannot replay {path}: {reason}; lines as candump -L writes them are expected"
        ) from None
    if not frames:
        raise LinkError(f"cannot replay {path}: it holds no frame: record again with --frames")
    first_s = frames[0].timestamp
    for frame in frames:
        frame.timestamp -= first_s
    return frames
