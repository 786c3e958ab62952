"""`--live` of the verbs that measure: destinations opened beforehand, and a view of each case."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from rich.text import Text

from benchtool.analysis import Measurement
from benchtool.bench.session import Session
from benchtool.cli.output import Output
from benchtool.drive import RemoteDrive
from benchtool.errors import UsageError
from benchtool.recording import Manifest
from benchtool.recording.files import require_free
from benchtool.telemetry import Certificate, Sink

if TYPE_CHECKING:
    from benchtool.live import Destination, FileDestination, LiveView, Viewer


class Places:
    """Where a command shows what it measures: viewers that run, and a file that a recording begins."""

    def __init__(self, viewers: Sequence[Viewer], files: Sequence[FileDestination]) -> None:
        self._viewers = viewers
        self._files = files

    @property
    def any(self) -> bool:
        return bool(self._viewers or self._files)

    def of(self, name: str = "", *, endless: bool = False) -> list[Destination]:
        """Destinations of one recording; those of several go into files of their own names.

        An `endless` one is of nobody knows how long, and takes no more memory the longer it lasts. Where a
        file of that name is there already, as of a run that is resumed, the next number is taken.
        """
        from benchtool.live import FileDestination

        files = [each.path for each in self._files]
        if name:
            files = [_free(path.with_stem(f"{path.stem}-{name}")) for path in files]
        return [*self._viewers, *(FileDestination(path, endless=endless) for path in files)]

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
        RecordingError: a file is there already.
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
    paths = {Path(each).resolve(): Path(each) for each in where if each.endswith(".rrd")}
    files = [FileDestination(path) for path in paths.values()]  # one for each, however it is spelt
    for file in files:
        require_free(file.path)
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


def _free(path: Path) -> Path:
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in itertools.count(2))
    return next(each for each in (path, *itertools.islice(numbered, 1000)) if not each.exists())


def live_sink(view: LiveView) -> Sink:
    """A view as a sink of a stream, which drops what it does not take in time."""
    sink = Sink("live", view.take, lossless=False)
    view.count_drops(lambda: sink.rows_dropped)
    return sink


def show_certificate(view: LiveView, certificate: Certificate) -> None:
    """How good a recording is, where nothing else is measured."""
    from benchtool.live import certificate_document, results_document

    rows = measured(certificate.measurements)
    told = "complete" if certificate.complete else "not complete"
    view.results(
        results_document(view.title, certificate.measurements, remarks=[f"the recording is **{told}**"])
    )
    view.quality(certificate_document(rows))


def measured(measurements: Iterable[Measurement]) -> list[tuple[str, float, str]]:
    """Names, values and units, as the document of the data's quality takes them."""
    return [(each.name, each.value, each.unit) for each in measurements]


def tell_drops(view: LiveView, output: Output) -> None:
    """A line for each destination that missed something."""
    for name, rows in view.rows_dropped.items():
        if rows:
            output.note(f"{name}: {rows} rows were not shown; the recording of the run has them")


def count_link(view: LiveView, drive: RemoteDrive) -> None:
    """Have a view show the counters of the drive's link."""
    view.count(lambda: {f"link_{name}": count for name, count in asdict(drive.link.counters).items()})


@contextmanager
def stream_view(
    where: Places, session: Session, name: str, manifest: Manifest, output: Output
) -> Iterator[LiveView | None]:
    """The view of a stream alone, with parameters and wall time as a manifest has them; None if there is
    nowhere."""
    if not where.any:
        yield None
        return
    from benchtool.live import LiveView, results_document, setup_of

    setup = setup_of(manifest, name, session.profile.motor.psi_r_Wb)
    with LiveView(setup, where.of(endless=True), output.note) as view:
        count_link(view, session.drive)
        try:
            yield view
        except BaseException as failure:
            reason = f"{type(failure).__name__}: {failure}".rstrip(": ")
            view.results(results_document(setup.title, (), remarks=[f"ended by {reason}"]))
            raise
    tell_drops(view, output)
