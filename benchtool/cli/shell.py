"""`benchtool shell`: the Python API in IPython, on an open bench."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import typer

import benchtool
from benchtool.api import Bench, open_bench
from benchtool.block import Block
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import EnvironmentFailure, ValueRefused

if TYPE_CHECKING:
    from IPython.terminal.interactiveshell import TerminalInteractiveShell

_ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name))
_CAPTURE_S = 0.1
_BANNER = """\
bench, drive, benchtool and plot are here; TAB completes names, ? tells about them.
    drive["u_s"] = 81.65                       drive.parameters.overview("u_*")
    drive.enable("velocity")                   drive.omega_m_command = "150 rpm"
    drive.watch("torque", "i_q")               plot("torque", "i_q", duration_s=0.2)
    drive.disable()                            exit, or Ctrl-D: the drive is disabled"""


def shell(
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    seed: options.Seed = 0,
    virtual_time: Annotated[
        bool,
        typer.Option("--virtual-time", help="Let an emulated bench's time pass as fast as it is computed."),
    ] = False,
) -> int:
    """Open a bench in IPython, with completion over the drive's dictionary.

    The drive is disabled on every way out. The time of an emulated bench passes while a command waits only.
    """
    interactive = _interactive_shell()
    output = Output(as_json=False)
    with (
        open_bench(profile, link, seed=seed, real_time=not virtual_time, progress=output.note) as bench,
        _signals(interactive) as ended_by,
    ):
        interactive.push({"bench": bench, "drive": bench.drive, "benchtool": benchtool})
        interactive.push({"plot": _plotting(bench, output)})
        output.line(f"{bench!r}", "bold")
        output.line(_BANNER)
        interactive.mainloop()
    return 128 + ended_by[0] if ended_by else 0


def _interactive_shell() -> TerminalInteractiveShell:
    """Return the shell of IPython, not yet running.

    Raises:
        EnvironmentFailure: IPython is not installed.
    """
    try:
        from IPython.terminal.interactiveshell import TerminalInteractiveShell
        from traitlets.config import Config
    except ImportError:
        raise EnvironmentFailure(
            "IPython is not installed, and the shell takes it: pip install 'benchtool[shell]'"
        ) from None
    config = Config()
    config.TerminalInteractiveShell.confirm_exit = False
    config.TerminalInteractiveShell.banner1 = ""
    # Completion asks the objects themselves, which know the dictionary of the drive.
    config.Completer.use_jedi = False
    config.Completer.evaluation = "unsafe"
    made: TerminalInteractiveShell = TerminalInteractiveShell.instance(config=config)
    return made


class _Ended(BaseException):
    """A signal ends the shell; a SystemExit would be printed by IPython, with advice on how to leave."""


@contextmanager
def _signals(interactive: TerminalInteractiveShell) -> Iterator[list[int]]:
    """Ctrl-C interrupts a command; SIGTERM and SIGHUP leave the shell, and are told by number."""
    came: list[int] = []

    def leave(number: int, _frame: FrameType | None) -> None:
        came.append(number)
        interactive.ask_exit()  # IPython goes on after a command that raised an exception
        raise _Ended

    interactive.set_custom_exc((_Ended,), lambda *_, **__: None)  # else it is printed
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, *_ENDING)}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in _ENDING:
        signal.signal(number, leave)
    try:
        yield came
    except _Ended:
        pass  # at the prompt; in a command, IPython has caught it
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _plotting(bench: Bench, output: Output) -> Any:
    """Return the command `plot` of the shell."""

    def plot(*what: Block | str, duration_s: float = _CAPTURE_S) -> None:
        """Draw signals, captured now for `duration_s`, or those of a block that comes first, into a PNG.

        plot("torque", "i_q")           plot(block)           plot(block, "torque")
        """
        blocks = [each for each in what if isinstance(each, Block)]
        names = [each for each in what if isinstance(each, str)]
        if len(blocks) > 1 or not what:
            raise ValueRefused("plot takes names of signals, or one block and names: plot(block, 'torque')")
        block = blocks[0] if blocks else bench.drive.capture(duration_s, names)
        taken = (Path(f"plot-{number}.png") for number in range(1, 10_000))
        path = next(each for each in taken if not each.exists())
        output.line(f"{block.plot(*names).save(path)}")

    return plot
