"""Progress on standard error: on a terminal a bar with the time left of a run, and of a recording a line that
renews itself; lines elsewhere."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

from benchtool.analysis import raw
from benchtool.cli.exit_codes import printable
from benchtool.cli.output import Output

if TYPE_CHECKING:
    from benchtool.run import Status

_FIRST_S, _SHARE, _ROUNDING_S = 1.0, 0.1, 1e-9
_MOST_VALUES = 4


class RunProgress:
    """Shows the progress of a run on standard error."""

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
        """Hide the bar for the length of a `with` block, for a question."""
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


class RecordingLine:
    """How far a recording is: one line on a terminal, less and less often a new one elsewhere.

    Args:
        as_json: show nothing.
    """

    def __init__(self, output: Output, *, as_json: bool) -> None:
        self._output = output
        self._quiet = as_json
        self._next_s = _FIRST_S
        self._live: Live | None = None
        if output.progress.is_terminal and not as_json:
            self._live = Live(console=output.progress, auto_refresh=False, transient=True)

    def __enter__(self) -> Self:
        if self._live is not None:
            self._live.start()
        elif not self._quiet:
            self._output.note("recording; Ctrl-C ends it")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def show(self, status: Status) -> None:
        """Renew the line."""
        if self._live is not None:
            with suppress(OSError):
                text = Text(
                    f"{_told(status)}; Ctrl-C ends it {_values(status.last)}",
                    no_wrap=True,
                    overflow="ellipsis",
                )
                self._live.update(text, refresh=True)
        elif not self._quiet and status.past_s >= self._next_s - _ROUNDING_S:
            while self._next_s <= status.past_s + _ROUNDING_S:
                self._next_s += max(1.0, math.floor(_SHARE * self._next_s))
            self._output.note(_told(status))


def _told(status: Status) -> str:
    of = "" if status.duration_s is None else f" of {status.duration_s:g}"
    rate_Hz = status.rows / status.past_s if status.past_s > 0.0 else 0.0
    told = f"{status.past_s:.0f}{of} s, {status.rows} rows, {raw(rate_Hz, 4)} rows/s"
    return f"{told}, {status.missing_rows} missing"


def _values(last: Mapping[str, float]) -> str:
    """Return the first few values of the last row."""
    shown = list(last.items())[:_MOST_VALUES]
    return "".join(f"  {name} {raw(value, 4)}" for name, value in shown)
