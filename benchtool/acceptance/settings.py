"""What the command line of pytest states of the bench, as values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from benchtool.errors import UsageError
from benchtool.recording import Conditions
from benchtool.results import Waiver


@dataclass(frozen=True)
class Settings:
    """Settings of a session.

    Attributes:
        profile: name or file of a profile.
        link: address of the drive.
        out: folder of the session.
        seed: of an emulated bench's noise.
        real_time: pace an emulated bench by the wall clock.
        alter: what differs on an emulated bench.
        conditions: what the operator states.
        waivers: tests that may fail.
        bare: verdicts alone, without report, pictures and recorded data.
        pdf: write the report as PDF, too.
        history: earlier sessions that the report compares with.
    """

    profile: str
    link: str
    out: Path
    seed: int = 0
    real_time: bool = False
    alter: Mapping[str, float] = field(default_factory=dict)
    conditions: Conditions = field(default_factory=Conditions)
    waivers: tuple[Waiver, ...] = ()
    bare: bool = False
    pdf: bool = False
    history: int = 10


def require_usable(profile: str, link: str, workers: int) -> None:
    """Refuse a bench that cannot be opened, and a drive that several workers would share.

    Raises:
        ProfileError, UsageError: it cannot.
    """
    from benchtool.bench import equipment_of
    from benchtool.bench.wires import FarEnd, registry

    equipment_of(profile, link)
    if workers > 1 and registry.far_end(link) is not FarEnd.EMULATED_DRIVE:
        raise UsageError(
            f"{workers} workers would share the drive at '{link}', one is expected: leave out -n, or use an "
            f"emulated bench, of which each worker has its own"
        )


def alterations(given: Sequence[str]) -> dict[str, float]:
    """Return the keys and values of `KEY=VALUE`.

    Raises:
        UsageError: one is not of this form.
    """
    found: dict[str, float] = {}
    for each in given:
        key, _, value = each.partition("=")
        try:
            found[key] = int(value) if value.lstrip("-").isdecimal() else float(value)
        except ValueError:
            raise UsageError(
                f"--bench-alter {each}: KEY=VALUE with a number is expected, such as inverter.u_dc_V=110"
            ) from None
    return found
