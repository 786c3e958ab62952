"""`--live` of the verbs that measure: destinations opened beforehand, and a view of each case."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from benchtool.cli.output import Output
from benchtool.errors import UsageError

if TYPE_CHECKING:
    from benchtool.bench import Session
    from benchtool.block import Block
    from benchtool.experiment.assessment import Assessment
    from benchtool.experiment.cases import Case
    from benchtool.experiment.conduct import Progress
    from benchtool.experiment.plan import Plan
    from benchtool.live import Destination, FileDestination, LiveView, Viewer
    from benchtool.telemetry import Sink

Live = Annotated[
    list[str] | None,
    typer.Option(
        metavar="viewer|web|FILE.rrd",
        help="Show it live in Rerun's viewer, in a browser, or write a file; several times for several.",
    ),
]


class Places:
    """Where a command shows what it measures: viewers that run, and a file that a recording begins."""

    def __init__(self, viewers: Sequence[Viewer], files: Sequence[FileDestination]) -> None:
        self._viewers = viewers
        self._files = files

    @property
    def any(self) -> bool:
        return bool(self._viewers or self._files)

    def of(self, name: str = "") -> list[Destination]:
        """Destinations of one recording; those of several go into files of their own names."""
        from benchtool.live import FileDestination

        files = [each.path for each in self._files]
        if name:
            files = [path.with_stem(f"{path.stem}-{name}") for path in files]
        return [*self._viewers, *map(FileDestination, files)]

    def linger(self, output: Output, duration_s: float | None = None) -> None:
        """Leave the web viewer's page up: so long, or for a person until Ctrl-C; a script goes on at once."""
        web = [viewer for viewer in self._viewers if viewer.web]
        if web and (duration_s is not None or sys.stdin.isatty()):
            output.note("the page stays until Ctrl-C" if duration_s is None else f"up for {duration_s:g} s")
            with suppress(KeyboardInterrupt, subprocess.TimeoutExpired):
                web[0].process.wait(duration_s)


@contextmanager
def places(where: Sequence[str], output: Output, bind: str = "") -> Iterator[Places]:
    """The destinations that `--live` names, opened, and closed on the way out; nothing is imported for none.

    Raises:
        UsageError: it names something else.
        EnvironmentFailure: one cannot be opened.
    """
    if not where:
        yield Places((), ())
        return
    os.environ.setdefault("RUST_LOG", "off")  # what the SDK would log of a lost viewer is said by a note
    from benchtool.live import LOOPBACK, FileDestination, Viewer

    unknown = [each for each in where if each not in ("viewer", "web") and not each.endswith(".rrd")]
    if unknown:
        raise UsageError(f"--live {unknown[0]}: 'viewer', 'web' or a file that ends in .rrd is expected")
    files = [FileDestination(Path(each)) for each in dict.fromkeys(where) if each.endswith(".rrd")]
    for file in files:
        file.check()
    viewers: list[Viewer] = []
    with ExitStack() as stack:
        for each in ("viewer", "web"):
            if each in where:
                viewers.append(stack.enter_context(Viewer(web=each == "web", bind=bind or LOOPBACK)))
                if each == "web":
                    address = Text(f"live at {viewers[-1].page}")
                    output.progress.print(address, soft_wrap=True)  # in one piece, to be copied
        yield Places(viewers, files)


def live_sink(view: LiveView) -> Sink:
    """A view as a sink of a stream, which drops what it does not take in time."""
    from benchtool.telemetry import Sink

    sink = Sink("live", view.take, lossless=False)
    view.count_drops(lambda: sink.rows_dropped)
    return sink


def tell_drops(view: LiveView, output: Output) -> None:
    """A line for each destination that missed something."""
    for name, rows in view.rows_dropped.items():
        if rows:
            output.note(f"{name}: {rows} rows were not shown; the recording of the run has them")


class RunViews:
    """Shows a run: one recording for each case, its steps as events. Watches as well as it is watched."""

    def __init__(self, where: Places, progress: Progress, output: Output) -> None:
        self._where = where
        self._progress = progress
        self._output = output
        self._view: LiveView | None = None
        self._several = False
        self._title = ""

    # ---- Progress --------------------------------------------------------------------------------------

    def begin(self, case: str, number: int, count: int) -> None:
        """Case `number` of `count` begins."""
        self._several = count > 1
        self._progress.begin(case, number, count)

    def note(self, text: str) -> None:
        """A step within the case begins."""
        self._progress.note(text)
        if self._view is not None:
            self._view.event(text)

    # ---- Watcher ---------------------------------------------------------------------------------------

    def opened(self, session: Session, plan: Plan, case: Case) -> Sequence[Sink]:
        """The sink of the case's slow stream."""
        if not self._where.any:
            return ()
        from benchtool.live import LiveView, Setup

        limits = {**plan.limits, **plan.case_limits.get(case.name, {})}
        self._title = f"{plan.title}: {case.name}"
        setup = Setup(
            title=self._title,
            psi_Wb=session.profile.motor.psi_r_Wb,
            limits={name: (limit.min, limit.max) for name, limit in limits.items()},
            parameters={**session.profile.drive.parameters, **plan.setup, **case.setup},
        )
        self._view = LiveView(setup, self._where.of(case.folder if self._several else ""), self._output.note)
        return (live_sink(self._view),)

    def captured(self, capture: Block, transducer: Block | None, trigger_row: int | None) -> None:
        """Show what was captured at its place in drive time."""
        if self._view is not None:
            from benchtool.live import CAPTURE, TRANSDUCER

            self._view.captured(capture, CAPTURE, trigger_row)
            if transducer is not None:
                self._view.captured(transducer, TRANSDUCER)

    def closed(self, result: Assessment | None, failure: str) -> None:
        """Show what the case came to, and end its recording."""
        view, self._view = self._view, None
        if view is None:
            return
        from benchtool.live import results_document

        if result is not None:
            limited = [each for each in result.quality if each.name in result.limits]
            rows = [(each.name, each.value, each.unit) for each in (*result.measurements, *limited)]
            bounds = {name: (limit.min, limit.max) for name, limit in result.limits.items()}
            verdicts = {name: str(verdict) for name, verdict in result.verdicts.items()}
            view.results(
                results_document(self._title, rows, bounds, verdicts, [f"verdict: **{result.verdict}**"])
            )
        else:
            view.event(failure, "ERROR")
        view.close()
        tell_drops(view, self._output)


@contextmanager
def stream_view(where: Places, session: Session, title: str, output: Output) -> Iterator[LiveView | None]:
    """The view of a stream alone; what ends it too early becomes its last event. None if there is nowhere."""
    if not where.any:
        yield None
        return
    from benchtool.live import LiveView, Setup

    setup = Setup(
        title=title,
        psi_Wb=session.profile.motor.psi_r_Wb,
        parameters=session.profile.drive.parameters,
    )
    with LiveView(setup, where.of(), output.note) as view:
        try:
            yield view
        except BaseException as failure:
            view.event(f"{type(failure).__name__}: {failure}".rstrip(": "), "ERROR")
            raise
    tell_drops(view, output)
