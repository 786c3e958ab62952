"""What tab completion proposes for the values of options and arguments; nothing is opened for it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from benchtool.errors import BenchError

if TYPE_CHECKING:
    from benchtool.protocol.dictionary import Dictionary

_DEFAULT_PROFILE = "zhu2011"


def plans(incomplete: str) -> list[str]:
    """Return the shipped plans, their folders, and TOML files."""
    from benchtool.plan import shipped_plans

    names = shipped_plans()
    folders = sorted({name.partition("/")[0] for name in names}) if "/" not in incomplete else []
    return [*folders, *names, *_files(incomplete, ".toml")]


def profiles(incomplete: str) -> list[str]:
    """Return the shipped profiles and TOML files."""
    from benchtool.profile import shipped_profiles

    return [*shipped_profiles(), *_files(incomplete, ".toml")]


def links(incomplete: str) -> list[str]:
    """Return the emulated bench, this machine's ports and CAN interfaces, and how the others begin."""
    from benchtool.bench.wires import registry

    found = [
        "emulated",
        "emulated?wire=serial",
        "can:socketcan:",
        "can:slcan:",
        "can:pcan:",
        "can:kvaser:",
        "replay:",
    ]
    found += [f"can:socketcan:{name}" for name in _can_interfaces()]
    with suppress(BenchError):
        found += [place for wire in registry.wires() for place in wire.own_places()]
    return found + ([f"replay:{path}" for path in _files(incomplete.removeprefix("replay:"), "")])


def destinations(incomplete: str) -> list[str]:
    """Return where a live view may be shown."""
    return ["viewer", "web", *_files(incomplete, ".rrd")]


def channels(ctx: typer.Context, incomplete: str) -> list[str]:
    """Signals of the drive, behind those that the list has already."""
    given, comma, _ = incomplete.rpartition(",")
    taken = given.split(",")
    return [f"{given}{comma}{name}" for name in _names(ctx, {"signal"}) if name not in taken]


def parameters(ctx: typer.Context, incomplete: str) -> list[str]:
    """Parameters of the drive."""
    return list(_names(ctx, {"parameter"}))


def objects(ctx: typer.Context, incomplete: str) -> list[str]:
    """Objects of the drive."""
    return list(_names(ctx, {"parameter", "signal", "status", "command"}))


def assignments(ctx: typer.Context, incomplete: str) -> list[str]:
    """Parameters of the drive, for their values."""
    return [f"{name}=" for name in _names(ctx, {"parameter"})]


def plan_keys(ctx: typer.Context, incomplete: str) -> list[str]:
    """Keys of a plan, for `--set`; limits by the measurements that there are."""
    dictionary = _dictionary(ctx)
    if dictionary is None:
        return []
    from benchtool.plan import catalogue, places_of

    if incomplete.startswith("limits."):
        names = [name for each in catalogue().analyses for name in each.names]
        return [f"limits.{name}.{bound}=" for name in dict.fromkeys(names) for bound in ("max", "min")]
    keys = [key for place in places_of(dictionary) for key in dict.fromkeys(place.spellings)]
    return [*(f"{key}=" for key in keys), "limits."]


def laws(incomplete: str) -> list[str]:
    """Control laws of the reference drive."""
    from benchtool.profile import LAWS

    return list(LAWS)


def _names(ctx: typer.Context, roles: Iterable[str]) -> Iterator[str]:
    dictionary = _dictionary(ctx)
    if dictionary is not None:
        yield from (variable.name for variable in dictionary if variable.role in set(roles))


def _dictionary(ctx: typer.Context) -> Dictionary | None:
    """The dictionary of the profile on the line, or of the default one; None where that is wrong."""
    from benchtool.profile import load_profile, profile_path
    from benchtool.protocol.dictionary import profiled_dictionary

    name = ctx.params.get("profile") or _DEFAULT_PROFILE
    with suppress(BenchError, OSError):
        profile = load_profile(name)
        return profiled_dictionary(profile, profile_path(name), profile.drive.node_id)
    return None


def _can_interfaces() -> list[str]:
    """Return the CAN interfaces of Linux, by ARPHRD_CAN."""
    found = []
    for place in sorted(Path("/sys/class/net").glob("*/type")):
        with suppress(OSError):
            if place.read_text(encoding="ascii").strip() == "280":
                found.append(place.parent.name)
    return found


def _files(incomplete: str, ending: str) -> list[str]:
    """Return the files with an ending, and folders, that begin as the incomplete path does."""
    folder = os.path.dirname(incomplete)
    found = []
    with suppress(OSError):
        for each in sorted(os.scandir(folder or "."), key=lambda entry: entry.name):
            path = os.path.join(folder, each.name)
            if each.is_dir() and not each.name.startswith("."):
                found.append(f"{path}/")
            elif ending and each.name.endswith(ending):
                found.append(path)
    return found
