"""`benchtool run PLAN`: its options, and its plans as they are read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from benchtool.cli import options, proposals
from benchtool.cli.junit_file import junit_file
from benchtool.document import Faults
from benchtool.errors import BenchError, NoSuchRecording, PlanError, UsageError
from benchtool.file_kinds import FileKind, mistaken
from benchtool.misfits import Path_
from benchtool.plan import Plan, for_motor, load_plan, plan_names, plan_path, profiles_of
from benchtool.profile import load_profile, profile_path


@dataclass(frozen=True)
class RunOptions:
    """Options of a run that apply to every plan."""

    profile: str = ""
    link: str = "emulated"
    out: Path | None = None
    seed: int = 0
    real_time: bool = False
    as_json: bool = False
    resume: bool = False
    page: Path | None = None
    jobs: int = 1
    allow_different: bool = False
    live: tuple[str, ...] = ()
    note: str = ""
    operator: str = ""
    serial_number: str = ""
    temperature_degC: float | None = None
    instruments: tuple[str, ...] = ()
    yes: bool = False
    changes: tuple[str, ...] = ()
    dry_run: bool = False
    web: bool = False
    junit: Path | None = None

    @property
    def shown(self) -> tuple[str, ...]:
        """Where it is shown live."""
        return (*self.live, *(("web",) if self.web and "web" not in self.live else ()))


@dataclass(frozen=True)
class NamedPlan:
    """A plan by the name it was given, and the profile that it runs with.

    `label` is unique among the plans of a command, `part` is the folder of its bundles, empty of the only
    one.
    """

    name: str
    plan: Plan
    profile: str
    label: str
    part: str


def run(
    plan: Annotated[
        str,
        typer.Argument(
            metavar="PLAN",
            help="Name of a shipped plan, a TOML file, or a folder of plans.",
            autocompletion=proposals.plans,
        ),
    ],
    profile: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE",
            help="Profile to use instead of the plan's.",
            autocompletion=proposals.profiles,
        ),
    ] = "",
    link: options.Link = "emulated",
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="A value of the plan for this run: load_torque_Nm=1, omega_m=1500rpm, setup.law=foc; once "
            "for each.",
            autocompletion=proposals.plan_keys,
        ),
    ] = None,
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", help="Check the plan and show what would be sent, played and recorded."),
    ] = False,
    out: options.Out = None,
    resume: Annotated[
        Path | None, typer.Option(metavar="RUN", help="Go on with a run that was cut short.")
    ] = None,
    page: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write published and measured figures as Markdown.")
    ] = None,
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the verdicts as JUnit XML, for a CI server.")
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Emulated benches to run at a time.")] = 1,
    allow_different: Annotated[
        bool,
        typer.Option("--allow-different", help="Run a drive whose parameters contradict the profile."),
    ] = False,
    note: Annotated[str, typer.Option(help="A line for the manifest.")] = "",
    operator: Annotated[str, typer.Option(help="Who runs the test, for the manifest.")] = "",
    serial_number: Annotated[str, typer.Option(help="Of the motor under test, for the manifest.")] = "",
    temperature: Annotated[
        float | None, typer.Option(min=-273.15, help="Of the surroundings in degrees Celsius, likewise.")
    ] = None,
    instrument: Annotated[
        list[str] | None,
        typer.Option(help="An instrument beside the drive, with its certificate; once for each."),
    ] = None,
    live: options.Live = None,
    web: options.Web = False,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    yes: options.Yes = False,
    as_json: options.Json = False,
) -> int:
    """Run a test plan: set up, run, capture, measure, judge; the drive is disabled afterwards."""
    chosen = RunOptions(
        profile,
        link,
        resume or out,
        seed,
        real_time,
        as_json,
        bool(resume),
        page,
        jobs,
        allow_different,
        tuple(live or ()),
        note,
        operator,
        serial_number,
        temperature,
        tuple(instrument or ()),
        yes,
        tuple(set_ or ()),
        dry_run,
        web,
        junit,
    )
    return run_named(plan, chosen)


def run_named(name: str, chosen: RunOptions) -> int:
    """Read one plan or a folder of plans, and run them; returns the exit code.

    Raises:
        PlanError, ProfileError: one of them is not there, or a key is wrong.
    """
    with junit_file(name, None if chosen.dry_run else chosen.junit) as junit:
        options.require_temperature(chosen.temperature_degC)
        if chosen.resume and chosen.out is not None:
            _require_run(chosen.out)
        names = plan_names(name)
        single = names == (name,)
        plans = [
            plan for each in names for plan in _read(each, chosen.profile, chosen.changes, single=single)
        ]
        # Report errors in the plan before the modules that a run needs are loaded.
        from benchtool.cli.run_plans import run_plans

        return run_plans(name, plans, chosen, junit)


def _require_run(folder: Path) -> None:
    """Refuse to go on with what is no folder of a run."""
    if not folder.is_dir():
        why = f"{folder} {'is a file' if folder.exists() else 'does not exist'}"
        why = f"{why}: give the folder of the run that was cut short"
        raise NoSuchRecording(mistaken(folder, FileKind.RUN) or why)


def _read(name: str, profile: str, given: tuple[str, ...], *, single: bool) -> Iterator[NamedPlan]:
    """Yield the plan with each of its profiles, its values in SI for the motor of that."""
    plan = load_plan(name, further=partial(_further_faults, name, profile))
    places = (profile,) if profile else profiles_of(name, plan)
    for place in places:
        if not profile and place.endswith(".toml") and not Path(place).is_file():
            raise PlanError(
                f"{name}: there is no profile file {place}: a plan names it relative to itself; put it "
                f"there, or name another with --profile"
            )
        motor = load_profile(place).motor
        in_si = for_motor(_changed(name, place, given) if given else plan, motor)
        stem, alone = Path(name).stem, Path(place.removesuffix("/profile.toml")).stem
        if len(places) == 1:
            yield NamedPlan(name, in_si, place, name, "" if single else stem)
            continue
        in_si = in_si.model_copy(update={"case": in_si.case or alone})
        label, part = (place, alone) if single else (f"{name} {place}", f"{stem}/{alone}")
        yield NamedPlan(name, in_si, place, label, part)


def _further_faults(name: str, profile: str, rest: Plan, left_out: frozenset[Path_]) -> Faults:
    """Yield what is wrong of the names and values in the rest of a plan of which a key is wrong, by its first
    profile."""
    from benchtool.plan import Source, faults_of  # which import the analyses
    from benchtool.protocol.dictionary import profiled_dictionary

    with suppress(BenchError):  # of the profile, which is told once the plan's keys are right
        place = profile or profiles_of(name, rest)[0]
        stated = load_profile(place)
        dictionary = profiled_dictionary(stated, profile_path(place), stated.drive.node_id)
        source, in_si = Source.of(rest, plan_path(name)), for_motor(rest, stated.motor)
        # whether the bench has a transducer is told likewise
        yield from faults_of(in_si, source, stated, dictionary, transducer=True, left_out=left_out)


def _changed(name: str, profile: str, given: tuple[str, ...]) -> Plan:
    """Return the plan with what `--set` changes.

    Raises:
        PlanError: a change is of no key, or the plan with it is none.
    """
    from benchtool.bench import dictionary_of
    from benchtool.plan import Changes

    with noting(given):
        return load_plan(name, Changes(given, dictionary_of(profile)).applied)


@contextmanager
def noting(changes: tuple[str, ...]) -> Iterator[None]:
    """Have an error of a plan say what the command line has changed in it: its lines are the file's."""
    try:
        yield
    except UsageError as error:
        if changes and not str(error).startswith("--set"):
            error.add_note(f"with {', '.join(f'--set {each}' for each in changes)}")
        raise
