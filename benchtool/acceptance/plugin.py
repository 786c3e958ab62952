"""The pytest plugin: a bench for tests, limits, and one report for each session.

pytest loads it wherever benchtool is installed; without `--bench` it does nothing and imports nothing.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Generator, Iterator
from datetime import date, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import pytest

if TYPE_CHECKING:
    from benchtool.acceptance.measuring import Measure
    from benchtool.acceptance.notes import Attach, Notes
    from benchtool.acceptance.settings import Settings
    from benchtool.api import Bench, Drive, PlanResult
    from benchtool.bench import Session
    from benchtool.plan import Plan

NAME: Final = "benchtool.acceptance.plugin"
"""Of the plugin, as its entry point and `-p` have it."""

_SETTINGS = pytest.StashKey["Settings"]()
_NOTES = pytest.StashKey["Notes"]()
_STAGES = pytest.StashKey[dict[str, pytest.TestReport]]()

_MARKERS: Final = (
    "requirement(id, ...): requirements that the test is evidence for",
    "waived(reason, by, until=''): the test may fail: why, who consents, and until which day",
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("bench", "a bench for motor drives")
    add = group.addoption
    add("--bench", metavar="PROFILE", default="", help="profile of motor, drive and bench: a name or a file")
    add("--link", metavar="URL", default="emulated", help="address of the drive; emulated by default")
    add(
        "--bench-out",
        metavar="DIR",
        default="",
        help="folder of the session; runs/<time>-acceptance by default",
    )
    add("--bench-seed", type=int, default=0, help="seed of an emulated bench's noise")
    add("--bench-real-time", action="store_true", help="pace an emulated bench by the wall clock")
    add(
        "--bench-alter",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="what differs on an emulated bench",
    )
    add("--bench-operator", metavar="NAME", default="", help="who tests, for the report")
    add("--bench-serial-number", metavar="TEXT", default="", help="of the motor under test, for the report")
    add("--bench-temperature", metavar="DEGC", type=float, help="of the surroundings, for the report")
    add(
        "--bench-instrument",
        metavar="TEXT",
        action="append",
        default=[],
        help="an instrument, with certificate",
    )
    add("--bench-waivers", metavar="FILE", default="", help="TOML file of tests that may fail")
    add(
        "--bench-history",
        metavar="N",
        type=int,
        default=10,
        help="earlier sessions that the report compares with",
    )
    add("--bench-pdf", action="store_true", help="write the report as PDF, too")
    add("--bench-bare", action="store_true", help="verdicts alone: no report, no pictures, no recorded data")


def pytest_configure(config: pytest.Config) -> None:
    """Read the options, and have the process that collects the results write the report."""
    for each in _MARKERS:
        config.addinivalue_line("markers", each)
    if not config.getoption("--bench"):
        return
    from benchtool.errors import BenchError
    from benchtool.recording import require_empty

    is_worker = hasattr(config, "workerinput")
    try:
        settings = _settings(config)
        if not (is_worker or settings.bare or config.getoption("collectonly")):
            require_empty(settings.out)  # an earlier session is evidence
    except BenchError as refused:
        raise pytest.UsageError("\n".join((str(refused), *getattr(refused, "__notes__", ())))) from None
    config.stash[_SETTINGS] = settings
    if not is_worker:
        from benchtool.acceptance.session_log import SessionLog

        config.pluginmanager.register(SessionLog(settings, config), f"{NAME}.session")


def _settings(config: pytest.Config) -> Settings:
    from benchtool.acceptance.settings import Settings, alterations, require_usable
    from benchtool.acceptance.waivers import load_waivers
    from benchtool.recording import Conditions

    option = config.getoption
    profile, link = option("--bench"), option("--link")
    require_usable(profile, link, workers=len(getattr(config.option, "tx", None) or ()))
    now = datetime.now().astimezone()
    worker: dict[str, Any] = getattr(config, "workerinput", {})
    out = worker.get("benchtool_out") or option("--bench-out") or f"runs/{now:%Y%m%d-%H%M%S}-acceptance"
    waivers = option("--bench-waivers")
    return Settings(
        profile,
        link,
        Path(out).resolve(),
        option("--bench-seed"),
        option("--bench-real-time"),
        alterations(option("--bench-alter")),
        Conditions(
            operator=option("--bench-operator"),
            test_object_serial_number=option("--bench-serial-number"),
            temperature_degC=option("--bench-temperature"),
            instruments=tuple(option("--bench-instrument")),
        ),
        load_waivers(Path(waivers)) if waivers else (),
        option("--bench-bare"),
        option("--bench-pdf"),
        option("--bench-history"),
    )


# ---- fixtures ----------------------------------------------------------------------------------------------


def _notes(request: pytest.FixtureRequest) -> Notes:
    """Return the notes of the test that asks for a fixture.

    Raises:
        Failed: there is no bench.
    """
    found: Notes | None = request.node.stash.get(_NOTES, None)
    if found is None:
        pytest.fail(
            "this test needs a bench: give --bench PROFILE, and --link URL for a real drive", pytrace=False
        )
    return found


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Iterator[Bench]:
    """Return the bench, opened for this test; afterwards its drive is disabled and its load off."""
    from benchtool.acceptance.stand import NotHealthy, standing
    from benchtool.errors import BenchError

    notes, complaint = _notes(request), ""
    try:
        with standing(request.config.stash[_SETTINGS], notes) as opened:
            yield opened
    except (BenchError, NotHealthy) as failed:
        complaint = "\n".join((str(failed), *getattr(failed, "__notes__", ())))
    if complaint:
        pytest.fail(complaint, pytrace=False)


@pytest.fixture
def drive(bench: Bench) -> Drive:
    """Return the drive of the bench."""
    return bench.drive


@pytest.fixture
def bench_session(bench: Bench) -> Iterator[Session]:
    """Return the session beneath the bench, for what the API does not have."""
    from benchtool.api import session_of

    with session_of(bench) as session:
        yield session


@pytest.fixture
def measure(request: pytest.FixtureRequest) -> Measure:
    """Return what holds values against limits; the test fails at its end if one of them is not met."""
    from benchtool.acceptance.measuring import Measure

    return Measure(_notes(request))


@pytest.fixture
def attach(request: pytest.FixtureRequest) -> Attach:
    """Return what keeps files with the test."""
    from benchtool.acceptance.notes import Attach

    return Attach(_notes(request))


@pytest.fixture
def inject_fault(request: pytest.FixtureRequest, bench_session: Session) -> Callable[[str], str]:
    """Return a function that injects a fault into an emulated bench, as `emulate --fault` spells it.

    A rig skips the test. The faults end with the test, and the drive must be fit for work again.
    """
    notes, faults = _notes(request), bench_session.faults
    if faults is None:
        pytest.skip("faults are injected into an emulated bench, and this one is not")

    def inject(fault: str) -> str:
        """Inject a fault; its seconds count from now. Returns it as it was understood."""
        notes.injected.append(told := str(faults.inject(fault)))
        return told

    return inject


@pytest.fixture
def run_plan(request: pytest.FixtureRequest, bench: Bench) -> Callable[..., PlanResult]:
    """Return a function that runs a plan on the bench, keeps its bundle, and holds its limits."""
    notes = _notes(request)

    def run(plan: str | Path | Plan, *, judge: bool = True, allow_different: bool = False) -> PlanResult:
        """Run a plan; its limits become those of the test unless `judge` is false."""
        from benchtool.acceptance.plans import run_on_bench

        return run_on_bench(bench, plan, notes, judge=judge, allow_different=allow_different)

    return run


# ---- each test ---------------------------------------------------------------------------------------------


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Begin the notes of a test."""
    settings = item.config.stash.get(_SETTINGS, None)
    if settings is None:
        return
    from benchtool.acceptance.notes import Notes

    name = name_of_test(item)
    folder = settings.out / re.sub(r"[^\w.,=+-]+", "_", name).strip("_")
    item.stash[_NOTES] = Notes(name, folder, settings.out, pictures=not settings.bare)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    """Have a test fail whose limits are not met."""
    result = yield
    notes = item.stash.get(_NOTES, None)
    if notes is not None and notes.complaints:
        pytest.fail("\n".join(notes.complaints), pytrace=False)
    return result


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Apply waivers, and put the record of a test into its last report."""
    report = yield
    notes = item.stash.get(_NOTES, None)
    if notes is None:
        return report
    from benchtool.acceptance.records import record_of, requirements_of, waiver_for

    stages = item.stash.setdefault(_STAGES, {})
    stages[report.when] = report
    notes.failed = notes.failed or report.failed
    waiver = waiver_for(item, notes, item.config.stash[_SETTINGS].waivers, date.today())
    if report.when == "call" and report.failed and waiver is not None:
        report.outcome = "skipped"
        report.wasxfail = f"waived by {waiver.by}: {waiver.reason}"
    if report.when == "call" or not report.passed:
        item.user_properties[:] = [
            *(("requirement", each) for each in requirements_of(item)),
            *((f"measured {each.name}", each.stated) for each in notes.judged),
        ]
    if report.when == "teardown":
        record = record_of(item, notes, stages, waiver)
        told = {"test": record.model_dump(mode="json"), "facts": notes.facts}
        report.benchtool = json.dumps(told)  # type: ignore[attr-defined] # kept by pytest-xdist
    return report


def name_of_test(item: pytest.Item) -> str:
    """Return the name of a test by which waivers, reports and earlier sessions know it."""
    return f"{item.path.stem}::{item.nodeid.partition('::')[2]}"
