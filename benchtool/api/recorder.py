"""The stream of a drive into a bundle on disk."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from benchtool.api.bundles import Bundle, open_bundle
from benchtool.api.connection import Connection
from benchtool.api.drive import require_duration
from benchtool.recording import BundleWriter, EventFile, require_empty
from benchtool.run import bundle_folder, recording


def record(
    connection: Connection,
    duration_s: float,
    channels: tuple[str, ...],
    out: str | Path | None,
    *,
    rate_Hz: float,
    note: str,
    seed: int,
) -> Bundle:
    """See `Bench.record`."""
    require_duration(duration_s)
    when = datetime.now().astimezone()
    place = None if out is None else Path(out)
    if place is not None:
        require_empty(place)
    with connection.use() as session, bundle_folder(place, when, "record") as folder:
        names, manifest = recording.prepared(
            session, channels, rate_Hz, when=when, link=connection.link, seed=seed, note=note
        )
        with BundleWriter(folder, manifest) as writer:
            asked = recording.Recording(names, rate_Hz, duration_s)
            recording.record(session, writer, asked, _silent, takers=[EventFile(folder).append])
        return open_bundle(folder)


def _silent(_text: str) -> None:
    """Does nothing."""
