"""The page that is signed: what was tested, on what and by whom, the verdicts with their limits, what was not
run, and what casts doubt on any of it."""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

from benchtool.analysis import NOTHING, count_of, raw, with_unit
from benchtool.block import Block
from benchtool.plan import JudgedLimit, Verdict, worst
from benchtool.profile import Bench, Profile
from benchtool.recording import MANIFEST, Bundle, Manifest, hash_of
from benchtool.report import content
from benchtool.report.assembly.case import coordinates, failure, remarks, unmeasured
from benchtool.report.assembly.recording import recording_items
from benchtool.report.content import Cell, Facts, Grid, Item, Mark, Section, Signatures, Text
from benchtool.report.provenance import drive_numbers, link_of, profile_of, settings_line, supervision_notes
from benchtool.report.results import bounds_of, judged_value, limits_section, mark, verdict_cell
from benchtool.results import RecordedCase, RecordedRun, judged_together, overdue_text, waived_limits

_WORDS: Final[dict[Verdict, str]] = {
    Verdict.NONE: "No limits",
    Verdict.PASS: "Pass",
    Verdict.MARGINAL: "Marginal",
    Verdict.UNDECIDED: "Undecided",
    Verdict.FAIL: "Fail",
}
_UNSTATED: Final = "not stated"
ROLES: Final = ("Tested by", "Checked by")
_MOST_TOLD = 6  # cases whose remarks stand on the first page


def front_items(runs: Sequence[RecordedRun]) -> Iterator[Item]:
    """Yield what stands on the first page of the report of these runs."""
    found = [case for run in runs for case in run.cases]
    together = [each.verdict for run in runs for _, each in judged_together(run.repeated)]
    shaft = worst(by for run in runs if (by := run.verdict_by_transducer) is not None)
    yield banner(worst(run.verdict for run in runs), shaft, found, together)
    for run in runs:
        yield from (Text(f"Undecided: {each.of_one}.", "warning") for each in run.result.unjudged.values())
    yield from supervision_notes(case.bundle.manifest for case in found)
    if len(found) == 1:
        yield from failure(found[0])
    yield from _warnings(runs, found)
    yield Section("What was tested", (tested(runs, found),))
    if len(found) == 1 and found[0].assessment is not None:
        yield from recording_items(found[0].assessment)
    if len(found) == 1:
        result = found[0].assessment
        if result is not None and result.recorded is None:  # a recording has no plan that could set any
            yield limits_section(result.judged.values())
    elif not all(case.assessment and case.assessment.recorded for case in found):
        yield _judged_together(runs)
    if (requirements := requirements_section(runs)) is not None:
        yield requirements
    yield Section("Not run, not measured or waived", tuple(_not_run(runs, found)))
    yield Signatures(ROLES)


def banner(
    verdict: Verdict, shaft: Verdict, found: Sequence[RecordedCase], together: Sequence[Verdict]
) -> content.Verdict:
    """Return the outcome of all limits, of each case and of repetitions `together`; `shaft` is the
    verdict by the transducer, `NONE` without one."""
    limits = [each for case in found if case.assessment for each in case.assessment.verdicts.values()]
    limits += together
    failures = [case for case in found if case.failure]
    parts = []
    if limits:
        met = sum(each.met for each in limits)
        tight = sum(each is Verdict.MARGINAL for each in limits)
        marginally = f" ({tight} of them marginally)" if tight else ""
        parts.append(f"{met} of {count_of(len(limits), 'limit')} met{marginally}")
        if undecided := sum(each is Verdict.UNDECIDED for each in limits):
            parts.append(f"{undecided} undecided")
    else:
        parts.append("no limits were set")
    if failures:
        parts.append(f"{len(failures)} of {len(found)} cases failed or were cut short")
    elif len(found) > 1:
        parts.append(f"{len(found)} cases")
    overdue = [each for case in found if case.assessment for each in case.assessment.overdue]
    parts += [overdue_text(overdue)] if overdue else []
    mark_: Mark = mark(verdict)
    text = f"{content.SYMBOLS[mark_]} {_WORDS[verdict]}"
    summary = ", ".join(parts)
    other = f" By the transducer on the shaft: {shaft}." if shaft not in (Verdict.NONE, verdict) else ""
    return content.Verdict(mark_, text, f"{summary[0].upper()}{summary[1:]}.{other}")


def tested(runs: Sequence[RecordedRun], found: Sequence[RecordedCase]) -> Facts:
    """Return the test object, operating point, drive, bench, operator and day; what is not known of those one
    signs for is said to be so."""
    manifest, alone = found[0].bundle.manifest, len(found) == 1
    identity, conditions, profile = manifest.identity, manifest.conditions, profile_of(manifest)
    point = manifest.details.get("operating_point")
    result = found[0].assessment
    case = ", ".join((found[0].name, *(f"{key} {what}" for key, what in coordinates(found[0]))))
    last = max(each.bundle.manifest.when for each in found)
    several = "" if last == manifest.when else f" to {last}"
    capture = None if result is None else result.capture
    pairs = {
        "test object": f"serial number {conditions.test_object_serial_number or _UNSTATED}",
        "motor": "" if profile is None else motor_rating(profile),
        "case" if alone else "cases": case if alone else _case_count(runs),
        "operating point": settings_line(point) if alone and isinstance(point, dict) else "",
        "profile": manifest.profile_name,
        "drive": ", ".join(filter(None, (str(identity.get("device_name", "")), drive_numbers(identity)))),
        "hardware, firmware": ", ".join(
            str(identity[key]) for key in ("hardware_version", "firmware_version") if identity.get(key)
        ),
        "link": link_of(manifest),
        "bench": "" if profile is None else ", ".join(equipment(profile, link_of(manifest))),
        "instruments": "; ".join(
            (*conditions.instruments, *([] if profile is None else _sensors(profile.bench)))
        ),
        "temperature": ", ".join(_temperatures(manifest)),
        "begun": f"{manifest.when}{several}",
        "captured": _captured(capture) if capture is not None and alone else "",
        "operator": conditions.operator or _UNSTATED,
        "note": manifest.note,
    }
    return Facts(tuple((name, what) for name, what in pairs.items() if what))


def _captured(capture: Block) -> str:
    length_s = len(capture.data) * capture.stride * capture.tick_s
    return f"{raw(length_s)} s at {raw(capture.sample_rate_Hz)} Hz"


def fingerprint(bundles: Sequence[Bundle]) -> str:
    """Return SHA-256 of the manifest, which has that of each file; of several bundles, of theirs in order.

    Raises:
        RecordingError: a manifest cannot be read.
    """
    hashes = [hash_of(bundle.directory / MANIFEST).sha256 for bundle in bundles]
    return hashes[0] if len(hashes) == 1 else hashlib.sha256("".join(hashes).encode("ascii")).hexdigest()


def _case_count(runs: Sequence[RecordedRun]) -> str:
    count = sum(len(run.cases) for run in runs)
    names = [run.name for run in runs if run.name]
    return f"{count}" + (f" of the plans {', '.join(names)}" if len(names) > 1 else "")


def motor_rating(profile: Profile) -> str:
    motor = profile.motor
    return (
        f"rated {raw(motor.T_N_Nm)} Nm, {raw(motor.omega_m_N_rad_s)} rad/s, {raw(motor.I_N_A_rms)} A rms, "
        f"{motor.pole_pairs} pole pairs"
    )


def equipment(profile: Profile, link: str) -> Iterator[str]:
    """Yield the kinds of equipment beside the drive; what the profile leaves out is the emulated bench's, or
    not there."""
    emulated = link.startswith("emulated")
    for name in ("load", "transducer", "supply", "temperature"):
        stated = getattr(profile.bench, name)
        kind = stated.kind if stated is not None else "emulated" if emulated else "none stated"
        yield f"{name} {kind}"


def _sensors(bench: Bench) -> Iterator[str]:
    """Yield sensors that the profile states, with their certificates and the day of the next calibration."""
    for channel, sensor in bench.channels.items():
        if sensor.label:
            due = f", calibration due {sensor.due}" if sensor.due else ""
            yield f"{channel}: {sensor.label}{due}"


def _temperatures(manifest: Manifest) -> Iterator[str]:
    stated = manifest.conditions.temperature_degC
    if stated is not None:
        yield f"{raw(stated)} °C stated"
    before = manifest.details.get("equipment", {}).get("before", {})
    for key, what in (("winding_degC", "winding"), ("ambient_degC", "surroundings")):
        if isinstance(before.get(key), float):
            yield f"{what} {raw(before[key])} °C before"


def _warnings(runs: Sequence[RecordedRun], found: Sequence[RecordedCase]) -> Iterator[Item]:
    """Yield what a verdict does not say, of a run of several cases for the worst of these."""
    if len(found) == 1:
        yield from remarks(found[0].assessment) if found[0].assessment else ()
        return
    overdue = dict.fromkeys(late for case in found if case.assessment for late in case.assessment.overdue)
    yield from (Text(f"Overdue: {late}.", "warning") for late in overdue)
    told = [f"{case.name}: {why}" for case in found for why in _reasons(case)]
    told += [
        f"{group} over its repetitions: {each.missed}"
        for run in runs
        for group, each in judged_together(run.repeated)
        if each.missed
    ]
    told += [
        f"{group} over its repetitions: the transducer disagrees: {each.disagreement}"
        for run in runs
        for group, each in run.result.contradicted
        if each.verdict_by_transducer is not each.counted
    ]
    yield from (Text(f"{text}.", "warning") for text in told[:_MOST_TOLD])
    if len(told) > _MOST_TOLD:
        yield Text(f"{len(told) - _MOST_TOLD} more of these stand with their cases.", "warning")
    against = Counter(
        each.name for case in found if case.assessment for each in case.assessment.disagreements
    )
    judged = {each.name for case in found if case.assessment for each in case.assessment.contradicted}
    if against:
        cases_of = ", ".join(f"{name} ({count} of {len(found)} cases)" for name, count in against.items())
        text = f"The transducer disagrees with the drive's own estimate: {cases_of}."
        if judged:
            text += f" By it the verdict on {', '.join(sorted(judged))} would be another."
        yield Text(text, "warning" if judged else "note")


def _reasons(case: RecordedCase) -> tuple[str, ...]:
    """Return the reasons of a case's verdict, and of that by the transducer: its failure, or missed limits
    and by how much."""
    failed = (case.failure,) if case.failure else ()
    if case.assessment is None:
        return failed
    apart = (f"the transducer disagrees: {each}" for each in case.assessment.contradicted)
    return (*failed, *(str(each) for each in case.assessment.missed), *apart)


def _not_run(runs: Sequence[RecordedRun], found: Sequence[RecordedCase]) -> Iterator[Item]:
    """Yield the cases of the plans that have no recording, and what cases could not be measured for."""
    told = [f"{run.name or 'plan'}: {', '.join(run.missing)}" for run in runs if run.missing]
    if told:
        yield Text(f"Cases of the plan without a recording: {'; '.join(told)}.", "warning")
    for text, count in Counter(text for case in found for text in _open(case)).items():
        yield Text(f"{text}{'' if len(found) == 1 else f' ({count} of {len(found)} cases)'}.")
    waived = [row for run in runs for row in _waived(run)]
    if waived:
        yield Grid.of(("waived limit", "case", "why", "by", "what was seen"), waived)
    judged = any(case.assessment and case.assessment.limits for case in found)
    left_out = list(_refused(found))
    if not told and not waived and not any(True for case in found for _ in _open(case)):
        whole = "Every case of the plan was run, and every limit was put to a number."
        if judged or not left_out:
            yield Text(whole if judged else "Nothing was left out.", "note")
    yield from (Text(f"{text}.") for text in left_out)


def _refused(found: Sequence[RecordedCase]) -> Iterator[str]:
    """Yield the analyses that the rows do not allow, each once: with the reason of the first of several
    cases, whose numbers differ, and in how many it is so."""
    reasons: dict[str, list[str]] = {}
    for case in found:
        for title, reason in ({} if case.assessment is None else case.assessment.refused).items():
            reasons.setdefault(title, []).append(reason)
    alike: dict[tuple[str, ...], list[str]] = {}
    for title, told in reasons.items():
        alike.setdefault(tuple(told), []).append(title)
    for of_cases, titles in alike.items():
        more = "" if len(found) == 1 else f" ({len(of_cases)} of {len(found)} cases)"
        yield f"Not measured: {', '.join(titles)}: {of_cases[0]}{more}"


def _waived(run: RecordedRun) -> Iterator[tuple[str, ...]]:
    """Yield a row for each limit of a run that was not met and is waived: by whom, why, and what was seen."""
    cases = (case.assessment for case in run.cases if case.assessment is not None)
    for each in waived_limits(cases, run.repeated):
        yield each.missed.name, each.case, each.consent.reason, each.consent.by, str(each.missed)


def requirements_section(runs: Sequence[RecordedRun]) -> Section | None:
    """Return each requirement that the plans and their limits are evidence for, with its worst verdict; None
    without any."""
    found: dict[str, list[tuple[str, Verdict]]] = {}
    held: list[tuple[str, JudgedLimit]] = []
    for run in runs:
        for case in run.cases:
            result = case.assessment
            for requirement in _required(case):
                found.setdefault(requirement, []).append((case.name, case.verdict))
            held += [] if result is None else [(case.name, each) for each in result.judged.values()]
        together = list(judged_together(run.repeated))
        held += together
        of_plan = {requirement for case in run.cases for requirement in _required(case)}
        evidence = [(f"{group}: {each.name}", each.counted) for group, each in together]
        evidence += [(f"{case}: {each}", Verdict.UNDECIDED) for case, each in run.result.unjudged.items()]
        for requirement in of_plan:
            found[requirement] += evidence
    for place, each in held:
        if each.limit.requirement:
            waived = " (waived)" if each.waived else ""
            one = f"{place}: {each.name}{waived}", each.counted
            found.setdefault(each.limit.requirement, []).append(one)
    if not found:
        return None
    rows = []
    for requirement, evidence in sorted(found.items()):
        verdict = worst(each for _, each in evidence)
        rows.append((requirement, Cell(str(verdict), mark(verdict)), ", ".join(name for name, _ in evidence)))
    return Section("Requirements", (Grid.of(("requirement", "verdict", "evidence"), rows),))


def _required(case: RecordedCase) -> tuple[str, ...]:
    """Return the requirements that the plan of a case is evidence for."""
    return tuple(map(str, case.bundle.manifest.details.get("plan", {}).get("requirements", ())))


def _open(case: RecordedCase) -> Iterator[str]:
    """Yield what a case has no number for; all of it, where it could not be measured."""
    if case.assessment is None:
        yield f"Not measured: {case.failure or 'a recording without a plan'}"
    yield from unmeasured(case)


def _judged_together(runs: Sequence[RecordedRun]) -> Section:
    """Return each limit with the value that meets it worst, over all cases."""
    rows = [row for run in runs for row in _rows_of(run, f"{run.name}: " if len(runs) > 1 else "")]
    headings = (
        "measurement",
        "limit",
        "decision rule",
        ">worst value ± U (95 %)",
        "in case",
        ">margin left",
        "verdicts",
    )
    if not rows:
        return Section("Limits and verdicts", (Text("The plan sets no limits.", "note"),))
    return Section("Limits and verdicts", (Grid.of(headings, rows),))


def _rows_of(run: RecordedRun, prefix: str) -> Iterator[tuple[str | Cell, ...]]:
    by_rule: dict[tuple[str, str], list[tuple[str, JudgedLimit]]] = {}
    for case in run.cases:
        if case.assessment is not None:
            for name, one in case.assessment.judged.items():
                by_rule.setdefault((name, one.limit.rule), []).append((case.assessment.case, one))
    for found in by_rule.values():
        case_name, nearest = max(found, key=_badness)
        bounds = {bounds_of(each.limit) for _, each in found}
        limit = bounds_of(nearest.limit) if len(bounds) == 1 else f"{bounds_of(nearest.limit)}, and others"
        verdict = worst(each.verdict for _, each in found)
        count = Counter(str(each.verdict) for _, each in found)
        text = ", ".join(f"{number_of} {verdict_of}" for verdict_of, number_of in count.items())
        yield _row_of(prefix, case_name, nearest, limit, Cell(text, mark(verdict)))
    for group, each in judged_together(run.repeated):
        what = "" if each.measured is None else f" ({each.measured.definition})"
        yield _row_of(prefix, group, each, f"{bounds_of(each.limit)}{what}", verdict_cell(each))


def _row_of(
    prefix: str, place: str, judged: JudgedLimit, limit: str, verdict: Cell
) -> tuple[str | Cell, ...]:
    unit = "" if judged.measured is None else judged.measured.unit
    left = with_unit(judged.headroom_text, unit) if math.isfinite(judged.headroom) else NOTHING
    value = with_unit(judged_value(judged.measured), unit)
    return f"{prefix}{judged.name}", limit, judged.limit.rule, value, place, left, verdict


def _badness(found: tuple[str, JudgedLimit]) -> tuple[int, float]:
    """Return the verdict, then how little room is left; least where that is not known."""
    _, judged = found
    room = -math.inf if math.isnan(judged.headroom) else judged.headroom
    return list(Verdict).index(judged.verdict), -room
