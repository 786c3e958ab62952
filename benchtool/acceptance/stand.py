"""The bench of one test: opened for it, checked after it, and left safe whatever happened."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from typing import TYPE_CHECKING, Final

from benchtool.acceptance.notes import Notes
from benchtool.acceptance.settings import Settings
from benchtool.errors import BenchError
from benchtool.protocol.canopen import NmtCommand

if TYPE_CHECKING:
    from benchtool.api import Bench
    from benchtool.bench import Session
    from benchtool.recording import Event

_CLEAN: Final = (
    "frames_dropped",
    "receive_errors",
    "overruns",
    "retries",
    "stale_answers",
    "emcy_lost",
)
"""Counters of the link that stay at zero on a clean one."""

_FAULT_ENDS_S: Final = 0.3  # what was on a wire has arrived, and a heartbeat was heard
_SETTLES_S: Final = 0.02
_OF_THE_DRIVE: Final = ("rpdo_dropped", "serial_dropped")


class NotHealthy(AssertionError):
    """A test did not leave the drive or the link as it should."""


@contextmanager
def standing(settings: Settings, notes: Notes) -> Iterator[Bench]:
    """Open the bench for a test; on the way out the drive is disabled and the load is off.

    A drive that is found in fault is reset first, which is noted. After a test that passed the drive must be
    healthy and the link clean; after one that failed the drive is made safe and its fault is reset.

    Raises:
        BenchError: the bench cannot be opened, or the drive does not confirm that it is disabled.
        NotHealthy: the test passed, and left a fault, an enabled drive, or a link with errors.
    """
    from benchtool.api import open_bench, session_of
    from benchtool.telemetry import keep_journal

    def take(event: Event) -> None:
        place = "" if event.tick is None else f"tick {event.tick}: "
        notes.events.append(f"{place}{event.text}")

    with open_bench(
        settings.profile,
        settings.link,
        seed=settings.seed,
        real_time=settings.real_time,
        emulator=settings.alter,
        progress=notes.lines.append,
    ) as bench:
        with session_of(bench) as session:
            _note_facts(session, notes)
            _leave_fault(session, notes, "when the test began")
            before = _counted(session)
        with keep_journal(session.drive, (take,)):
            yield bench
            with session_of(bench) as session:
                if notes.injected:
                    _end_faults(session, notes)
                if notes.failed:
                    _make_safe(session, notes)
                elif complaints := tuple(_complaints(session, None if notes.injected else before)):
                    _make_safe(session, notes)
                    raise NotHealthy(f"after the test {'; '.join(complaints)}")


def _note_facts(session: Session, notes: Notes) -> None:
    """Note what the session's record says of drive and bench."""
    identity = asdict(session.drive.identify())
    notes.facts["identity"] = {key: value for key, value in identity.items() if value is not None}
    notes.facts["profile_toml"] = session.profile_toml
    notes.facts["sensors"] = [
        ", ".join(
            (
                f"{channel}: {each.label}",
                f"calibrated {each.calibrated}" if each.calibrated else "date of calibration not stated",
                *((f"due {each.due}",) if each.due else ()),
            )
        )
        for channel, each in session.profile.bench.channels.items()
        if each.label
    ]


def _counted(session: Session) -> dict[str, float]:
    names = [name for name in _OF_THE_DRIVE if name in session.drive.dictionary]
    return {name: session.drive.number(name) for name in names}


def _leave_fault(session: Session, notes: Notes, when: str) -> None:
    if session.drive.state().value.startswith("fault"):
        notes.lines.append(f"the drive was in fault {when}; the fault was reset")
        session.drive.reset_fault()
        session.drive.emergencies()


def _end_faults(session: Session, notes: Notes) -> None:
    """End the faults that a test has injected, and what they have left: another host would find it so."""
    assert session.faults is not None
    session.faults.end()
    notes.lines.append(f"injected: {', '.join(notes.injected)}")
    session.clock.wait(_FAULT_ENDS_S)
    if session.drive.is_stopped:
        session.drive.link.nmt(NmtCommand.START)
    _make_safe(session, notes)
    with suppress(BenchError):
        session.drive.reset_fault()
    session.drive.emergencies()
    session.clock.wait(_SETTLES_S)  # a fault whose cause stays is there again


def _make_safe(session: Session, notes: Notes) -> None:
    """Switch the power stage and the load off and leave the fault, whatever of it fails."""
    try:
        if session.load is not None:
            session.load.apply(0.0)
        if session.drive.state().power_stage_on:
            session.drive.disable()
        _leave_fault(session, notes, "when the test had failed")
    except BenchError as failed:
        notes.lines.append(f"safe state not confirmed: {failed}")


def _complaints(session: Session, before: dict[str, float] | None) -> Iterator[str]:
    """Yield what is not as it should be after a test, half a sentence each.

    The link is looked at if `before` says what it had counted when the test began.
    """
    drive = session.drive
    state = drive.state()
    if state.value.startswith("fault"):
        yield f"the drive is in '{state.value}', a reset fault is expected"
    elif state.power_stage_on:
        yield f"the drive is in '{state.value}', a power stage that is off is expected"
    if unread := [each.text for each in drive.emergencies() if each.code]:
        yield f"the drive had reported {', '.join(unread)}, which the test did not expect"
    if "error_code" in drive.dictionary and (code := int(drive.number("error_code"))):
        yield f"error_code is 0x{code:04X}, 0 is expected"
    if before is None:
        return
    counters = asdict(drive.link.counters)
    dirty = [f"{name} {counters[name]}" for name in _CLEAN if counters[name]]
    after = _counted(session)
    dirty += [f"{name} {after[name] - was:+.0f}" for name, was in before.items() if after[name] != was]
    if dirty:
        yield f"the link was not clean: {', '.join(dirty)}"
