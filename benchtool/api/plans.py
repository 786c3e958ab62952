"""Plans: made in Python or read, run, and what came of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from benchtool.api.load import Ask
from benchtool.api.named import Named
from benchtool.api.results import Results
from benchtool.errors import PlanError, UsageError
from benchtool.misfits import explain
from benchtool.notebook import table_html
from benchtool.plan import Verdict, model

if TYPE_CHECKING:
    from benchtool.api.bundles import Bundle
    from benchtool.api.connection import Connection
    from benchtool.bench import Session
    from benchtool.plan import Case
    from benchtool.results import Assessment, RunResult
    from benchtool.run import RunInfo


class Plan(model.Plan):
    """A test, as a TOML file has it: set up, operating point, what is recorded, measured and limited.

        plan = benchtool.Plan(
            title="Ripple at half speed",
            profile="zhu2011",
            setup={"law": "tpc"},
            operating_point={"omega_m_rad_s": 80.0, "load_torque_Nm": 1.0},
            record={"duration_s": 0.2, "channels": ["i_a", "torque", "theta_m"]},
            limits={"torque_ripple_pp": {"max": 0.1}},
        )

    Raises:
        PlanError: a key is unknown, missing or wrong; the message names it.
    """

    def __init__(self, **content: Any) -> None:
        try:
            super().__init__(**content)
        except ValidationError as failed:
            raise PlanError(f"plan: {explain(model.Plan, failed)}") from None

    @classmethod
    def load(cls, name: str | Path) -> Plan:
        """Return the plan of a shipped name or of a TOML file; `model_copy(update={...})` alters it.

        Raises:
            PlanError: unknown, unreadable, or a key is wrong.
        """
        return cls(**model.load_plan(str(name)).model_dump(exclude_unset=True))


class CaseResult(Results):
    """What one case of a plan measured, and how it met its limits."""

    def __init__(self, assessment: Assessment) -> None:
        lacking: dict[str, str] = {
            title: f"needs {', '.join(channels)}" for title, channels in assessment.without.items()
        }
        lacking |= assessment.refused
        lacking |= {"the operating point was not reached": assessment.refusal} if assessment.refusal else {}
        super().__init__(assessment.measurements, assessment.tables, lacking)
        self.assessment = assessment

    @property
    def name(self) -> str:
        """Of the case."""
        return self.assessment.case

    @property
    def verdict(self) -> Verdict:
        """How its limits were met; `none` where these are, and others hold for its repetitions together."""
        return self.assessment.verdict

    @property
    def folder(self) -> Path:
        """Of its bundle."""
        return self.assessment.bundle

    @property
    def bundle(self) -> Bundle:
        """What was recorded."""
        from benchtool.api.bundles import open_bundle

        return open_bundle(self.folder)

    def __str__(self) -> str:
        judged = [f"{each.verdict}: {each}" for each in self.assessment.missed]
        return "\n".join([f"{self.name}: {self.verdict}", *judged, super().__str__()])


class PlanResult(Named["CaseResult"]):
    """What a plan came to: its cases by name.

    result["tpc"]["torque_ripple_pp"]
    result.verdict
    result.measurement("torque_ripple_pp")     # of each case
    """

    def __init__(self, result: RunResult, plan: model.Plan, folder: Path) -> None:
        self.result = result
        self.plan = plan
        self.folder = folder
        self._cases = {each.case: CaseResult(each) for each in result.assessments}

    @property
    def verdict(self) -> Verdict:
        """The worst of all cases, and of their repetitions together."""
        return self.result.verdict

    @property
    def case(self) -> CaseResult:
        """The one case of a plan that has one.

        Raises:
            UsageError: it has several.
        """
        if len(self._cases) != 1:
            raise UsageError(
                f"the plan has {len(self._cases)} cases, {', '.join(self)}: name one, result[name]"
            )
        return next(iter(self._cases.values()))

    @property
    def bundle(self) -> Bundle:
        """What the one case of the plan recorded.

        Raises:
            UsageError: the plan has several.
        """
        return self.case.bundle

    def measurement(self, name: str) -> dict[str, float]:
        """Return the value of a measurement by case.

        Raises:
            AnalysisError: a case has none of this name.
        """
        return {case: found[name].value for case, found in self._cases.items()}

    def __getitem__(self, name: str) -> CaseResult:
        """Return a case by name.

        Raises:
            UsageError: there is none.
        """
        if name in self._cases:
            return self._cases[name]
        if len(self._cases) == 1 and name in self.case:
            raise UsageError(f"'{name}' is a measurement, cases go by name: result.case['{name}']")
        raise UsageError(f"no case '{name}' in this plan: its cases are {', '.join(self)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._cases)

    def __str__(self) -> str:
        return "\n\n".join(
            [f"{self.plan.title}: {self.verdict}", *(str(each) for each in self._cases.values())]
        )

    def __repr__(self) -> str:
        return f"<PlanResult: {self.verdict}, {len(self)} cases in {self.folder}>"

    def _repr_html_(self) -> str:
        tables = [
            table_html(
                ("measurement", ">value ± U (95 %)", "limit"),
                [(each.name, str(each), _limit(case, each.name)) for each in case.measurements],
                f"{name}: {case.verdict}",
            )
            for name, case in self._cases.items()
        ]
        return table_html(("plan", "verdict"), [(self.plan.title, str(self.verdict))]) + "".join(tables)


def run_plan(
    plan: str | Path | model.Plan,
    out: str | Path | None = None,
    *,
    profile: str | Path = "",
    link: str = "emulated",
    seed: int = 0,
    real_time: bool = False,
    allow_different: bool = False,
    note: str = "",
    ask: Ask | None = None,
    progress: Callable[[str], None] | None = None,
) -> PlanResult:
    """Run a plan: set up, run, capture, measure, judge; the drive is disabled afterwards.

        result = benchtool.run_plan("zhu2011/ripple")
        print(result.verdict, result.case["torque_ripple_pp"])

    Args:
        plan: name of a shipped plan, a TOML file, or a `Plan`.
        out: folder of the run bundle; one of its own in `runs` without it.
        profile: to use instead of the plan's.
        link: address of the drive, as `open_bench` takes it.
        seed: of the emulated bench's noise.
        real_time: pace an emulated bench by the wall clock.
        allow_different: run a drive whose parameters contradict the profile.
        note: a line for the manifest.
        ask: asks the person at a bench without load machine, such as `input`.
        progress: takes a line for each step.

    Raises:
        PlanError, ProfileError: a key is wrong, or plan and profile do not fit each other.
        BenchError: whatever went wrong; a bundle that was begun holds what came until then.
    """
    from benchtool.bench import open_session
    from benchtool.plan import for_motor
    from benchtool.profile import load_profile, profile_path
    from benchtool.run import check_plan

    read, file = _read(plan)
    place = str(profile or read.profile)
    read = for_motor(read, load_profile(place).motor)
    check_plan(read, file, place, link)
    info = replace(
        _info(link, seed, ask, allow_different=allow_different, note=note),
        profile_toml=profile_path(place).read_text(encoding="utf-8"),
    )
    tell = progress or _silent

    def opener(case: Case, seed: int) -> AbstractContextManager[Session]:
        return open_session(place, link, seed=seed, real_time=real_time, note=tell, alter=case.emulator)

    return _run(opener, read, _title(plan, read), out, info, tell)


def run_on(
    connection: Connection,
    plan: str | Path | model.Plan,
    out: str | Path | None,
    *,
    seed: int,
    ask: Ask | None,
    allow_different: bool,
    note: str,
) -> PlanResult:
    """See `Bench.run`."""
    from benchtool.plan import for_motor
    from benchtool.run import check_plan

    read, file = _read(plan)
    with connection.use() as session:
        if connection.enabled is not None:
            raise UsageError(
                "the drive is enabled, and a plan enables it itself: leave that `with` block first"
            )
        read = for_motor(read, session.profile.motor)
        check_plan(read, file, session.profile_name, connection.link)
        info = replace(
            _info(connection.link, seed, ask, allow_different=allow_different, note=note),
            profile_toml=session.profile_toml,
        )
        opener = partial(_lent, session)
        return _run(opener, read, _title(plan, read), out, info, _silent)


def _lent(session: Session, case: Case, _seed: int) -> AbstractContextManager[Session]:
    """Return an open session for a case, left open.

    Raises:
        UsageError: the case alters the emulated bench.
    """
    if case.emulator:
        raise UsageError(
            f"case '{case.name}' alters the emulated bench ({', '.join(case.emulator)}), and this one is "
            f"open: run the plan with benchtool.run_plan(plan)"
        )
    return nullcontext(session)


def _run(
    opener: Callable[[Case, int], AbstractContextManager[Session]],
    plan: model.Plan,
    title: str,
    out: str | Path | None,
    info: RunInfo,
    tell: Callable[[str], None],
) -> PlanResult:
    from benchtool.recording import enlist
    from benchtool.results import recorded_bundles
    from benchtool.run import bundle_folder, run_plan as run_cases

    now = datetime.now().astimezone()
    with bundle_folder(None if out is None else Path(out), now, title) as folder:
        result = run_cases(opener, plan, folder, info, _Progress(tell))
        enlist(folder, [each.directory for each in recorded_bundles(folder)])
        return PlanResult(result, plan, folder)


def _read(plan: str | Path | model.Plan) -> tuple[model.Plan, Path | None]:
    """Return the plan, and its file if it has one."""
    if isinstance(plan, model.Plan):
        return plan, None
    return model.load_plan(str(plan)), model.plan_path(str(plan))


def _title(plan: str | Path | model.Plan, read: model.Plan) -> str:
    """Return what the folder of a run is called after."""
    if isinstance(plan, model.Plan):
        kept = "".join(each if each.isalnum() else "-" for each in read.title.lower())
        return "-".join(filter(None, kept.split("-")))[:60] or "plan"
    return Path(plan).stem if str(plan).endswith(".toml") else str(plan)


def _info(link: str, seed: int, ask: Ask | None, *, allow_different: bool, note: str) -> RunInfo:
    from benchtool.bench import Confirmation
    from benchtool.run import RunInfo

    def prompt(what: str) -> Confirmation:
        assert ask is not None
        ask(f"The drive is disabled. Please {what}, then go on. ")
        return Confirmation.BY_OPERATOR

    return RunInfo(
        datetime.now().astimezone().isoformat(timespec="seconds"),
        seed,
        (),
        allow_different,
        wall_s=time.time,
        link=link,
        note=note,
        prompt=None if ask is None else prompt,
    )


def _limit(case: CaseResult, name: str) -> str:
    """Return the limit of a measurement with its verdict; empty without one."""
    verdict: Mapping[str, Verdict] = case.assessment.verdicts
    limit = case.assessment.limits.get(name)
    return "" if limit is None else f"{limit.bounds}: {verdict[name]}"


class _Progress:
    """Tells of the steps of a run in lines."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell

    def begin(self, case: str, number: int, count: int) -> None:
        """See `benchtool.run.case.Progress`."""
        self._tell(f"case {number} of {count}: {case}")

    def note(self, text: str) -> None:
        """See `benchtool.run.case.Progress`."""
        self._tell(text)


def _silent(_text: str) -> None:
    """Does nothing."""
