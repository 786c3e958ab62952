"""`benchtool info`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from benchtool.cli import options
from benchtool.cli.output import Output


def info(
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Who answers: identity, firmware, dictionary, state; and the bench. Nothing is enabled or written."""
    from benchtool.bench.session import equipment_of, open_session

    output = Output(as_json=as_json)
    with open_session(profile, link, note=output.note, instruments=False) as session:
        identity = session.drive.identify()
        dictionary = session.drive.dictionary
        identity.require(dictionary, dictionary.source)
        facts: dict[str, Any] = {
            "link": link,
            "node_id": session.drive.link.node_id,
            **asdict(identity),
            "objects": len(dictionary),
            "state": session.drive.state().value,
            "warnings": list(dictionary.warnings),
            "equipment": equipment_of(profile, link).lines(),
        }
    rows = [(key, _shown(key, value)) for key, value in facts.items() if key not in ("warnings", "equipment")]
    rows += [(f"bench: {name}", text) for name, text in facts["equipment"].items()]
    output.table(f"drive of profile {profile}", ("what", "value"), rows)
    for warning in dictionary.warnings:
        output.note(f"{dictionary.source}: {warning}")
    output.document(facts)
    return 0


def _shown(key: str, value: object) -> str:
    if isinstance(value, int) and key in ("vendor_id", "product_code", "revision_number", "dictionary_hash"):
        return f"0x{value:08X}"
    return "–" if value is None else str(value)
