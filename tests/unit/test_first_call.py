"""The first call of a compiled function: one process at a time, and no collection of garbage."""

from __future__ import annotations

import gc
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchtool.emulator.first_call import call_first


def not_compiled(folder: Path | None) -> Any:
    return SimpleNamespace(loaded=False, folder=folder, cached=False)


def test_one_compiles_while_the_others_wait_and_nothing_is_collected(tmp_path: Path) -> None:
    """A lock of the file system is held by an open file, so threads stand for processes."""
    inside: list[str] = []
    compiling, go_on = threading.Event(), threading.Event()

    def first() -> None:
        assert not gc.isenabled()
        compiling.set()
        assert go_on.wait(60.0)
        inside.append("first")

    one = threading.Thread(target=call_first, args=(not_compiled(tmp_path / "new"), first))
    other = threading.Thread(
        target=call_first, args=(not_compiled(tmp_path / "new"), lambda: inside.append("second"))
    )
    one.start()
    assert compiling.wait(60.0)
    other.start()
    other.join(0.05)
    assert inside == []
    go_on.set()
    one.join()
    other.join()
    assert inside == ["first", "second"]
    assert gc.isenabled()


def test_what_is_on_disk_is_loaded_by_all_at_once(tmp_path: Path) -> None:
    on_disk = SimpleNamespace(loaded=False, folder=tmp_path, cached=True)
    both = threading.Barrier(2)
    loading = [threading.Thread(target=call_first, args=(on_disk, lambda: both.wait(60.0))) for _ in range(2)]
    for each in loading:
        each.start()
    for each in loading:
        each.join()
    assert not both.broken


@pytest.mark.parametrize(("is_cached", "told"), [(False, ["compiling", "call"]), (True, ["call"])])
def test_that_it_compiles_is_told_before(tmp_path: Path, is_cached: bool, told: list[str]) -> None:
    entry = SimpleNamespace(loaded=False, folder=tmp_path, cached=is_cached)
    seen: list[str] = []
    call_first(entry, lambda: seen.append("call"), on_compiling=lambda: seen.append("compiling"))  # type: ignore[arg-type]
    assert seen == told


def test_what_is_compiled_is_not_called() -> None:
    called: list[int] = []
    call_first(SimpleNamespace(loaded=True), lambda: called.append(1))  # type: ignore[arg-type]
    call_first(abs, lambda: called.append(1))
    assert called == []


@pytest.mark.parametrize("folder", [None, Path("/proc/no/such/folder")])
def test_without_a_place_for_the_lock_it_compiles_all_the_same(folder: Path | None) -> None:
    called: list[int] = []
    call_first(not_compiled(folder), lambda: called.append(1))
    assert called == [1]


def test_an_error_of_the_compiler_comes_out_and_garbage_is_collected_again(tmp_path: Path) -> None:
    def fails() -> None:
        raise ValueError("no such type")

    with pytest.raises(ValueError, match="no such type"):
        call_first(not_compiled(tmp_path), fails)
    assert gc.isenabled()
    call_first(not_compiled(tmp_path), lambda: None)  # the lock is free
