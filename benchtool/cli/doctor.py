"""`benchtool doctor`."""

from __future__ import annotations

import platform
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from benchtool.bench import emulator_is_compiled, equipment_of, open_session
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import BenchError, EnvironmentFailure
from benchtool.protocol.dictionary import Dictionary, load_table
from benchtool.recording import software_versions
from benchtool.run import readings
from benchtool.shipped import shipped

_LEAST_FREE_BYTES = 1_000_000_000


def doctor(
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Check this machine: packages, shipped files, disk, the compiled emulator, and a drive that answers."""
    output = Output(as_json=as_json)
    checks: list[tuple[str, Callable[[], str]]] = [
        ("python", _python),
        ("packages", _packages),
        ("dictionary", _dictionary),
        ("folder", _folder),
        ("emulator", lambda: _emulator(profile)),
        ("equipment", lambda: _equipment(profile, link)),
        ("drive", lambda: _drive(profile, link, output)),
    ]
    outcomes = [(name, *_outcome(check)) for name, check in checks]
    rows = [(name, "ok" if good else "failed", text) for name, good, text in outcomes]
    output.table("doctor", ("check", "outcome", "what was seen"), rows)
    output.document({name: {"ok": good, "seen": text} for name, good, text in outcomes})
    return 0 if all(good for _, good, _ in outcomes) else EnvironmentFailure.exit_code


def _outcome(check: Callable[[], str]) -> tuple[bool, str]:
    try:
        return True, check()
    except BenchError as error:
        return False, str(error)


def _python() -> str:
    if sys.version_info < (3, 11):  # noqa: UP036 # installed by hand, past the packaging's own check
        raise EnvironmentFailure(f"Python {platform.python_version()}, at least 3.11 is needed: install it")
    return f"Python {platform.python_version()} on {platform.platform()}"


def _packages() -> str:
    return ", ".join(f"{name} {version}" for name, version in software_versions().items())


def _dictionary() -> str:
    folder = shipped("firmware_protocol")
    eds = folder / "drive.eds"
    dictionary, table = Dictionary.from_eds(eds, 1), load_table(folder / "objects.toml")
    if dictionary.hash != table.hash:
        raise EnvironmentFailure(
            f"{eds} is of another version than objects.toml: run 'python -m firmware_protocol.generate'"
        )
    return f"{len(dictionary)} objects, hash 0x{table.hash:08X}, {eds}"


def _folder() -> str:
    here = Path.cwd()
    try:
        with tempfile.TemporaryFile(dir=here):
            pass
    except OSError as reason:
        raise EnvironmentFailure(
            f"cannot write to {here}: {reason.strerror}; run bundles are written here: "
            f"change folder or use --out"
        ) from None
    free = shutil.disk_usage(here).free
    if free < _LEAST_FREE_BYTES:
        raise EnvironmentFailure(f"{free / 1e9:.1f} GB free in {here}, at least 1 GB is needed: make room")
    return f"{here} is writable, {free / 1e9:.0f} GB free"


def _emulator(profile: str) -> str:
    return "compiled" if emulator_is_compiled(profile) else "will be compiled at its first run, a few seconds"


def _equipment(profile: str, link: str) -> str:
    """Return what the profile's bench has, and whether it sends."""

    told = "; ".join(f"{name}: {text}" for name, text in equipment_of(profile, link).lines().items())
    with open_session(profile, link) as session:
        readings(session)
    return told


def _drive(profile: str, link: str, output: Output) -> str:
    with open_session(profile, link, note=output.note, instruments=False) as session:
        identity = session.drive.identify()
        identity.require(session.drive.dictionary, session.drive.dictionary.source)
        state = session.drive.state()
        warnings = session.drive.dictionary.warnings
        for warning in warnings:
            output.note(f"{session.drive.dictionary.source}: {warning}")
        noted = f"; {len(warnings)} warnings about its EDS, above" if warnings else ""
        return f"{identity.device_name} at {link}, node {session.drive.link.node_id}: {state.value}{noted}"
