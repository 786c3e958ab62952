"""The limits of a profile wherever a drive is enabled: beyond one the motor is braked, and its caller told.

While the drive is enabled its stream is looked at, of any caller; if there is none, one is opened here.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Final, Protocol

from benchtool.block import Block
from benchtool.errors import BenchError, CapabilityMissing, LimitTrip, ValueRefused
from benchtool.profile import Limits
from benchtool.telemetry.live_limits import LiveLimits
from benchtool.telemetry.stream import TelemetryStream
from benchtool.telemetry.streamed_drive import StreamedDrive

_READING_S: Final = 1.0


class SupervisedDrive(StreamedDrive, Protocol):
    """A drive that can be stopped."""

    def quick_stop(self) -> None: ...


class LimitSupervision:
    """See `StreamSupervisor`.

    Where time is real a breach stops the motor from a thread of its own, as the caller that enabled the drive
    may not be waiting; virtual time passes only while a caller waits, and that one is told.

    Args:
        drive: the drive.
        limits: of the profile.
        winding_degC: reads the thermometer of the winding; None, or giving None, without one.
        tell: takes the message of a motor that was stopped while no caller waited.
    """

    def __init__(
        self,
        drive: SupervisedDrive,
        limits: Limits,
        winding_degC: Callable[[], float | None] | None = None,
        tell: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._drive, self._limits = drive, limits
        self._winding_degC = winding_degC
        self._tell = tell
        self._judge = LiveLimits(limits)
        self._enabled = False
        self._read_s = 0.0
        self._others: tuple[str, ...] | None = None  # signals of the stream of a caller
        self._own: TelemetryStream | None = None
        self._opening = False
        self._claim = threading.Lock()  # who stops the motor
        self._claimed = False
        self._stopped = threading.Event()
        self._stopper: threading.Thread | None = None

    @property
    def channels(self) -> tuple[str, ...]:
        """See `StreamSupervisor.channels`."""
        return self._limits.channels

    # ---- while the drive is enabled ------------------------------------------------------------------------

    def begin(self) -> None:
        """See `StreamSupervisor.begin`.

        Raises:
            CapabilityMissing: the drive does not stream what the limits are of, or no thermometer reads the
                winding.
            ValueRefused: it streams something else at the moment.
        """
        if self._limits.temperature_degC is not None and self._reading() is None:
            raise CapabilityMissing(
                "[limits] of the profile have temperature_degC, and no thermometer reads the winding: name "
                "one in [bench.temperature], or leave that limit out; the drive was not enabled"
            )
        self._join()
        self._judge = LiveLimits(self._limits)
        self._claimed, self._read_s = False, self._drive.clock.now_s() - _READING_S
        self._stopped.clear()
        if self._others is not None:
            self._require_all(self._others)
        elif self.channels:
            self._open()
        self._enabled = True

    def end(self) -> None:
        """See `StreamSupervisor.end`."""
        self._enabled = False
        own, self._own = self._own, None
        if own is not None:
            with suppress(BenchError):
                own.__exit__(None, None, None)
        self._join()

    def check(self) -> None:
        """See `StreamSupervisor.check`."""
        if self._enabled and self._limits.temperature_degC is not None:
            now_s = self._drive.clock.now_s()
            if now_s - self._read_s >= _READING_S:
                self._read_s = now_s
                self._judge.take_temperature(self._reading())
        if self._judge.passed:
            self._stop()
            judge, self._judge = self._judge, LiveLimits(self._limits)  # which is told once
            judge.check()
        if (own := self._own) is not None:
            own.check()

    def _reading(self) -> float | None:
        return None if self._winding_degC is None else self._winding_degC()

    # ---- streams -------------------------------------------------------------------------------------------

    def stream_opens(self, names: Sequence[str]) -> None:
        """See `StreamSupervisor.stream_opens`."""
        if self._opening:
            return
        if self._enabled:
            self._require_all(names)
        self._close_own()
        self._others = tuple(names)

    def stream_closed(self) -> None:
        """See `StreamSupervisor.stream_closed`."""
        if self._own is not None or self._others is None:
            return
        self._others = None
        if self._enabled and self.channels:
            self._open()

    def take(self, block: Block) -> None:
        """See `StreamSupervisor.take`."""
        if not self._enabled:
            return
        self._judge.take(block)
        if self._judge.passed and not self._drive.clock.virtual and self._stopper is None:
            self._stopper = threading.Thread(target=self._stop_unattended, name="benchtool-limits")
            self._stopper.start()

    def _open(self) -> None:
        fitting = self._drive.link.process_data.fitting(self._drive.dictionary, self.channels)
        if lacking := [name for name in self.channels if name not in fitting]:
            raise CapabilityMissing(
                f"[limits] of the profile are of {', '.join(lacking)}, which the drive does not stream: "
                f"leave out what cannot be supervised; the drive was not enabled"
            )
        self._opening = True
        try:
            stream = TelemetryStream(self._drive, (), fitting)
            self._own = stream.__enter__()
        finally:
            self._opening = False

    def _close_own(self) -> None:
        own, self._own = self._own, None
        if own is not None:
            self._opening = True
            try:
                own.__exit__(None, None, None)
            finally:
                self._opening = False

    def _require_all(self, names: Sequence[str]) -> None:
        if lacking := [name for name in self.channels if name not in names]:
            raise ValueRefused(
                f"the stream has no {', '.join(lacking)}, which [limits] of the profile supervise while the "
                f"drive is enabled: stream fewer other signals"
            )

    def _join(self) -> None:
        stopper = self._stopper
        if stopper is not None and stopper is not threading.current_thread():
            stopper.join()
            self._stopper = None

    # ---- stopping ------------------------------------------------------------------------------------------

    def _stop(self) -> None:
        """Brake and disable once, in the thread that comes first; return when that is done."""
        with self._claim:
            first, self._claimed = not self._claimed, True
        if not first:
            if threading.current_thread() is not self._stopper:
                self._stopped.wait()
            return
        try:
            if self._enabled:
                with suppress(BenchError):  # the way out disables it in any case
                    self._drive.quick_stop()
        finally:
            self._stopped.set()

    def _stop_unattended(self) -> None:
        self._stop()
        try:
            self._judge.check()
        except LimitTrip as trip:
            self._tell(str(trip))
