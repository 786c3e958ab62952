"""The report of recorded runs: every case measured again, and all that its bundle says of its origin."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure
from pydantic import ValidationError

from benchtool.block import Block
from benchtool.errors import BenchError
from benchtool.experiment.assessment import Assessment
from benchtool.experiment.drawing import case_figures, run_figures
from benchtool.experiment.limits import Verdict, worst
from benchtool.experiment.plan import Plan
from benchtool.experiment.repetition import over_repetitions
from benchtool.experiment.runs import RecordedCase, RecordedRun
from benchtool.profile import Choice, Profile
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.keys import toml_key
from benchtool.recording import Bundle, Manifest
from benchtool.report import content
from benchtool.report.content import Cell, Grid, Item, Mark, Picture, Report, Section, Text
from benchtool.report.numbers import NOTHING, number, raw, stated
from benchtool.report.origin import (
    choices_section,
    files_section,
    parameters_section,
    plan_section,
    quality_section,
    run_facts,
)
from benchtool.report.overview import draw_channels
from benchtool.report.results import Bounds, limits_section, measurements_section, tables_section
from benchtool.shipped import shipped

FOREMOST: Final = ("torque_ripple_pp", "true_torque_ripple_pp", "flux_ripple_pp", "current_thd")
_MOST_FOREMOST = 5
_CAPTIONS: Final = {
    "waveforms": "Torque, phase currents and stator flux over the first two electrical periods of the "
    "capture. The shaft transducer's torque is the true one; the ripple measured is that of the drive's "
    "estimate.",
    "current_spectrum": "Amplitude spectrum of phase current a over whole electrical periods: above, up to "
    "ten times the fundamental, below, the whole band. Where there are more lines than dots, the least and "
    "the greatest.",
    "flux_trajectory": "Stator flux in stator coordinates over the first two electrical periods.",
    "torque": "Torque and its reference over the whole capture.",
    "bode": "Frequency response: gain, phase and coherence.",
    "switching_states": "Share of time of the inverter's voltage vectors.",
    "steady": "Torque, phase current a and stator flux at the beginning of each capture, on the same axes.",
    "spectra": "Amplitude spectrum of phase current a up to ten times the fundamental, dc left out.",
    "cases": "All cases of the plan side by side, on the same axes.",
}
_WORDS: Final[dict[Verdict, str]] = {
    Verdict.NONE: "No limits",
    Verdict.PASS: "Pass",
    Verdict.MARGINAL: "Marginal",
    Verdict.FAIL: "Fail",
}


def run_report(folder: Path, runs: Sequence[RecordedRun]) -> Report:
    """The report of what `folder` holds; the same bundles give the same report.

    Raises:
        RecordingError: a file of a bundle cannot be read.
    """
    cases = [case for run in runs for case in run.cases]
    manifest = cases[0].bundle.manifest
    title = manifest.what if len(runs) == 1 else f"{len(runs)} plans: {folder.resolve().name}"
    subtitle = f"Test report · {manifest.when} · profile {manifest.profile_name or 'unknown'}"
    items: list[Item] = [_banner(worst(run.verdict for run in runs), cases)]
    if len(cases) == 1:
        (case,) = cases
        items += [
            *_failure(case),
            Section("The run", (_facts(case),)),
            *_case_items(case),
            *_own_files(folder, case),
        ]
    elif len(runs) == 1:
        items += [*_run_items(runs[0], listed=True), _common_files(folder, runs)]
    else:
        plans = [_plan_row(run) for run in runs]
        items.append(Section("Plans", (Grid.of(("plan", "cases", "verdict", "title"), plans),)))
        items += [
            Section(f"Plan {run.name}", tuple(_run_items(run, listed=False)), listed=True) for run in runs
        ]
        items.append(_common_files(folder, runs))
    return Report(title, subtitle, manifest.when, tuple(items))


def mark(verdict: Verdict) -> Mark:
    """A verdict as the report marks it."""
    marks: dict[Verdict, Mark] = {
        Verdict.NONE: "none",
        Verdict.PASS: "pass",
        Verdict.MARGINAL: "marginal",
        Verdict.FAIL: "fail",
    }
    return marks[verdict]


def picture(name: str, figure: Figure) -> Picture:
    """A figure with its caption; one that is not known by name is described by its axes."""
    described = content.describe_figure(figure)
    return Picture(figure, _CAPTIONS.get(name, described), described)


def read_already(result: Assessment | None) -> Mapping[str, Block]:
    """The streams that measuring has read."""
    if result is None:
        return {}
    transducer = {} if result.transducer is None else {"transducer": result.transducer}
    return {"capture": result.capture, **transducer}


def case_label(run: RecordedRun, case: RecordedCase) -> str:
    """A case's name, with its plan's where there are several."""
    return f"{run.name}/{case.name}" if run.name else case.name


def _banner(verdict: Verdict, cases: Sequence[RecordedCase]) -> content.Verdict:
    limits = [each for case in cases if case.assessment for each in case.assessment.verdicts.values()]
    failures = [case for case in cases if case.failure]
    parts = []
    if limits:
        met = sum(each is not Verdict.FAIL for each in limits)
        parts.append(f"{met} of {len(limits)} limits met")
        if tight := sum(each is Verdict.MARGINAL for each in limits):
            parts.append(f"{tight} of them marginally")
    else:
        parts.append("no limits were set")
    if failures:
        parts.append(f"{len(failures)} of {len(cases)} cases failed or were cut short")
    elif len(cases) > 1:
        parts.append(f"{len(cases)} cases")
    mark_: Mark = mark(verdict)
    text = f"{content.SYMBOLS[mark_]} {_WORDS[verdict]}"
    summary = ", ".join(parts)
    return content.Verdict(mark_, text, f"{summary[0].upper()}{summary[1:]}.")


def _failure(case: RecordedCase) -> Iterator[Item]:
    if case.failure and case.bundle.complete:
        yield Text(f"This recording could not be measured: {case.failure}", "warning")
    elif case.failure:
        yield Text(
            f"This case did not come to its end: {case.failure}. What follows came till then.", "warning"
        )
    elif case.assessment is None:
        yield Text("A recording without a plan: nothing is measured or judged.", "note")


def _facts(case: RecordedCase) -> content.Facts:
    facts = run_facts(case.bundle.manifest)
    streams = [
        f"{name} {number(info.rows)} rows" + (f", {info.missing_rows} missing" if info.missing_rows else "")
        for name, info in case.bundle.manifest.streams.items()
    ]
    if case.assessment is not None:
        capture = case.assessment.capture
        length_s = len(capture.data) * capture.stride * capture.tick_s
        streams.append(f"captured {raw(length_s)} s at {raw(capture.sample_rate_Hz)} Hz")
    recorded = (("recorded", "; ".join(streams)),) if streams else ()
    return content.Facts((("case", case.name), *facts.pairs, *recorded))


def _case_items(case: RecordedCase, *, alone: bool = True) -> Iterator[Item]:
    """What one case measured and shows; with the drive, the plan and the profile, if it stands `alone`."""
    result = case.assessment
    limits: dict[str, Bounds] = {}
    if result is not None:
        limits = {
            name: Bounds(limit.min, limit.max, limit.margin, mark(result.verdicts[name]))
            for name, limit in result.limits.items()
        }
        yield limits_section((*result.measurements, *result.quality), limits)
        yield measurements_section("Measurements", result.measurements, limits, result.published)
        if (tables := tables_section(result.tables)) is not None:
            yield tables
    if figures := _figures(case):
        yield Section("Figures", tuple(figures))
    yield quality_section(case.bundle, limits)
    if alone:
        yield from _circumstances(case.bundle)


def _figures(case: RecordedCase) -> list[Item]:
    figures: list[Item] = []
    result = case.assessment
    if result is not None:
        plan = Plan.model_validate(case.bundle.manifest.details["plan"])
        figures += [picture(name, figure) for name, figure in case_figures(plan, result).items()]
    stream = "capture" if result is not None else next(iter(case.bundle.streams), None)
    try:
        block = result.capture if result is not None else case.bundle.block(stream) if stream else None
    except BenchError as unreadable:
        return [*figures, Text(f"Stream {stream} cannot be read: {unreadable}", "warning")]
    if block is None or not len(block.data):
        return figures
    figure = draw_channels(block, f"{case.name}: every channel of stream {stream}")
    caption = (
        f"Every channel of stream {stream} over its whole length, {number(len(block.data))} rows at "
        f"{raw(block.sample_rate_Hz)} Hz. Long traces are drawn by the least and the greatest value of each "
        f"stretch, so that no peak is lost; a gap in a line is a gap in the data."
    )
    return [*figures, Picture(figure, caption, content.describe_figure(figure))]


def _circumstances(bundle: Bundle) -> Iterator[Item]:
    manifest = bundle.manifest
    profile = _profile(manifest)
    yield parameters_section(manifest.parameters, _described(manifest, profile))
    if "plan" in manifest.details:
        yield plan_section(manifest.details["plan"])
    choices: Sequence[Choice] = () if profile is None else profile.choices
    if (section := choices_section(choices)) is not None:
        yield section


def _profile(manifest: Manifest) -> Profile | None:
    """The profile that the bundle carries; None if this version does not understand it."""
    try:
        return Profile.model_validate(tomllib.loads(manifest.profile_toml))
    except (tomllib.TOMLDecodeError, ValidationError):
        return None


def _described(manifest: Manifest, profile: Profile | None) -> Mapping[str, tuple[str, str, object]]:
    """Name, unit and default of each parameter's key, if the dictionary that the drive had ships with this
    version; another one might say otherwise."""
    eds = shipped("firmware_protocol") / (profile.drive.eds if profile else "drive.eds")
    try:
        dictionary = Dictionary.from_eds(eds, 1)
    except BenchError:
        return {}
    if manifest.dictionary_hash is None or dictionary.hash != manifest.dictionary_hash:
        return {}
    return {toml_key(each): (each.name, each.unit, each.default) for each in dictionary}


def _run_items(run: RecordedRun, *, listed: bool) -> Iterator[Item]:
    """One plan of several cases: all of them in one table and one figure, then each for itself."""
    first = run.cases[0].bundle
    yield Section("Overview" if listed else "All cases", tuple(_overview(run)), listed=listed)
    yield Section("The run" if listed else "Run", (_facts(run.cases[0]), *_differences(run)))
    yield from _circumstances(first)
    for case in run.cases:
        title = f"Case {case_label(run, case)}"
        yield Section(title, (*_failure(case), *_case_items(case, alone=False)), listed=True)


def _overview(run: RecordedRun) -> Iterator[Item]:
    results = [case.assessment for case in run.cases if case.assessment is not None]
    plan = Plan.model_validate(run.cases[0].bundle.manifest.details["plan"]) if results else None
    names = _foremost(run, plan)
    units = {each.name: each.unit for result in results for each in result.measurements}
    rows: list[tuple[str | Cell, ...]] = [
        (
            case.name,
            *(_overview_cell(case, name) for name in names),
            Cell(str(case.verdict), mark(case.verdict), (case.failure,) if case.failure else ()),
        )
        for case in run.cases
    ]
    headings = [f">{name} ({units[name]})" if units[name] else f">{name}" for name in names]
    yield Grid.of(("case", *headings, "verdict"), rows)
    if any(result.published for result in results):
        yield Text("Published figures stand in brackets.", "note")
    if plan is None:
        return
    measured = {result.case: result.measurements for result in results}
    if len(measured) == len(run.cases):
        for case, together in over_repetitions(plan, measured).items():
            repeated = [
                (each.name, stated(each.mean, each.standard_uncertainty), each.unit, str(each.n))
                for each in together
            ]
            grid = Grid.of(("measurement", ">mean ± standard uncertainty", "unit", ">repetitions"), repeated)
            yield Section(f"{case} over its repetitions", (grid,))
    for name, figure in run_figures(plan, results).items():
        yield picture(name, figure)


def _foremost(run: RecordedRun, plan: Plan | None) -> list[str]:
    """What an overview shows: what the plan tabulates, else what it limits and what is asked first."""
    found = dict.fromkeys(
        each.name for case in run.cases if case.assessment for each in case.assessment.measurements
    )
    if plan is not None and plan.tabulate:
        return [name for name in plan.tabulate if name in found]
    limited = [name for case in run.cases if case.assessment for name in case.assessment.limits]
    return list(dict.fromkeys(name for name in (*limited, *FOREMOST, *found) if name in found))[
        :_MOST_FOREMOST
    ]


def _overview_cell(case: RecordedCase, name: str) -> Cell:
    result = case.assessment
    measured = next((each for each in result.measurements if each.name == name), None) if result else None
    if result is None or measured is None:
        return Cell(NOTHING)
    text = stated(measured.value, measured.uncertainty.standard if measured.uncertainty else None)
    if name in result.published:
        text += f" ({raw(result.published[name])})"
    return Cell(text, mark(result.verdicts[name])) if name in result.verdicts else Cell(text)


def _differences(run: RecordedRun) -> Iterator[Item]:
    """Parameters of the drive that are not the same in all cases."""
    held = [case.bundle.manifest.parameters for case in run.cases]
    keys = dict.fromkeys(key for parameters in held for key in parameters)
    differing = [key for key in keys if len({parameters.get(key) for parameters in held}) > 1]
    if differing:
        rows = [
            (case.name, *(raw(case.bundle.manifest.parameters.get(key, NOTHING)) for key in differing))
            for case in run.cases
        ]
        yield Grid.of(("case", *differing), rows, "Parameters of the drive in which the cases differ.")


def _plan_row(run: RecordedRun) -> tuple[str | Cell, ...]:
    verdict = Cell(str(run.verdict), mark(run.verdict))
    return run.name, str(len(run.cases)), verdict, run.cases[0].bundle.manifest.what


def _own_files(folder: Path, case: RecordedCase) -> Iterator[Item]:
    name = folder.resolve().name
    yield files_section(
        [("", case.bundle, read_already(case.assessment))],
        [f"benchtool analyze {name}", f"benchtool export {name} --format csv"],
    )


def _common_files(folder: Path, runs: Sequence[RecordedRun]) -> Section:
    name = folder.resolve().name
    bundles = [
        (
            f"{case.bundle.directory.relative_to(folder).as_posix()}/",
            case.bundle,
            read_already(case.assessment),
        )
        for run in runs
        for case in run.cases
    ]
    commands = [f"benchtool compare {name}", f"benchtool analyze {name}/{bundles[0][0].rstrip('/')}"]
    section = files_section(bundles, commands)
    return Section(section.title, section.items, listed=True)
