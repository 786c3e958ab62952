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
from benchtool.bench import Session
from benchtool.bench.wires import did_you_mean
from benchtool.cli.output import Output
from benchtool.drive import RemoteDrive
from benchtool.errors import UsageError
from benchtool.recording import Manifest, require_free, write_whole
from benchtool.telemetry import Certificate, Sink

if TYPE_CHECKING:
    from benchtool.live import Destination, FileDestination, LiveView, Viewer


class LiveDestinations:
    """Destinations of `--live`: running viewers, and files."""

    def __init__(self, viewers: Sequence[Viewer], files: Sequence[FileDestination]) -> None:
        self._viewers = viewers
        self._files = files

    @property
    def any(self) -> bool:
        return bool(self._viewers or self._files)

    def of(self, name: str = "", *, endless: bool = False) -> list[Destination]:
        """Return the destinations of one recording; those of several go into files of their own names.

        An `endless` recording has no known length, and its memory does not grow with time. If a file of that
        name exists, as after a resumed run, the next free number is used.
        """
        from benchtool.live import FileDestination

        files = [each.path for each in self._files]
        if name:
            files = [_free(path.with_stem(f"{path.stem}-{name}")) for path in files]
        return [*self._viewers, *(FileDestination(path, endless=endless) for path in files)]

    def keep_open(self, output: Output, duration_s: float | None = None, *, stay: bool = False) -> None:
        """Leave the web viewer's page up: so long, or until Ctrl-C for a person or, with `stay`, in any case;
        else a script goes on at once."""
        web = [viewer for viewer in self._viewers if viewer.web]
        if web and (stay or duration_s is not None or sys.stdin.isatty()):
            sys.stdout.flush()  # what there is to say has been said
            until = "stays until Ctrl-C" if duration_s is None else f"is up for {duration_s:g} s"
            output.note(f"the page {until}: {web[0].page}")
            with suppress(KeyboardInterrupt, subprocess.TimeoutExpired):
                web[0].process.wait(duration_s)


def draw(recordings: Path, png: Path, output: Output) -> list[Path]:
    """Return a picture of every recording in a folder; those of several have the recordings' numbers.

    Raises:
        EnvironmentFailure: they cannot be drawn here.
        RecordingError: a picture cannot be written.
    """
    from benchtool.live.sinks import take_picture

    drawn = []
    for recording in sorted(recordings.glob("*.rrd")):
        _, number, name = recording.stem.partition("-")
        place = png.with_stem(f"{png.stem}{number}{name}")
        write_whole(place, take_picture(recording))
        output.line(f"picture: {place}")
        drawn.append(place)
    return drawn


@contextmanager
def open_destinations(where: Sequence[str], output: Output, bind: str = "") -> Iterator[LiveDestinations]:
    """Open the destinations that `--live` names, and close them on exit; without any nothing is imported.

    Raises:
        UsageError: it names something else.
        RecordingError: a file is there already.
        EnvironmentFailure: one cannot be opened.
    """
    if not where:
        yield LiveDestinations((), ())
        return
    os.environ.setdefault("RUST_LOG", "off")  # a note reports a lost viewer in place of the SDK's log
    from benchtool.live import LOOPBACK, FileDestination, Viewer

    unknown = [each for each in where if each not in ("viewer", "web") and not each.endswith(".rrd")]
    if unknown:
        meant = did_you_mean(unknown[0], ["viewer", "web"])
        raise UsageError(
            f"--live {unknown[0]}: 'viewer', 'web' or a file that ends in .rrd is expected{meant}"
        )
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
                    output.progress.print(address, soft_wrap=True)  # in one line, to be copied
        yield LiveDestinations(viewers, files)


def _free(path: Path) -> Path:
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in itertools.count(2))
    return next(each for each in (path, *itertools.islice(numbered, 1000)) if not each.exists())


def live_view_sink(view: LiveView) -> Sink:
    """Return a view as a sink of a stream, which drops blocks that it does not take in time."""
    sink = Sink("live", view.add_block, lossless=False)
    view.count_drops(lambda: sink.rows_dropped)
    return sink


def show_certificate(view: LiveView, certificate: Certificate) -> None:
    """Show the data-quality certificate, where nothing else is measured."""
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


def warn_dropped(view: LiveView, output: Output) -> None:
    """Print a line for each destination that missed rows."""
    for name, rows in view.rows_dropped.items():
        if rows:
            output.note(f"{name}: {rows} rows were not shown; the recording of the run has them")


def count_link(view: LiveView, drive: RemoteDrive) -> None:
    """Show the counters of the drive's link in a view."""
    view.count(lambda: {f"link_{name}": count for name, count in asdict(drive.link.counters).items()})


@contextmanager
def stream_view(
    where: LiveDestinations, session: Session, name: str, manifest: Manifest, output: Output
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
    warn_dropped(view, output)
