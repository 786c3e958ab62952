"""A run in the live view, one recording for each of its cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from benchtool.bench import Session
from benchtool.block import Block
from benchtool.cli import live_views
from benchtool.cli.output import Output
from benchtool.plan import Case
from benchtool.recording import Event, Manifest
from benchtool.results import Assessment
from benchtool.run import Progress
from benchtool.telemetry import Sink

if TYPE_CHECKING:
    from benchtool.live import LiveView


class RunViews:
    """Shows a run, one recording for each case; receives progress and passes it on.

    Args:
        where: destinations.
        progress: receives the same notifications.
        output: where lines go.
        plan: one of several of a command, for the names of files; empty if it is the only one.
    """

    def __init__(
        self, where: live_views.LiveDestinations, progress: Progress, output: Output, plan: str = ""
    ) -> None:
        self._where = where
        self._plan = plan
        self._progress = progress
        self._output = output
        self._view: LiveView | None = None
        self._several = False

    # ---- Progress --------------------------------------------------------------------------------------

    def begin(self, case: str, number: int, count: int) -> None:
        """Case `number` of `count` begins."""
        self._several = count > 1
        self._progress.begin(case, number, count)

    def note(self, text: str) -> None:
        """A step within the case begins."""
        self._progress.note(text)

    # ---- RunObserver ---------------------------------------------------------------------------------------

    def opened(self, session: Session, case: Case, manifest: Manifest) -> Sequence[Sink]:
        """Return the sink of the case's slow stream."""
        if not self._where.any:
            return ()
        from benchtool.live import LiveView, setup_of

        setup = setup_of(manifest, case.name, session.profile.motor.psi_r_Wb)
        self._view = LiveView(setup, self._where.of(self._name(case)), self._output.note)
        live_views.count_link(self._view, session.drive)
        return (live_views.live_view_sink(self._view),)

    def happened(self, event: Event) -> None:
        """Show it at its place in time."""
        if self._view is not None:
            self._view.event(event)

    def captured(self, capture: Block, transducer: Block | None, trigger_row: int | None) -> None:
        """Show what was captured at its place in drive time."""
        if self._view is not None:
            from benchtool.live import CAPTURE, TRANSDUCER

            self._view.captured(capture, CAPTURE, trigger_row)
            if transducer is not None:
                self._view.captured(transducer, TRANSDUCER)

    def closed(self, result: Assessment | None, failure: str) -> None:
        """Show the result of the case, and end its recording."""
        view, self._view = self._view, None
        if view is None:
            return
        from benchtool.live import certificate_document, results_document

        if result is not None:
            limited = [each for each in result.quality if each.name in result.limits]
            rows = (*result.measurements, *limited)
            bounds = {name: (limit.min, limit.max) for name, limit in result.limits.items()}
            verdicts = {name: str(verdict) for name, verdict in result.verdicts.items()}
            remarks = [f"verdict: **{result.verdict}**", *(str(each) for each in result.missed)]
            view.results(results_document(view.title, rows, bounds, verdicts, remarks))
            view.quality(certificate_document(live_views.measured(result.quality)))
        else:
            view.results(results_document(view.title, (), remarks=[f"the run has failed: {failure}"]))
        view.close()
        live_views.warn_dropped(view, self._output)

    def _name(self, case: Case) -> str:
        """Return the part of a file's name that identifies this case."""
        parts = (self._plan, case.folder if self._several else "")
        return "-".join(part for part in parts if part)
