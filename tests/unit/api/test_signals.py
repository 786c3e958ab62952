"""Signals while a drive is enabled."""

from __future__ import annotations

import signal
import threading
from contextlib import ExitStack

import pytest

from benchtool.api.signals import ending_in_order, shielded, uninterrupted


def test_sigterm_leaves_the_blocks_and_the_handler_is_put_back() -> None:
    left = []
    with pytest.raises(SystemExit) as ended, ending_in_order():
        try:
            signal.raise_signal(signal.SIGTERM)
        finally:
            left.append("disabled")
    assert (ended.value.code, left) == (128 + signal.SIGTERM, ["disabled"])
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_a_handler_of_the_program_stays() -> None:
    came: list[int] = []

    def own(number: int, _frame: object) -> None:
        came.append(number)

    before = signal.signal(signal.SIGTERM, own)
    try:
        with ending_in_order():
            signal.raise_signal(signal.SIGTERM)
        assert came == [signal.SIGTERM]
        assert signal.getsignal(signal.SIGTERM) is own
    finally:
        signal.signal(signal.SIGTERM, before)


def test_ctrl_c_waits_for_the_end_of_a_shielded_block() -> None:
    done = []
    with pytest.raises(KeyboardInterrupt), shielded():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        done.append("disabled")
    assert done == ["disabled"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_failure_in_a_shielded_block_goes_before_the_signal() -> None:
    with pytest.raises(ZeroDivisionError), shielded():
        signal.raise_signal(signal.SIGINT)
        raise ZeroDivisionError


def test_a_signal_that_comes_while_an_end_in_order_is_shielded_still_ends_the_process() -> None:
    with pytest.raises(SystemExit), ExitStack() as outer:
        inner = ExitStack()
        inner.enter_context(ending_in_order())
        outer.enter_context(shielded())
        signal.raise_signal(signal.SIGTERM)
        inner.close()
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_shields_within_one_another_put_the_handler_back() -> None:
    with ExitStack() as inner:
        inner.enter_context(ending_in_order())
        with shielded(), shielded():
            inner.close()
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_what_was_to_end_is_ended_by_a_second_try_after_an_interrupt() -> None:
    tries: list[str] = []

    def end() -> None:
        tries.append("end")
        if len(tries) == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        uninterrupted(end)
    assert tries == ["end", "end"]


def test_another_thread_sets_no_handlers() -> None:
    seen: list[object] = []

    def use() -> None:
        with ending_in_order(), shielded():
            seen.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert seen == [signal.SIG_DFL]
