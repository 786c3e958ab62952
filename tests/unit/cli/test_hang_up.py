"""A closed terminal interrupts a command like Ctrl-C, unless it was started to outlive it (nohup)."""

from __future__ import annotations

import signal

import pytest

from benchtool.cli import _interrupt, _interrupting

SIGHUP = getattr(signal, "SIGHUP", None)


@pytest.mark.skipif(SIGHUP is None, reason="a system without SIGHUP")
@pytest.mark.parametrize(("handling", "interrupts"), [(signal.SIG_DFL, True), (signal.SIG_IGN, False)])
def test_a_closed_terminal_interrupts_unless_it_is_ignored(
    handling: signal.Handlers, interrupts: bool
) -> None:
    assert SIGHUP is not None
    numbers = (signal.SIGINT, signal.SIGTERM, SIGHUP)
    before = {number: signal.signal(number, handling) for number in numbers}
    try:
        assert (SIGHUP in _interrupting()) is interrupts
        with pytest.raises(KeyboardInterrupt):
            _interrupt(SIGHUP, None)
        assert {signal.getsignal(number) for number in numbers} == {signal.SIG_IGN}
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
