"""The log of a bundle: read back exactly, also if the process ended within a line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from benchtool.errors import RecordingError
from benchtool.recording import Bundle, BundleWriter, Event, EventFile, Level, Manifest

_EVENTS = st.builds(
    Event,
    text=st.text(),
    level=st.sampled_from(Level),
    tick=st.none() | st.integers(0, 1 << 40),
    state=st.none() | st.text(),
)
_MANIFEST = Manifest(what="test", when="2026-01-01T12:00:00+00:00")


@given(events=st.lists(_EVENTS, max_size=10), cut=st.integers(0, 200))
def test_events_come_out_as_they_went_in(
    events: list[Event], cut: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("events") / "run"
    with BundleWriter(folder, _MANIFEST) as writer:
        for event in events:
            EventFile(folder).append(event)
        writer.close()
    assert list(Bundle.open(folder).events) == events
    path = folder / "data" / "events.jsonl"
    if events:
        whole = path.read_bytes()
        path.write_bytes(whole[: max(0, len(whole) - cut)])
        kept = list(Bundle.open(folder).events)
        assert kept == events[: len(kept)]


def test_a_bundle_without_events_has_none(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", _MANIFEST) as writer:
        writer.finish()
    assert Bundle.open(tmp_path / "run").events == ()


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    path = tmp_path / "data" / "events.jsonl"
    with pytest.raises(RecordingError, match=re.escape(f"cannot write {path}: ")):
        EventFile(tmp_path).append(Event(text="lost"))
