"""The live view: where it is shown, a stream in it, and recorded runs."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from benchtool.api.bundles import Bundle, folder_of
from benchtool.api.plans import PlanResult
from benchtool.errors import RecordingError, UsageError
from benchtool.live import FileDestination, LiveView, Viewer, setup_of, show_bundle
from benchtool.recording import Manifest, require_free

if TYPE_CHECKING:
    from benchtool.bench import Session
    from benchtool.live import Destination


def show_live(run: str | Path | Bundle | PlanResult, where: str | Path = "viewer") -> None:
    """Show a recorded run in the panels of the live view; `Drive.stream(live=...)` shows a drive.

    Args:
        run: a bundle, what `run_plan` gave, or the folder of a run of several cases.
        where: "viewer" for Rerun's viewer, "web" for a browser on this machine until Ctrl-C, or a file that
            ends in .rrd, for `rerun FILE.rrd`.

    Raises:
        RecordingError: the run cannot be read, or the file is there already.
        EnvironmentFailure: the viewer cannot be opened.
        UsageError: `where` is something else.
    """
    from benchtool.results import recorded_runs

    bundles = [case.bundle for each in recorded_runs(folder_of(run)) for case in each.cases]
    for bundle in bundles:
        bundle.require_intact()
    if len(bundles) > 1 and str(where).endswith(".rrd"):
        raise UsageError(f"{len(bundles)} cases go into a file each: show one of them, or name 'viewer'")
    with opened(where) as destination:
        for bundle in bundles:
            setup = setup_of(bundle.manifest, bundle.directory.name, _flux_Wb(Bundle(bundle)))
            show_bundle(bundle, setup, [destination], _silent).close()
        if isinstance(destination, Viewer) and destination.web:
            with suppress(KeyboardInterrupt):
                destination.process.wait()


@contextmanager
def stream_view(session: Session, where: str | Path) -> Iterator[LiveView]:
    """Open a view of a drive's stream, for the length of a `with` block."""
    from benchtool.drive.parameters import snapshot

    drive = session.drive
    manifest = Manifest(
        what="live",
        when=datetime.now().astimezone().isoformat(timespec="seconds"),
        parameters=snapshot(drive),
        details={"wall": drive.clock_anchor(time.time())},
    )
    setup = setup_of(manifest, session.profile_name, session.profile.motor.psi_r_Wb)
    with opened(where) as destination, LiveView(setup, [destination], _silent) as view:
        yield view


@contextmanager
def opened(where: str | Path) -> Iterator[Destination]:
    """Open the place where a view is shown.

    Raises:
        UsageError: there is no such place.
        RecordingError: the file is there already.
        EnvironmentFailure: the viewer cannot be opened.
    """
    target = str(where)
    if target in ("viewer", "web"):
        with Viewer(web=target == "web") as viewer:
            if viewer.web:
                sys.stderr.write(f"benchtool: live at {viewer.page}\n")
            yield viewer
        return
    if not target.endswith(".rrd"):
        raise UsageError(f"where is {target!r}: 'viewer', 'web' or a file that ends in .rrd is expected")
    require_free(Path(target))
    file = FileDestination(Path(target))
    file.check()
    yield file


def _flux_Wb(bundle: Bundle) -> float:
    """Return the flux linkage of the magnets, for a recording whose manifest has no motor."""
    try:
        return bundle.profile.motor.psi_r_Wb
    except RecordingError:
        return 0.0


def _silent(_text: str) -> None:
    """Does nothing."""
