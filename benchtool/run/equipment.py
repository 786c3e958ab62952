"""Readings and facts of the equipment for the manifest and the log of a case."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from benchtool.bench import Done, Session

_DROPPED = {
    "malformed": "could not be decoded",
    "out_of_range": "were beyond the range of their DBC file",
    "overflow": "found no room in the recording",
    "repeated": "came twice",
}


def readings(session: Session) -> dict[str, Any]:
    """Return voltage and current of the dc supply and temperatures, now, as far as the bench measures them.

    Also checks that the torque transducer sends.

    Raises:
        NoAnswer: an instrument is silent.
    """
    if session.transducer is not None:
        session.transducer.require_alive()
    told: dict[str, Any] = {}
    if session.supply is not None:
        told |= {"u_dc_V": session.supply.u_dc_V, "i_dc_A": session.supply.i_dc_A}
    if session.thermometer is not None:
        told |= asdict(session.thermometer.temperatures())
    return {name: value for name, value in told.items() if value is not None}


def facts(session: Session, before: dict[str, Any], by_hand: Done | None) -> dict[str, Any]:
    """Return the facts for the manifest: readings before enabling, facts of the transducer, actions of the
    operator."""
    told: dict[str, Any] = {"before": before} if before else {}
    if session.transducer is not None and (kept := session.transducer.facts()):
        told["transducer"] = kept
    if by_hand is not None:
        told["by_hand"] = {"what": by_hand.what, "confirmed": str(by_hand.confirmed)}
    return {"equipment": told} if told else {}


def remarks(session: Session) -> Iterator[str]:
    """Yield remarks on dropped frames of the transducer, and on the alignment of its samples."""
    kept = {} if session.transducer is None else session.transducer.facts()
    for name, text in _DROPPED.items():
        if count := kept.get("frames", {}).get(name, 0):
            yield f"torque transducer: {count} frames {text} and were dropped"
    if alignment := kept.get("alignment"):
        missing = alignment["missing_frames"]
        if missing:
            yield f"torque transducer: {missing} frames of the recording are missing"
