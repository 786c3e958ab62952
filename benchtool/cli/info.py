"""`benchtool info`."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from benchtool.bench import equipment_of, open_session
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.drive import Capabilities, RemoteDrive, cost
from benchtool.errors import DictionaryMismatch, SdoAbort, UsageError, ValueRefused
from benchtool.protocol.dictionary import Dictionary, Role

_HEX = ("vendor_id", "product_code", "revision_number", "revision", "dictionary_hash")
_SHOWN = 3


def info(
    eds: Annotated[
        Path | None,
        typer.Option("--eds", metavar="FILE", help="What the drive of this EDS can do; none is asked."),
    ] = None,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Who answers and what it can do: identity, state, capabilities, bench. Nothing is written."""
    output = Output(as_json=as_json)
    if eds is None:
        return _info_of_link(profile, link, output)
    if link != "emulated":
        raise UsageError(f"--eds asks no drive, and --link {link} names one: leave one of them out")
    return _info_of_file(eds, output)


def _info_of_link(profile: str, link: str, output: Output) -> int:
    with open_session(profile, link, note=output.note, instruments=False) as session:
        drive = session.drive
        identity = drive.identify()
        dictionary = drive.dictionary
        identity.require(dictionary, dictionary.source)
        capabilities = drive.capabilities
        facts: dict[str, Any] = {
            "link": link,
            "node_id": drive.link.node_id,
            **asdict(identity),
            "objects": len(dictionary),
            "state": _state(drive),
            "equipment": equipment_of(profile, link).lines(),
        }
    _tell(f"drive of profile {profile}", facts, dictionary, capabilities, output)
    return 0


def _info_of_file(eds: Path, output: Output) -> int:

    dictionary = Dictionary.from_eds(eds, node_id=1)
    facts: dict[str, Any] = {
        "eds": str(eds),
        **asdict(dictionary.identity),
        "dictionary_hash": dictionary.hash,
        "objects": len(dictionary),
    }
    _tell(f"drive of {eds.name}", facts, dictionary, Capabilities.of(dictionary), output)
    return 0


def _state(drive: RemoteDrive) -> str | None:
    """Return the state of a drive that tells one as CiA 402 has it."""

    try:
        return drive.state().value if Role.STATUSWORD in drive.dictionary else None
    except (
        SdoAbort,
        DictionaryMismatch,
        ValueRefused,
    ):  # by its EDS it is not a number, or of another length
        return None


def _tell(
    title: str, facts: dict[str, Any], dictionary: Dictionary, capabilities: Capabilities, output: Output
) -> None:

    rows = [(key, _shown(key, value)) for key, value in facts.items() if key != "equipment"]
    rows += [(f"bench: {name}", text) for name, text in facts.get("equipment", {}).items()]
    output.table(title, ("what", "value"), rows)
    found = [
        (
            str(capability),
            "yes" if finding.available else "no",
            _listed(finding.by or finding.missing),
            "" if finding.available else cost(capability),
        )
        for capability, finding in capabilities.findings.items()
    ]
    output.table("what it can do", ("capability", "", "by, or what is missing", "what that costs"), found)
    for warning in dictionary.warnings:
        output.note(f"{dictionary.source}: {warning}")
    output.document({**facts, "warnings": list(dictionary.warnings), "capabilities": capabilities.to_json()})


def _listed(objects: tuple[str, ...]) -> str:
    more = len(objects) - _SHOWN
    return ", ".join(objects[:_SHOWN]) + (f" and {more} more" if more > 0 else "")


def _shown(key: str, value: object) -> str:
    if isinstance(value, int) and key in _HEX:
        return f"0x{value:08X}"
    return "–" if value in (None, "") else str(value)
