"""A recorded run as a recording of the live view: the same panels as while it was measured."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from benchtool.analysis import measurements_from_json
from benchtool.block import Block
from benchtool.link import ClockAnchor
from benchtool.live import names
from benchtool.live.messages import parts
from benchtool.live.panels.band import Limits
from benchtool.live.panels.documents import certificate_document, results_document
from benchtool.live.sinks.sink import Destination
from benchtool.live.view import LiveView, Setup
from benchtool.recording import Bundle, Event, Level, Manifest

_SLOW = "telemetry"
_CAPTURE = "capture"
_TRANSDUCER = "transducer"
_PART_S = 0.2  # as a stream comes
_PATIENCE_S = 60.0  # nothing waits for it


def setup_of(manifest: Manifest, name: str, psi_r_Wb: float) -> Setup:
    """Return the setup of a run's view from its manifest.

    Args:
        manifest: as it was begun, or finished.
        name: of the run, where the manifest has no case.
        psi_r_Wb: the motor's flux, where the manifest has none.
    """
    details = manifest.details
    mark = details.get("wall")
    return Setup(
        title=f"{manifest.what}: {details.get('case', name)}",
        psi_Wb=float(details.get("motor", {}).get("psi_r_Wb", psi_r_Wb)),
        limits=limits_of(details.get("plan", {}), str(details.get("case", "")), _group(details)),
        parameters=manifest.parameters,
        mark=None if mark is None else ClockAnchor(**mark),
    )


def limits_of(plan: Mapping[str, Any], case: str, group: str = "") -> Limits:
    """(min, max) by measurement, of a plan as its manifest has it, for one case; `group` is the name that it
    shares with its other repetitions."""
    of_cases = plan.get("case_limits", {})
    limits = {**plan.get("limits", {}), **of_cases.get(group, {}), **of_cases.get(case, {})}
    return {name: (limit.get("min"), limit.get("max")) for name, limit in limits.items()}


def _group(details: Mapping[str, Any]) -> str:
    """Return the group of the case from its coordinates; older bundles have none."""
    return str(details.get("coordinates", {}).get("group", ""))


def show_bundle(
    bundle: Bundle, setup: Setup, destinations: Sequence[Destination], note: Callable[[str], None]
) -> LiveView:
    """Send a whole bundle, every sample of it; the view is still open.

    Raises:
        RecordingError: a stream of the bundle cannot be read.
        EnvironmentFailure: a destination cannot be opened.
    """
    blocks = {stream: bundle.block(stream) for stream in bundle.streams}
    setup = replace(setup, followed=False)
    view = LiveView(setup, destinations, note, patience_s=_PATIENCE_S)
    details = bundle.manifest.details
    events = deque(bundle.events)
    if _SLOW in blocks:
        slow = blocks[_SLOW]
        for part in parts(slow, max(1, round(_PART_S * slow.sample_rate_Hz))):
            while events and (events[0].tick is None or events[0].tick <= part.ticks()[-1]):
                view.event(events.popleft())
            view.add_block(part)
    for event in events:
        view.event(event)
    if _CAPTURE in blocks:
        plan = details.get("plan", {})
        view.captured(blocks[_CAPTURE], trigger_row=_trigger_row(plan, blocks[_CAPTURE]))
    if _TRANSDUCER in blocks:
        view.captured(blocks[_TRANSDUCER], names.TRANSDUCER)
    if not bundle.complete and "failure" not in details:
        view.event(Event(text="the run was cut short", level=Level.WARN))
    certificate = bundle.certificate or {}
    found = measurements_from_json({**certificate.get("measurements", {}), **bundle.measurements})
    own = bundle.measurements
    rows = [each for each in found if each.name in own or each.name in setup.limits or not own]
    verdict = f"verdict: **{bundle.manifest.verdict}**" if bundle.manifest.verdict else ""
    remarks = [text for text in (bundle.manifest.note, verdict, str(details.get("failure", ""))) if text]
    if certified := certificate.get("measurements", {}):
        view.quality(certificate_document(_rows(certified)))
    view.results(results_document(setup.title, rows, setup.limits, details.get("verdicts", {}), remarks))
    return view


def _trigger_row(plan: Mapping[str, Any], capture: Block) -> int | None:
    """Return the row at which the drive began to play a plan's stimulus; None of a capture without one."""
    if not plan.get("stimulus"):
        return None
    row = round(float(plan.get("record", {}).get("pretrigger_s", 0.0)) * capture.sample_rate_Hz)
    return row if row < len(capture.data) else None


def _rows(entries: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, float, str]]:
    return [(name, _number(entry), str(entry["unit"])) for name, entry in entries.items()]


def _number(entry: Mapping[str, Any]) -> float:
    value = entry.get("value")
    return float("nan") if value is None else float(value)
