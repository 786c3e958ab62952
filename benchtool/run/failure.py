"""Closing a bundle whose recording was cut short, with the reason."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from benchtool.errors import BenchError
from benchtool.link import LinkCounters
from benchtool.plan import Verdict
from benchtool.recording import BundleWriter
from benchtool.telemetry import TelemetryStream, certify_recording


def fail_bundle(
    bundle: BundleWriter,
    failure: BaseException,
    stream: TelemetryStream | None,
    counters: LinkCounters,
    *,
    verdict: Verdict | None = None,
    details: Mapping[str, Any] | None = None,
    close: Sequence[Callable[[], None]] = (),
) -> str:
    """Close a bundle that `failure` has cut short, and return the reason as the bundle states it.

    Errors while writing become notes of `failure`, which stays the reported exception.

    Args:
        stream: the slow stream so far; None if there was none.
        counters: of the link.
        verdict: of a run; None where nothing is judged.
        details: what the manifest is to say besides.
        close: files to be closed before.
    """
    certificate, facts = certify_recording(stream, {}, counters)
    reason = f"{type(failure).__name__}: {failure}".rstrip(": ")

    def fail() -> None:
        bundle.fail(
            reason,
            verdict=verdict,
            quality=asdict(counters),
            details=facts | dict(details or {}),
            certificate=certificate.to_json(),
        )

    for end in (*close, fail):  # the files first, then what says how they are
        try:
            end()
        except BenchError as also:
            failure.add_note(str(also))
    return reason
