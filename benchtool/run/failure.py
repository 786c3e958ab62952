"""How a bundle says that its recording was cut short: the reason, and what is known until then."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from benchtool.errors import BenchError
from benchtool.link import LinkCounters
from benchtool.plan.limits import Verdict
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

    What cannot be written becomes a note of `failure`, which stays the one that is reported.

    Args:
        stream: the slow stream as far as it came; None where there was none.
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
