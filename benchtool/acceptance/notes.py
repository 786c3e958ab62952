"""What is noted of a test while it runs."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from benchtool.results import Attachment, Judged


@dataclass
class Notes:
    """Notes of one test.

    Attributes:
        name: of the test.
        folder: where its files go; it is made with the first of them.
        session: folder of the session, to which paths are relative.
        pictures: draw figures that are attached.
        judged: values with their limits.
        attachments: files.
        lines: sentences on what happened, such as that the drive was in fault when the test began.
        events: states and faults of the drive.
        facts: what was seen of drive and bench, of the session's record.
        must_measure: the test has asked for `measure`.
        injected: faults that the test has injected.
        failed: a stage of the test has failed.
    """

    name: str
    folder: Path
    session: Path
    pictures: bool = True
    judged: list[Judged] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    events: list[str] = field(default_factory=list)
    facts: dict[str, Any] = field(default_factory=dict)
    must_measure: bool = False
    injected: list[str] = field(default_factory=list)
    failed: bool = False

    @property
    def complaints(self) -> tuple[str, ...]:
        """Limits that are not met, a line each."""
        return tuple(self._complaints())

    def _complaints(self) -> Iterator[str]:
        if self.must_measure and not self.judged:
            yield "nothing was measured, though the test asks for `measure`: hold a value against a limit"
        yield from (each.complaint for each in self.judged if each.complaint)

    def path(self, name: str) -> Path:
        """Return a path for a file of this test that is not there yet; its folder is made."""
        self.folder.mkdir(parents=True, exist_ok=True)
        plain = re.sub(r"[^\w.,=+-]", "_", name) or "file"
        path, number = self.folder / plain, 1
        while path.exists():
            number += 1
            path = self.folder / f"{Path(plain).stem}-{number}{Path(plain).suffix}"
        return path

    def keep(self, name: str, file: str, content: bytes) -> Path:
        """Write a file of this test, which belongs to it under a name, and return its path.

        Raises:
            RecordingError: it cannot be written.
        """
        from benchtool.recording import write_whole, writing

        with writing(self.folder):
            path = self.path(file)
        write_whole(path, content)
        self.attach(name, path)
        return path

    def attach(self, name: str, path: Path) -> None:
        """Have a file or a folder of files belong to this test."""
        from benchtool.results import Attachment

        relative = path.resolve().relative_to(self.session.resolve()).as_posix()
        self.attachments.append(Attachment(name=name, path=relative))


class Attach:
    """Keeps files with a test, which its report names: text, pictures, recorded blocks.

    attach.text("answer.txt", text)
    attach.picture("step", lambda: figure)
    """

    def __init__(self, notes: Notes) -> None:
        self._notes = notes

    @property
    def folder(self) -> Path:
        """The folder of this test, which is there from now on."""
        self._notes.folder.mkdir(parents=True, exist_ok=True)
        return self._notes.folder

    def text(self, name: str, text: str) -> Path:
        """Keep a text as a file."""
        return self._notes.keep(name, name, text.encode("utf-8"))

    def file(self, path: Path, name: str = "") -> None:
        """Have a file or folder within `folder` belong to the test.

        Raises:
            ValueError: it lies elsewhere.
        """
        self._notes.attach(name or path.name, path)

    def picture(self, name: str, draw: Callable[[], Figure]) -> None:
        """Keep a picture, as PNG; it is drawn only where the session has a report."""
        if not self._notes.pictures:
            return
        from benchtool.report import png

        self._notes.keep(name, f"{name}.png", png(draw()))
