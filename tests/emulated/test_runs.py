"""Plans of several cases: sweeps, repetitions, interruption and resumption."""

from __future__ import annotations

import math
import pickle
import shlex
from concurrent.futures import Future
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchtool.acceptance import conduct_campaign
from benchtool.bench.session import Session, open_session
from benchtool.cli.run import RunOptions
from benchtool.cli.run_plans import _resumption
from benchtool.errors import AnalysisError, DriveFault, SdoAbort, UsageError
from benchtool.plan.cases import Case, cases
from benchtool.plan.model import Plan
from benchtool.protocol.cia402 import State
from benchtool.recording import Bundle
from benchtool.results.case_assessment import assess_bundle
from benchtool.run.parallel import run_in_processes
from benchtool.run.runner import RunInfo, run_plan

from .conftest import Wire, over_both_wires

INFO = RunInfo("2020-01-01T00:00:00+00:00", 0, ("run",))
CHANNELS = ("i_a", "i_b", "i_c", "torque", "torque_reference", "psi_s", "theta_m", "switching_count")


class RunObserver:
    """Keeps what it is told; raises `error` when case `at` begins."""

    def __init__(self, at: int = 0, error: type[BaseException] = KeyboardInterrupt) -> None:
        self.begun: list[str] = []
        self.notes: list[str] = []
        self._at = at
        self._error = error

    def begin(self, case: str, number: int, count: int) -> None:
        self.begun.append(case)
        if number == self._at:
            raise self._error

    def note(self, text: str) -> None:
        self.notes.append(text)


def _plan(**changes: object) -> Plan:
    document = {
        "title": "test",
        "profile": "zhu2011",
        "operating_point": {"omega_m_rad_s": 31.42, "load_torque_Nm": 0.3, "settle_s": 0.4},
        "record": {"duration_s": 0.12, "channels": CHANNELS},
    }
    return Plan.model_validate({**document, **changes})


SWEEP = _plan(sweep={"setup": {"u_s_V": [60.0, 81.65]}}, repetitions=2)


def _run(
    session: Session, plan: Plan, folder: Path, observer: RunObserver, *, resume: bool = False
) -> list[str]:
    result = run_plan(lambda *_: nullcontext(session), plan, folder, INFO, observer, resume=resume)
    return [each.case for each in result.assessments]


def test_a_grid_is_every_combination_and_a_list_is_not() -> None:
    swept = {"setup": {"u_s_V": [1.0, 2.0]}, "operating_point": {"load_torque_Nm": [0.0, 0.5]}}
    grid = cases(_plan(sweep={"order": "grid", **swept}))
    assert [case.name for case in grid] == [
        "u_s_V=1,load_torque_Nm=0",
        "u_s_V=1,load_torque_Nm=0.5",
        "u_s_V=2,load_torque_Nm=0",
        "u_s_V=2,load_torque_Nm=0.5",
    ]
    assert grid[3].setup == {"u_s_V": 2.0}
    assert grid[3].operating_point.load_torque_Nm == 0.5
    listed = cases(_plan(sweep={"order": "list", **swept}))
    assert [case.name for case in listed] == ["u_s_V=1,load_torque_Nm=0", "u_s_V=2,load_torque_Nm=0.5"]


def test_a_plan_without_a_sweep_is_one_case_called_after_its_law() -> None:
    assert [case.name for case in cases(_plan(setup={"law": "tpc"}))] == ["tpc"]
    assert [case.name for case in cases(_plan(case="warm", repetitions=2))] == ["warm.1", "warm.2"]


@over_both_wires
def test_a_sweep_leaves_a_bundle_for_every_case_and_the_drive_as_it_was(wire: Wire, tmp_path: Path) -> None:
    before = wire.session.drive.read("u_s")
    names = ["u_s_V=60.1", "u_s_V=60.2", "u_s_V=81.65.1", "u_s_V=81.65.2"]
    assert _run(wire.session, SWEEP, tmp_path / "run", RunObserver()) == names
    for name, u_s in zip(names, (60.0, 60.0, 81.65, 81.65), strict=True):
        assert Bundle.open(tmp_path / "run" / name).manifest.parameters["u_s_V"] == u_s
    assert wire.session.drive.read("u_s") == before
    assert wire.session.drive.state() is State.SWITCH_ON_DISABLED


def test_an_interrupted_sweep_is_resumed_where_it_stopped(wire: Wire, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    before = wire.session.drive.read("u_s")
    with pytest.raises(KeyboardInterrupt):
        _run(wire.session, SWEEP, folder, RunObserver(at=3))
    assert wire.session.drive.read("u_s") == before
    kept = {path.name: (path / "manifest.json").read_bytes() for path in folder.iterdir()}
    assert set(kept) == {"u_s_V=60.1", "u_s_V=60.2"}
    observer = RunObserver()
    assert len(_run(wire.session, SWEEP, folder, observer, resume=True)) == 4
    assert observer.notes.count("already there") == 2
    for name, manifest in kept.items():
        assert (folder / name / "manifest.json").read_bytes() == manifest


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"link": "can:socketcan:can0"}, "with link 'emulated', and this run has 'can:socketcan:can0'"),
        ({"link": "emulated?wire=serial"}, "with link 'emulated'"),
        ({"seed": 7}, "with seed 0, and this run has 7"),
        ({"profile_toml": "title = 'other'"}, "with profile title ="),
        ({"plan": {"limits": {"torque_mean": {"max": 1.0}}}}, r"with plan limits\.torque_mean\.max = 'none'"),
    ],
)
def test_a_mixture_is_refused_before_anything_is_opened(
    wire: Wire, tmp_path: Path, changes: dict[str, Any], said: str
) -> None:
    with pytest.raises(KeyboardInterrupt):
        _run(wire.session, SWEEP, tmp_path / "run", RunObserver(at=2))
    plan = _plan(sweep={"setup": {"u_s_V": [60.0, 81.65]}}, repetitions=2, **changes.pop("plan", {}))
    info = replace(INFO, **changes)

    def opener(*_: object) -> AbstractContextManager[Session]:
        raise AssertionError

    with pytest.raises(UsageError, match=said):
        run_plan(opener, plan, tmp_path / "run", info, RunObserver(), resume=True)
    with pytest.raises(UsageError, match=said):
        run_in_processes(plan, "zhu2011", tmp_path / "run", info, RunObserver(), jobs=2, resume=True)


def test_another_drive_is_refused_before_it_is_enabled(
    wire: Wire, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(KeyboardInterrupt):
        _run(wire.session, SWEEP, tmp_path / "run", RunObserver(at=2))
    drive = wire.session.drive
    connect = drive.connect
    monkeypatch.setattr(drive, "connect", lambda: replace(connect(), serial_number=99))
    enabled: list[object] = []
    monkeypatch.setattr(drive, "enable", enabled.append)
    with pytest.raises(UsageError, match=r"with drive serial_number = .*, and this run has 99"):
        _run(wire.session, SWEEP, tmp_path / "run", RunObserver(), resume=True)
    assert not enabled


def test_the_way_to_go_on_is_the_command_itself() -> None:
    chosen = RunOptions(
        "my motor.toml",
        "can:slcan:/dev/tty 1?node=3",
        None,
        5,
        True,
        True,
        False,
        Path("a b.md"),
        3,
        True,
        ("x.rrd",),
    )
    words = shlex.split(_resumption("my plan.toml", Path("runs/it's"), chosen))
    assert words == [
        *("benchtool", "run", "my plan.toml", "--resume", "runs/it's", "--profile", "my motor.toml"),
        *("--link", "can:slcan:/dev/tty 1?node=3", "--seed", "5", "--jobs", "3", "--page", "a b.md"),
        *("--live", "x.rrd", "--allow-different", "--real-time", "--json"),
    ]
    assert _resumption("a", Path("b"), RunOptions()) == "benchtool run a --resume b"


def test_a_case_that_fails_says_so_in_its_bundle_and_is_run_again(
    wire: Wire, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive, folder = wire.session.drive, tmp_path / "run"
    plan = _plan(setup={"i_trip_A": 0.2})
    with pytest.raises(DriveFault, match="0x2310"):
        _run(wire.session, plan, folder, RunObserver())
    assert drive.state() is State.FAULT
    assert drive.read("i_trip") == 12.0
    bundle = Bundle.open(folder)
    assert bundle.manifest.verdict == "fail"
    assert bundle.manifest.details["failure"].startswith("DriveFault: the drive reports 0x2310")

    drive.reset_fault()
    assert len(_run(wire.session, _plan(), folder, RunObserver(), resume=True)) == 1
    assert Bundle.open(tmp_path / "run.cut-1").manifest.details == bundle.manifest.details


class Loads:
    """A load machine that keeps what it is told; the shaft turns freely."""

    def __init__(self) -> None:
        self.torques_Nm: list[float] = []

    def apply(self, torque_Nm: float) -> None:
        self.torques_Nm.append(torque_Nm)

    def hold(self, omega_m_rad_s: float) -> None:
        self.torques_Nm.append(math.inf)


class Cut(RunObserver):
    """Interrupts a case as soon as it captures."""

    def note(self, text: str) -> None:
        super().note(text)
        if text.startswith("capturing"):
            raise KeyboardInterrupt


@pytest.mark.parametrize(
    "point",
    [
        {"omega_m_rad_s": 31.42, "load_torque_Nm": 0.3},
        {"mode": "torque", "torque_Nm": 0.3, "hold_speed_rad_s": 10.0},
    ],
    ids=["loaded", "held"],
)
@pytest.mark.parametrize("cut", [False, True], ids=["to the end", "Ctrl-C"])
def test_a_case_leaves_the_shaft_without_a_load(
    wire: Wire, tmp_path: Path, cut: bool, point: dict[str, object]
) -> None:
    plan, load = _plan(operating_point={"settle_s": 0.4, **point}), Loads()
    # Nothing turns this shaft: what was measured is no matter here.
    with pytest.raises(KeyboardInterrupt) if cut else suppress(AnalysisError):
        _run(replace(wire.session, load=load), plan, tmp_path / "run", Cut() if cut else RunObserver())
    assert max(load.torques_Nm) > 0.0
    assert load.torques_Nm[-1] == 0.0


def test_a_case_that_is_interrupted_says_so_in_its_bundle(wire: Wire, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        _run(wire.session, _plan(), tmp_path / "run", Cut())
    assert wire.session.drive.state() is State.SWITCH_ON_DISABLED
    manifest = Bundle.open(tmp_path / "run").manifest
    assert manifest.verdict == "fail"
    assert manifest.details["failure"] == "KeyboardInterrupt"


def test_a_setup_that_is_refused_changes_nothing_and_leaves_no_bundle(wire: Wire, tmp_path: Path) -> None:
    plan = _plan(setup={"u_s_V": 60.0, "control_period_s": 1e-3})
    with pytest.raises(SdoAbort):
        _run(wire.session, plan, tmp_path / "run", RunObserver())
    assert wire.session.drive.read("u_s") == 81.65
    assert not (tmp_path / "run").exists()


def test_variants_are_crossed_with_the_sweep() -> None:
    plan = _plan(
        emulator={"inverter.u_dc_V": 311.0},
        variants=[
            {"name": "nominal"},
            {"name": "dead time", "emulator": {"inverter.dead_time_s": 3e-6}, "setup": {"R_s_ohm": 0.2}},
        ],
        sweep={"setup": {"u_s_V": [60.0, 80.0]}},
    )
    found = {case.name: case for case in cases(plan)}
    assert list(found) == [
        "nominal,u_s_V=60",
        "nominal,u_s_V=80",
        "dead time,u_s_V=60",
        "dead time,u_s_V=80",
    ]
    last = found["dead time,u_s_V=80"]
    assert last.emulator == {"inverter.u_dc_V": 311.0, "inverter.dead_time_s": 3e-6}
    assert last.setup == {"R_s_ohm": 0.2, "u_s_V": 80.0}
    assert last.folder == "dead_time,u_s_V=80"


def test_limits_hold_for_the_quality_of_the_data_as_well(wire: Wire, tmp_path: Path) -> None:
    plan = _plan(limits={"capture_rows_missing": {"max": 0.0}, "telemetry_rows_expected": {"max": 1.0}})
    result = run_plan(lambda *_: nullcontext(wire.session), plan, tmp_path / "run", INFO, RunObserver())
    (assessment,) = result.assessments
    own = {name: assessment.verdicts[name] for name in plan.limits}
    assert own == {"capture_rows_missing": "pass", "telemetry_rows_expected": "fail"}
    assert assess_bundle(Bundle.open(tmp_path / "run")).verdicts == assessment.verdicts


def test_a_run_in_processes_records_the_same_bytes(tmp_path: Path) -> None:
    def opener(case: Case, seed: int) -> AbstractContextManager[Session]:
        return open_session("zhu2011", seed=seed, alter=case.emulator)

    plan = _plan(case="tpc", repetitions=2)
    run_plan(opener, plan, tmp_path / "one", INFO, RunObserver())
    observer = RunObserver()
    result = run_in_processes(plan, "zhu2011", tmp_path / "two", INFO, observer, jobs=2)
    names = [each.case for each in result.assessments]
    assert names == ["tpc.1", "tpc.2"]
    assert sorted(observer.begun) == names
    for name in names:
        one, two = (tmp_path / run / name / "data" / "capture.parquet" for run in ("one", "two"))
        assert one.read_bytes() == two.read_bytes()
    first, second = (each.measurements for each in result.assessments)
    assert first != second, "repetitions differ in their noise"


def test_cases_that_wait_are_not_begun_after_an_interruption(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The pool waits for what was submitted, which a second Ctrl-C would be needed for."""
    cancelled: list[bool] = []

    class Pool:
        def __init__(self, *_: object, **__: object) -> None: ...

        def __enter__(self) -> Pool:
            return self

        def __exit__(self, *_: object) -> None: ...

        def submit(self, *_: object) -> Future[None]:
            return Future()

        def shutdown(self, *, cancel_futures: bool) -> None:
            cancelled.append(cancel_futures)

    def interrupted(_: object) -> None:
        raise KeyboardInterrupt

    for module in ("benchtool.run.parallel", "benchtool.acceptance.campaign"):
        monkeypatch.setattr(f"{module}.ProcessPoolExecutor", Pool)
        monkeypatch.setattr(f"{module}.as_completed", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_in_processes(SWEEP, "zhu2011", tmp_path / "run", INFO, RunObserver(), jobs=2)
    with pytest.raises(KeyboardInterrupt):
        conduct_campaign(["zhu2011"], clean=2, jobs=2, tell=lambda *_: None)
    assert cancelled == [True, True]


def test_a_case_that_fails_in_a_process_names_itself(tmp_path: Path) -> None:
    plan = _plan(sweep={"setup": {"i_trip_A": [12.0, 0.2]}})
    with pytest.raises(DriveFault, match="0x2310") as failed:
        run_in_processes(plan, "zhu2011", tmp_path / "run", INFO, RunObserver(), jobs=2)
    assert failed.value.__notes__ == ["in case i_trip_A=0.2"]
    assert Bundle.open(tmp_path / "run" / "i_trip_A=12").complete


def test_an_abort_code_survives_the_way_back_from_a_process() -> None:
    error = pickle.loads(pickle.dumps(SdoAbort("refused", 0x06010002)))
    assert (str(error), error.code) == ("refused", 0x06010002)
