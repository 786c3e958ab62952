"""Parameters: what the profile states is held, limits are kept, what is saved survives a reset."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from benchtool.acceptance import Measure
from benchtool.acceptance.suite.conditions import require_objects
from benchtool.bench import Session
from benchtool.drive import Capability
from benchtool.drive.parameters import reset, restore_defaults, snapshot, store, write_all
from benchtool.errors import SdoAbort, ValueRefused
from benchtool.protocol import Mode
from benchtool.protocol.dictionary import Variable
from benchtool.run import check_parameters

pytestmark = pytest.mark.requirement("ACC-PARAMETERS")


def test_profile_is_held(bench_session: Session, measure: Measure) -> None:
    """The drive holds what the profile states of it."""
    check = check_parameters(bench_session.drive, bench_session.profile, ())
    told = ", ".join(f"{each.key} is {each.b}, the profile states {each.a}" for each in check.contradicted)
    measure("parameters_that_differ", len(check.contradicted), max=0, reason=told)
    measure("parameters_not_there", len(check.absent), max=0)
    assert not told, told


def test_limits_of_parameters(bench_session: Session, measure: Measure) -> None:
    """A value beyond the limits of a parameter is refused by the drive itself, and the old one stays."""
    refused, taken = 0, []
    for variable in _parameters(bench_session):
        for raw in _beyond(variable):
            before = bench_session.drive.read(variable)
            try:
                bench_session.drive.link.download(variable.index, variable.sub, raw)
            except SdoAbort:
                refused += 1
            else:
                taken.append(variable.name)
            if bench_session.drive.read(variable) != before:
                bench_session.drive.write(variable, before)
                taken.append(variable.name)
    if not refused and not taken:
        pytest.skip("no parameter of the dictionary has limits")
    measure("values_refused", refused, min=1)
    measure("values_taken_beyond_their_limits", len(taken), max=0, reason=", ".join(dict.fromkeys(taken)))


def test_locked_while_enabled(bench_session: Session, measure: Measure) -> None:
    """Parameters that must not change while the power stage is on are refused then."""
    drive = bench_session.drive
    locked = [each for each in _parameters(bench_session) if not each.enabled_write]
    if not locked:
        pytest.skip("the dictionary names no parameter that is locked while the power stage is on")
    taken = []
    with drive.enabled(Mode.VELOCITY):
        for variable in locked:
            try:
                drive.link.download(variable.index, variable.sub, variable.encode(drive.read(variable)))
            except SdoAbort:
                continue
            taken.append(variable.name)
    measure("locked_parameters_taken", len(taken), max=0, reason=", ".join(taken))


def test_saved_parameters_survive_a_reset(bench_session: Session, measure: Measure) -> None:
    """Every parameter is there again after a save and a reset; what was not saved is not."""
    drive = bench_session.drive
    _require_storage(bench_session)
    with _kept(bench_session):
        moved = _moved(bench_session)
        write_all(drive, moved)
        saved = snapshot(drive)
        store(drive)
        unsaved = _moved(bench_session)
        write_all(drive, unsaved)
        reset(drive)
        found = snapshot(drive)
    lost = [key for key, value in saved.items() if found.get(key) != value]
    measure("parameters_moved", len(moved), min=1)
    measure("parameters_not_as_saved", len(lost), max=0, reason=", ".join(lost))


def test_defaults_are_restored(bench_session: Session, measure: Measure) -> None:
    """On command the drive goes back to the defaults of its dictionary."""
    drive = bench_session.drive
    _require_storage(bench_session)
    require_objects(bench_session, "restore_all")
    with _kept(bench_session):
        values = restore_defaults(drive)
    measure("defaults_restored", len(values), min=1)


def _parameters(session: Session) -> list[Variable]:
    found = [each for each in session.drive.dictionary if each.role == "parameter"]
    if not found:
        pytest.skip("the drive's dictionary does not say which of its objects are parameters")
    return [each for each in found if each.readable and each.writable]


def _beyond(variable: Variable) -> Iterator[bytes]:
    """Yield values just beyond the limits of a parameter, as the drive would get them."""
    for limit, step in ((variable.raw_maximum, 1), (variable.raw_minimum, -1)):
        if limit is None or variable.values is not None or variable.type.numpy is None:
            continue
        raw = float(limit) + step * max(1.0, 0.01 * abs(float(limit)))
        kind = variable.type.numpy
        if kind.kind == "f":
            yield kind.type(raw).tobytes()
            continue

        bounds = np.iinfo(kind)
        if bounds.min <= raw <= bounds.max:
            yield kind.type(round(raw)).tobytes()


def _moved(session: Session) -> dict[str, float]:
    """Return other values of the parameters with a real number, as near as can be told apart."""
    drive, found = session.drive, {}
    for variable in _parameters(session):
        value = drive.read(variable)
        if not isinstance(value, float) or variable.type.numpy is None or variable.type.numpy.kind != "f":
            continue
        moved = value * (1.0 - 1e-4) if value else 1e-4
        try:
            variable.encode(moved)
        except ValueRefused:
            moved = value * (1.0 + 1e-4)
        found[variable.name] = moved
    return found


def _require_storage(session: Session) -> None:
    if Capability.STORAGE not in session.drive.capabilities:
        pytest.skip("the drive stores no parameters on command")


@contextmanager
def _kept(session: Session) -> Iterator[None]:
    """Put every parameter back afterwards, stored as it was."""
    drive = session.drive
    before = {each.name: drive.read(each) for each in _parameters(session)}
    try:
        yield
    finally:
        write_all(drive, before)
        store(drive)
        if drive.state().value.startswith("fault"):  # by trip levels that were the dictionary's for a moment
            drive.reset_fault()
        drive.emergencies()
