"""The limits of a profile while a case runs: beyond one the motor is braked, and the case ends."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from benchtool.bench import Session
from benchtool.errors import BenchError, LimitTrip
from benchtool.telemetry import DEFAULT_CHANNELS, LiveLimits

_READING_S = 1.0


def supervised_channels(session: Session) -> tuple[str, ...]:
    """Return channels for a stream that has what the limits need; none for the usual ones."""
    needed = session.profile.limits.channels
    if not needed:
        return ()
    wanted = (*needed, *(name for name in DEFAULT_CHANNELS if name not in needed))
    return session.drive.link.process_data.fitting(session.drive.dictionary, wanted)


def stopping(session: Session, limits: LiveLimits) -> Callable[[], None]:
    """Return a watch that raises a breach of the limits after a quick stop of the drive."""
    drive, read_s = session.drive, -_READING_S
    limited = session.profile.limits.temperature_degC is not None
    thermometer = session.thermometer if limited else None

    def check() -> None:
        nonlocal read_s
        try:
            limits.check()
            if thermometer is not None and drive.clock.now_s() - read_s >= _READING_S:
                read_s = drive.clock.now_s()
                limits.check_temperature(thermometer.temperatures().winding_degC)
        except LimitTrip as trip:
            with suppress(BenchError):  # the way out disables it in any case
                drive.quick_stop()
            raise trip

    return check
