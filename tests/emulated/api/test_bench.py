"""A bench by the Python API: what the first page shows, and what a hurried engineer does to it."""

from __future__ import annotations

import gc
import itertools
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import benchtool
from benchtool.api.connection import Connection
from benchtool.errors import (
    DriveFault,
    NoSuchAttribute,
    ProfileError,
    StateError,
    UsageError,
    ValueRefused,
)
from benchtool.protocol.canopen.nmt import NmtCommand
from benchtool.protocol.cia402 import State

CHANNELS = ["i_a", "i_b", "i_c", "torque", "psi_s", "theta_m"]


def _session(bench: benchtool.Bench) -> Any:
    """The session behind a bench."""
    with bench._connection.use() as session:
        return session


def _on_release(node: Any, states: list[State]) -> None:
    """Have the state noted in which a drive is left to others."""
    release = node.release

    def note() -> None:
        states.append(node.state())
        release()

    node.release = note


@pytest.mark.parametrize("link", ["emulated", "emulated?wire=serial"], ids=["can", "serial"])
def test_the_ripple_of_an_operating_point(link: str) -> None:
    with benchtool.open_bench("zhu2011", link=link) as bench:
        bench.drive["u_s"] = 81.65
        bench.load.torque(0.65)
        with bench.drive.enabled("velocity") as drive:
            drive.omega_m_command = 15.71
            bench.wait(1.5)
            block = drive.capture(0.52, CHANNELS)
    result = benchtool.analyze(block, bench.profile)
    ripple = result["torque_ripple_pp"]
    assert ripple.value == pytest.approx(0.05, abs=0.005)
    assert str(ripple).endswith("Nm")
    assert " ± 0.00" in str(ripple)
    assert result["torque_mean"].value == pytest.approx(0.65, abs=0.01)
    assert result["transducer_torque_mean"].value == pytest.approx(0.65, abs=0.01)
    assert (len(block.data), block.names) == (5200, tuple(CHANNELS))
    assert block.certificate is not None
    assert block.certificate.complete
    assert block.gaps == ()


def test_parameters_in_si_with_units_all_or_none(bench: benchtool.Bench) -> None:
    drive = bench.drive
    drive["R_s"] = "470 mohm"
    assert drive["R_s"] == 0.47
    drive["u_s"] = float(np.float32(81.65))
    assert drive.parameters["u_s"] == 81.65
    with pytest.raises(ValueRefused, match="law = 'tcp'"):
        drive.update({"u_s": 70.0, "law": "tcp"})
    assert drive["u_s"] == 81.65
    with drive.parameters.temporary({"u_s": 60.0, "law": "foc"}):
        assert (drive["u_s"], drive["law"]) == (60.0, "foc")
    assert (drive["u_s"], drive["law"]) == (81.65, "tpc")
    about = drive.parameters.about("R_s")
    assert (about.value, about.unit, about.minimum, about.maximum) == (0.47, "ohm", 0.0, 100.0)
    assert [each.name for each in drive.parameters.overview("L_*")] == ["L_d", "L_q"]
    assert "R_s" in drive.parameters
    assert drive.parameters.get("R_x", 7.0) == 7.0
    assert {"u_s", "torque"} <= set(drive._ipython_key_completions_())
    assert "470" not in drive.parameters._repr_html_()
    assert "0.47" in drive.parameters._repr_html_()


_BLOCK = benchtool.Block.from_arrays(1e4, {}, i_a=np.ones(9))

REFUSED: dict[str, tuple[Callable[[benchtool.Bench], object], type[Exception], str]] = {
    "a misspelt parameter": (lambda b: b.drive.update({"u_ss": 1.0}), ValueRefused, "did you mean 'u_s'"),
    "a signal that is set": (lambda b: b.drive.update({"torque": 1.0}), ValueRefused, "is a signal"),
    "not a number": (lambda b: b.drive.update({"R_s": float("nan")}), ValueRefused, "finite"),
    "nothing": (lambda b: b.drive.update({"R_s": None}), ValueRefused, "NoneType"),  # type: ignore[dict-item]
    "another unit": (lambda b: b.drive.update({"R_s": "1 kg"}), ValueRefused, "ohm"),
    "beyond its limits": (lambda b: b.drive.update({"R_s": 1e6}), ValueRefused, "0 to 100 ohm"),
    "a setpoint as an item": (
        lambda b: b.drive.__setitem__("omega_m_command", 1.0),
        ValueRefused,
        "with drive.enabled",
    ),
    "a setpoint of no enabled drive": (
        lambda b: setattr(b.drive, "torque_command", 1.0),
        NoSuchAttribute,
        "with bench.drive.enabled",
    ),
    "an attribute": (lambda b: setattr(b.drive, "u_s", 1.0), NoSuchAttribute, r"drive\['u_s'\]"),
    "a signal as an attribute": (lambda b: b.drive.torque, NoSuchAttribute, r"drive\['torque'\]"),
    "a misspelt signal": (lambda b: b.drive.values["torqe"], ValueRefused, "did you mean 'torque'"),
    "a mode": (lambda b: b.drive.enabled("velocty"), ValueRefused, "did you mean 'velocity'"),
    "a mode's other name": (lambda b: b.drive.enabled("speed"), ValueRefused, "did you mean 'velocity'"),
    "a misspelt channel": (lambda b: b.drive.capture(0.1, ["torqe"]), ValueRefused, "mean 'torque'"),
    "no channel": (lambda b: b.drive.capture(0.1, []), ValueRefused, "0 channels"),
    "a name for a list": (lambda b: b.drive.capture(0.1, "torque"), ValueRefused, r"\['torque'\]"),
    "a parameter captured": (lambda b: b.drive.capture(0.1, ["R_s"]), ValueRefused, "is a parameter"),
    "a channel twice": (lambda b: b.drive.capture(0.1, ["i_a", "i_a"]), ValueRefused, "twice"),
    "17 channels": (lambda b: b.drive.capture(0.1, list(b.drive.values)[:17]), ValueRefused, "17"),
    "an empty capture": (lambda b: b.drive.capture(0.0, ["i_a"]), ValueRefused, "above 0"),
    "a capture of nan": (lambda b: b.drive.capture(float("nan"), ["i_a"]), ValueRefused, "above 0"),
    "less than a row": (lambda b: b.drive.capture(1e-5, ["i_a"]), ValueRefused, "hold no row"),
    "more than the memory": (lambda b: b.drive.capture(1e4, ["i_a"]), ValueRefused, "1 to 200000"),
    "half a stride": (lambda b: b.drive.capture(0.1, ["i_a"], stride=0.5), ValueRefused, "stride"),  # type: ignore[arg-type]
    "a wait back": (lambda b: b.wait(-1.0), ValueRefused, "from 0 on"),
    "a wait of nan": (lambda b: b.wait(float("nan")), ValueRefused, "from 0 on"),
    "a load of nan": (lambda b: b.load.torque(float("nan")), ValueRefused, "finite"),
    "an endless watch": (lambda b: b.drive.watch("torque"), UsageError, "real_time=True"),
    "a stream of a misspelt channel": (lambda b: b.drive.record(0.1, ["i_x"]), ValueRefused, "i_x"),
    "an open bench that is pickled": (pickle.dumps, UsageError, "cannot be pickled"),
    "a plan whose key is wrong": (
        lambda b: benchtool.Plan(title="x", profile="zhu2011", operating_pont={}),
        benchtool.BenchError,
        "did you mean 'operating_point'",
    ),
    "an unknown analysis": (
        lambda b: benchtool.analyze(
            benchtool.Block.from_arrays(1e4, {}, i_a=np.ones(9)), b.profile, analyses={"x": True}
        ),
        benchtool.BenchError,
        "'x'",
    ),
    "an unknown profile": (lambda b: benchtool.open_bench("zhu2012"), ProfileError, "zhu2011"),
}


def test_a_slip_is_an_error_of_the_tree_that_says_what_to_do(bench: benchtool.Bench) -> None:
    for what, (slip, kind, message) in REFUSED.items():
        with pytest.raises(kind, match=message) as refused:
            slip(bench)
        assert isinstance(refused.value, benchtool.BenchError), what
    assert bench.drive.state is State.SWITCH_ON_DISABLED


def test_setpoints_of_an_enabled_drive(bench: benchtool.Bench) -> None:
    with bench.drive.enabled("velocity") as drive:
        drive.omega_m_command = "150 rpm"
        assert drive.omega_m_command == pytest.approx(15.70796, rel=1e-6)
        for value in (157.2, -1e9, float("nan"), float("inf")):
            with pytest.raises(ValueRefused, match="was not sent"):
                drive.omega_m_command = value
        with pytest.raises(ValueRefused, match=r"with drive.enabled\('torque'\)"):
            drive.torque_command = 1.0
        with pytest.raises(NoSuchAttribute, match="did you mean 'omega_m_command'"):
            drive.omega_m_comand = 1.0
        assert drive.omega_m_command == pytest.approx(15.70796, rel=1e-6)
        bench.wait(1.0)
        assert drive.values["omega_m"] == pytest.approx(15.708, abs=0.3)
        assert bench.drive.omega_m_command == drive.omega_m_command  # the shell's `drive`
        for again in (bench.drive.enabled("torque"), drive):
            with pytest.raises(UsageError, match="enabled in velocity mode already"), again:
                pass
        with pytest.raises(UsageError, match="a plan enables it itself"):
            bench.run("zhu2011/ripple")
    assert bench.drive.state is State.SWITCH_ON_DISABLED
    for use in (lambda: drive.values, lambda: drive.capture(0.1, ["i_a"]), drive.__enter__):
        with pytest.raises(UsageError, match="has ended"):
            use()
    with pytest.raises(UsageError, match="has not begun"):
        bench.drive.enabled("velocity").omega_m_command = 1.0


@pytest.mark.parametrize("reason", [ZeroDivisionError, KeyboardInterrupt, SystemExit, GeneratorExit])
def test_the_drive_is_disabled_whatever_ends_the_block(
    bench: benchtool.Bench, reason: type[BaseException]
) -> None:
    with pytest.raises(reason), bench.drive.enabled("velocity") as drive:
        drive.omega_m_command = 10.0
        bench.wait(0.2)
        raise reason
    assert bench.drive.state is State.SWITCH_ON_DISABLED


def _interrupt_at(call: int) -> None:
    """Have Ctrl-C come at the beginning of a call of a Python function that is made from now on."""
    left = itertools.count(call, -1)

    def profile(_frame: object, event: str, _arg: object) -> None:
        if event == "call" and next(left) == 0:
            sys.setprofile(None)
            signal.raise_signal(signal.SIGINT)

    sys.setprofile(profile)


@pytest.fixture
def unprofiled() -> Iterator[None]:
    """No interrupt that is left over reaches another test."""
    before = sys.getprofile()
    yield
    sys.setprofile(before)


@pytest.mark.usefixtures("unprofiled")
@pytest.mark.parametrize("call", [2, 3, 5, 8, 12, 20, 30, 45, 70, 300])
def test_ctrl_c_while_the_block_is_left_does_not_keep_the_drive_enabled(
    bench: benchtool.Bench, call: int
) -> None:
    with pytest.raises(KeyboardInterrupt), bench.drive.enabled("velocity"):
        _interrupt_at(call)
    assert bench.drive.state is State.SWITCH_ON_DISABLED
    assert bench._connection.enabled is None


@pytest.mark.usefixtures("unprofiled")
@pytest.mark.parametrize("call", [4, 5, 12, 30, 60, 90, 200])
def test_ctrl_c_while_a_bench_is_closed_does_not_keep_the_drive_enabled(call: int) -> None:
    states: list[State] = []
    bench = benchtool.open_bench("zhu2011")
    _on_release(_session(bench).drive, states)
    bench.drive.enable("velocity")
    with pytest.raises(KeyboardInterrupt):
        _interrupt_at(call)
        bench.close()
    assert bench.closed
    assert states[-1] is State.SWITCH_ON_DISABLED


def test_ctrl_c_while_the_drive_is_being_enabled_leaves_it_disabled(
    bench: benchtool.Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    hold = bench._connection.hold

    def interrupted(*what: Any) -> None:
        hold(*what)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(bench._connection, "hold", interrupted)
    with pytest.raises(KeyboardInterrupt), bench.drive.enabled("velocity"):
        pytest.fail("the block was entered")
    assert bench.drive.state is State.SWITCH_ON_DISABLED
    monkeypatch.undo()
    with bench.drive.enabled("velocity") as again:
        assert again.state is State.OPERATION_ENABLED


def test_a_drive_that_does_not_confirm_is_told_of(
    bench: benchtool.Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = _session(bench).drive
    with pytest.raises(ZeroDivisionError) as ended, bench.drive.enabled("velocity"):
        monkeypatch.setattr(node, "_ask", lambda command: None)
        raise ZeroDivisionError
    assert any("did not confirm that it is disabled" in note for note in ended.value.__notes__)
    monkeypatch.undo()
    node.link.nmt(NmtCommand.START)  # a node that is stopped answers nothing


def test_a_drive_that_hears_no_host_any_more_stops_itself(bench: benchtool.Bench) -> None:
    with pytest.raises(DriveFault), bench.drive.enabled("velocity") as drive:
        drive.omega_m_command = 10.0
        bench.wait(0.5)
        _session(bench).drive.stop_heartbeat()  # what is left of an interpreter that was killed
        bench.wait(1.0)
    assert bench.drive.values  # it still answers
    assert bench.drive.state is State.FAULT
    bench.drive.reset_fault()
    with bench.drive.enabled("velocity") as again:
        assert again.state is State.OPERATION_ENABLED


def test_a_shell_enables_until_it_disables_or_closes() -> None:
    bench = benchtool.open_bench("zhu2011")
    node = _session(bench).drive
    drive = bench.drive
    drive.enable("torque")
    drive.torque_command = 0.1
    assert "torque_command" in dir(drive)
    drive.disable()
    assert drive.state is State.SWITCH_ON_DISABLED
    assert "torque_command" not in dir(drive)
    drive.enable("velocity")
    states: list[State] = []
    _on_release(node, states)
    bench.close()
    bench.close()
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    assert states == [State.SWITCH_ON_DISABLED]
    assert bench.closed
    for use in (lambda: bench.drive, lambda: drive["u_s"], lambda: bench.wait(1.0), bench.__enter__):
        with pytest.raises(UsageError, match="is closed"):
            use()
    assert repr(drive) == "<Drive: closed>"
    assert bench.profile.motor.pole_pairs == 4


def test_a_bench_that_is_forgotten_is_closed_with_its_drive_disabled() -> None:
    states: list[State] = []
    with pytest.warns(ResourceWarning, match="was not closed"):  # noqa: PT031
        bench = benchtool.open_bench("zhu2011")
        node = _session(bench).drive
        bench.drive.enable("velocity")
        _on_release(node, states)
        del bench
        gc.collect()
    assert states[-1] is State.SWITCH_ON_DISABLED


def test_a_bench_that_another_thread_forgets_is_closed_too() -> None:
    states: list[State] = []
    before = signal.getsignal(signal.SIGTERM)
    with pytest.warns(ResourceWarning, match="was not closed"):  # noqa: PT031
        bench = [benchtool.open_bench("zhu2011")]
        bench[0].drive.enable("velocity")
        _on_release(_session(bench[0]).drive, states)

        def release() -> None:
            bench.clear()
            gc.collect()

        thread = threading.Thread(target=release)
        thread.start()
        thread.join()
        for closing in threading.enumerate():
            if closing.name == "benchtool-closing":
                closing.join()
    signal.signal(signal.SIGTERM, before)  # only the main thread can put it back
    assert states[-1] is State.SWITCH_ON_DISABLED


def test_the_identity_is_that_of_the_drive(bench: benchtool.Bench) -> None:
    assert bench.drive.identity == _session(bench).drive.identify()


def test_threads_take_turns(bench: benchtool.Bench) -> None:
    read: list[float] = []

    def poll() -> None:
        read.extend(bench.drive.values["omega_m"] for _ in range(20))

    with bench.drive.enabled("velocity") as drive:
        drive.omega_m_command = 10.0
        threads = [threading.Thread(target=poll) for _ in range(3)]
        for thread in threads:
            thread.start()
        bench.wait(0.5)
        for thread in threads:
            thread.join()
    assert len(read) == 60


def test_a_process_that_was_forked_off_leaves_the_bench_alone(bench: benchtool.Bench) -> None:
    with bench.drive.enabled("velocity") as drive:
        process = os.fork()
        if process == 0:
            code = 1
            try:
                bench.close()
                drive.__exit__(None, None, None)
                drive.values  # noqa: B018
            except UsageError as refused:
                code = 0 if "forked off" in str(refused) else 2
            os._exit(code)
        assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 0
        bench.wait(1.0)
        assert drive.state is State.OPERATION_ENABLED


def test_two_hosts_do_not_command_one_drive() -> None:
    from benchtool.emulator.bench import EmulatedBench
    from benchtool.link.serial.link import SerialLink
    from benchtool.profile import load_profile

    emulated = EmulatedBench(load_profile("zhu2011"))

    def host() -> benchtool.Bench:
        from contextlib import ExitStack

        from benchtool.bench.session import open_session

        stack = ExitStack()
        link = SerialLink(emulated.host_port(), 1, emulated.clock)
        stack.callback(link.close)
        session = stack.enter_context(open_session("zhu2011", link))
        session.drive.check()
        return benchtool.Bench(Connection(stack, session, "a line"))

    with host() as first, host() as second:
        with first.drive.enabled("velocity") as drive:
            drive.omega_m_command = 5.0
            first.wait(0.2)
            assert second.drive.values["torque"] is not None  # it may look
            with pytest.raises(StateError, match="another host supervises"), second.drive.enabled("velocity"):
                pass
            assert drive.state is State.OPERATION_ENABLED
        with second.drive.enabled("velocity"):
            pass
    emulated.close()


def test_a_stream_while_the_bench_waits(bench: benchtool.Bench, capsys: pytest.CaptureFixture[str]) -> None:
    with bench.drive.stream(["torque", "omega_m"], rate_Hz=250) as stream:
        bench.wait(0.5)
        assert set(stream.latest) == {"torque", "omega_m"}
        assert "omega_m" in stream._repr_html_()
        with pytest.raises(UsageError, match="streams already"), bench.drive.stream(["i_q"]):
            pass
    block = stream.block
    assert block.sample_rate_Hz == pytest.approx(250.0)
    assert len(block.data) == pytest.approx(125, abs=2)
    assert block.certificate is not None
    assert block.certificate.complete
    bench.drive.watch("torque", duration_s=0.4)
    assert capsys.readouterr().out.count("torque 0 Nm") == 3


def test_a_bench_that_is_closed_ends_what_is_under_way(bench: benchtool.Bench) -> None:
    handler = signal.getsignal(signal.SIGTERM)
    drive, stream = bench.drive.enabled("velocity"), bench.drive.stream(["torque"])
    with drive, stream:
        assert signal.getsignal(signal.SIGTERM) is not handler
        bench.wait(0.3)
        bench.close()
        assert signal.getsignal(signal.SIGTERM) is handler
    with pytest.raises(UsageError, match="is closed"):
        bench.wait(0.1)


def test_a_stream_is_shown_while_it_comes(bench: benchtool.Bench, tmp_path: Path) -> None:
    with bench.drive.stream(["torque", "omega_m"], rate_Hz=250, live=tmp_path / "live.rrd"):
        bench.wait(0.5)
    assert (tmp_path / "live.rrd").stat().st_size > 1000
    with pytest.raises(UsageError, match="'viewer', 'web'"), bench.drive.stream(live="window"):
        pass


def test_what_a_notebook_shows(bench: benchtool.Bench) -> None:
    values = bench.drive.values
    assert "zhu" in repr(bench).lower()
    for shown in (bench, bench.drive, bench.drive.parameters, values):
        assert "<table>" in shown._repr_html_()
    assert values.read("torque", "omega_m") == {"torque": 0.0, "omega_m": 0.0}
