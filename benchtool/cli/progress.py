"""Progress of a run on standard error: a bar with the time left on a terminal, lines elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Self

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from benchtool.cli.ending import printable
from benchtool.cli.output import Output


class RunProgress:
    """Watches a run for a person."""

    def __init__(self, output: Output) -> None:
        self._output = output
        self._bar: Progress | None = None
        if output.progress.is_terminal:
            columns = (
                BarColumn(20),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
                TextColumn("{task.description}", markup=False),
            )
            self._bar = Progress(*columns, console=output.progress, transient=True)
            self._task = self._bar.add_task("connecting", total=None)
        self._case = ""

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Take the bar away for the length of a `with` block, in which a question is asked."""
        if self._bar is not None:
            self._bar.stop()
        try:
            yield
        finally:
            if self._bar is not None:
                self._bar.start()

    def begin(self, case: str, number: int, count: int) -> None:
        """Case `number` of `count` begins."""
        self._case = f"{case}: " if count > 1 else ""
        if self._bar is not None:
            self._bar.update(self._task, completed=number - 1, total=count)

    def note(self, text: str) -> None:
        """A step begins."""
        if self._bar is not None:
            self._bar.update(self._task, description=printable(f"{self._case}{text}"))
        else:
            self._output.note(f"{self._case}{text}")
