"""The report of an acceptance session; its first page is what is signed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from benchtool.analysis import NOTHING, count_of, number, raw
from benchtool.errors import RecordingError
from benchtool.plan import Verdict
from benchtool.profile import Profile
from benchtool.recording import SESSION, hash_of, reading
from benchtool.report import content
from benchtool.report.assembly.front import ROLES, equipment, motor_rating
from benchtool.report.content import Cell, Facts, Grid, Item, Mark, Picture, Report, Section, Signatures, Text
from benchtool.report.figures.session import figure_of_png
from benchtool.report.figures.trend import Point, Trend, draw_trend
from benchtool.report.provenance import drive_numbers, profile_of_text
from benchtool.report.results import bounds_of, conformance_of, judged_value, mark
from benchtool.results import Judged, Outcome, SessionRecord, SuiteScore, TestRecord, values_of

_UNSTATED: Final = "not stated"
_MARKS: Final[dict[Outcome, Mark]] = {
    Outcome.PASSED: "pass",
    Outcome.WAIVED: "marginal",
    Outcome.NOT_RUN: "none",
    Outcome.FAILED: "fail",
    Outcome.ERROR: "fail",
}
_DRAWN: Final = 3
_FEWEST: Final = 2  # earlier sessions of a trend


def session_report(folder: Path, record: SessionRecord, earlier: Sequence[SessionRecord] = ()) -> Report:
    """Return the report of the session in a folder, set against earlier ones of the same drive.

    Raises:
        RecordingError: its record or a picture cannot be read.
    """
    profile = profile_of_text(record.profile_toml)
    return Report(
        f"Acceptance of {_object(record)}",
        f"Acceptance report · {record.when} · profile {record.profile_name}",
        record.when,
        (
            Section("Tests", (_tests(record),), listed=True),
            *_trend_items(record, earlier),
            *(_test_section(folder, each) for each in record.tests),
        ),
        front=tuple(_front(record, profile)),
        appendix=tuple(_appendix(folder, record)),
        fingerprint=hash_of(folder / SESSION).sha256,
    )


def _object(record: SessionRecord) -> str:
    serial = record.conditions.test_object_serial_number
    name = str(record.identity.get("device_name", "a drive"))
    return f"{name}, motor {serial}" if serial else name


# ---- the first page --------------------------------------------------------------------------------------


def _front(record: SessionRecord, profile: Profile | None) -> Iterator[Item]:
    yield _banner(record)
    if record.interrupted:
        yield Text(f"{record.interrupted[0].upper()}{record.interrupted[1:]}: tests are missing.", "warning")
    yield Section("What was tested", (_tested(record, profile),))
    if record.requirements:
        yield Section("Requirements", (_requirements(record),))
    yield Section("Waived and not run", tuple(_left_out(record)))
    yield Section("Decision rule", tuple(Text(each) for each in _rules(record)))
    yield Signatures(ROLES)


def _banner(record: SessionRecord) -> content.Verdict:
    verdict = record.verdict
    sign = mark(verdict)
    told = ", ".join(f"{count} {outcome}" for outcome, count in record.counts.items() if count)
    limits = [each for test in record.tests for each in test.judged]
    met = sum(Verdict(each.verdict).met for each in limits)
    word = "Pass" if verdict is Verdict.PASS else str(verdict).capitalize()
    summary = f"{count_of(len(record.tests), 'test')}: {told}; {met} of {count_of(len(limits), 'limit')} met."
    return content.Verdict(sign, f"{content.SYMBOLS[sign]} {word}", summary)


def _tested(record: SessionRecord, profile: Profile | None) -> Facts:
    identity, conditions = record.identity, record.conditions
    pairs = {
        "test object": f"serial number {conditions.test_object_serial_number or _UNSTATED}",
        "motor": "" if profile is None else motor_rating(profile),
        "profile": record.profile_name,
        "drive": ", ".join(filter(None, (str(identity.get("device_name", "")), drive_numbers(identity)))),
        "hardware, firmware": ", ".join(
            str(identity[key]) for key in ("hardware_version", "firmware_version") if identity.get(key)
        ),
        "link": record.link,
        "altered": ", ".join(f"{key} = {raw(value)}" for key, value in record.emulator.items()),
        "bench": "" if profile is None else ", ".join(equipment(profile, record.link)),
        "sensors": "; ".join(record.sensors) or "calibration not stated",
        "instruments": "; ".join(conditions.instruments),
        "temperature": ""
        if conditions.temperature_degC is None
        else f"{raw(conditions.temperature_degC)} °C stated",
        "begun": record.when,
        "operator": conditions.operator or _UNSTATED,
        "software": ", ".join(
            f"{name} {record.versions[name]}" for name in ("benchtool", "commit") if name in record.versions
        ),
        "suite": f"{record.suite}{_scored(record)}",
    }
    return Facts(tuple((name, what) for name, what in pairs.items() if what))


def _scored(record: SessionRecord) -> str:
    """Return how well the suite finds faults, as it was measured."""
    score = record.score
    if score is None:
        return ", not tried on mutants"
    other = "" if score.of == record.suite else f" (measured with suite {score.of})"
    return f", finds {score.caught} of {score.mutants} mutants, {_false(score)}{other}"


def _false(score: SuiteScore) -> str:
    return f"{score.false_failures} of {score.clean_runs} runs of a sound drive failed"


def _requirements(record: SessionRecord) -> Grid:
    outcomes: dict[str, list[Outcome]] = {}
    for test in record.tests:
        for each in test.requirements:
            outcomes.setdefault(each, []).append(test.outcome)
    rows = [
        (
            name,
            Cell(str(outcome), _MARKS[outcome]),
            f"{outcomes[name].count(Outcome.PASSED)} of {len(outcomes[name])}",
        )
        for name, outcome in record.requirements.items()
    ]
    return Grid.of(("requirement", "outcome", ">tests passed"), rows)


def _tests(record: SessionRecord) -> Grid:
    rows = []
    for test in record.tests:
        met = sum(Verdict(each.verdict).met for each in test.judged)
        limits = f"{met} of {len(test.judged)}" if test.judged else NOTHING
        evidence = ", ".join(test.requirements) or NOTHING
        rows.append((test.name, test.title, evidence, Cell(str(test.outcome), _MARKS[test.outcome]), limits))
    return Grid.of(("test", "what it asks", "requirements", "outcome", ">limits met"), rows)


def _left_out(record: SessionRecord) -> Iterator[Item]:
    waived = [test for test in record.tests if test.outcome is Outcome.WAIVED]
    rows = [
        (
            test.name,
            test.waiver.reason,
            test.waiver.by,
            test.waiver.until or "no day stated",
            "; ".join(each.complaint for each in test.judged if each.complaint) or test.reason,
        )
        for test in waived
        if test.waiver is not None
    ]
    if rows:
        yield Grid.of(("waived test", "why", "by", "until", "what was seen"), rows)
    for test in record.tests:
        if test.waiver is not None and test.outcome is Outcome.PASSED:
            yield Text(f"{test.name} has a waiver and passes: the waiver is not needed any more.", "note")
    missing = [(test.name, test.reason) for test in record.tests if test.outcome is Outcome.NOT_RUN]
    if missing:
        yield Grid.of(("test not run", "why"), missing)
    if not rows and not missing:
        yield Text("Every test was run, and none was waived.", "note")


def _rules(record: SessionRecord) -> Iterator[str]:
    """Yield the decision rules of the limits, and how often each was applied."""
    rules: dict[str, int] = {}
    for test in record.tests:
        for each in test.judged:
            rules[each.limit.rule] = rules.get(each.limit.rule, 0) + 1
    for rule, count in rules.items():
        yield f"{rule[0].upper()}{rule[1:]}: {count_of(count, 'limit')}."
    yield "What was not measured, or is no number, fails (JCGM 106:2012 for the rules)."


# ---- trend -----------------------------------------------------------------------------------------------


def _trend_items(record: SessionRecord, earlier: Sequence[SessionRecord]) -> Iterator[Item]:
    if len(earlier) < _FEWEST:
        told = f"{len(earlier)} earlier sessions of this drive lie beside this one; a trend needs {_FEWEST}."
        yield Section("Trend", (Text(told, "note"),), listed=True, short=True)
        return
    changes = sorted(_changes(record, earlier), key=lambda each: -each[0])
    rows = [row for _, row, _ in changes]
    headings = ("test", "measurement", ">mean before", ">least", ">greatest", ">now", "unit", ">of the limit")
    caption = (
        f"Against the last {len(earlier)} sessions, from {earlier[0].when} on. The last column is the change "
        f"against the mean, in parts of the room that the mean left to the limit."
    )
    figures = [draw for _, _, draw in changes[:_DRAWN]]
    items: list[Item] = [Grid.of(headings, rows, caption, shown=12)]
    for trend in figures:
        figure = draw_trend(trend, f"{trend.measurement} over the sessions")
        items.append(
            Picture(figure, "Sessions in their order, this one last.", content.describe_figure(figure))
        )
    yield Section("Trend", tuple(items), listed=True)


def _changes(
    record: SessionRecord, earlier: Sequence[SessionRecord]
) -> Iterator[tuple[float, tuple[str, ...], Trend]]:
    """Yield for each limit how much of its room has gone, a row of the table, and its trend."""
    for test in record.tests:
        for now in test.judged:
            before = values_of(earlier, test.name, now.name)
            known = [each for each in before if each is not None]
            if now.value is None or len(known) < _FEWEST:
                continue
            mean = sum(known) / len(known)
            room = now.limit.headroom(mean)
            share = (room - now.limit.headroom(now.value)) / room if room > 0.0 else math.inf
            row = (
                *(test.name, now.name, number(mean), number(min(known)), number(max(known))),
                *(number(now.value), now.unit, f"{share:+.1%}" if math.isfinite(share) else NOTHING),
            )
            yield share, row, _trend(now, before)


def _trend(now: Judged, before: Sequence[float | None]) -> Trend:
    values = [*before, now.value]
    points = tuple(
        Point(float(place), value, math.nan, (), now.limit.min, now.limit.max)
        for place, value in enumerate(values, start=1)
        if value is not None
    )
    return Trend(now.name, now.unit, "", {"sessions": points})


# ---- tests -----------------------------------------------------------------------------------------------


def _test_section(folder: Path, test: TestRecord) -> Section:
    items: list[Item] = [Text(f"{test.title}." if test.title else test.name)]
    verdict = Cell(str(test.outcome), _MARKS[test.outcome])
    items.append(
        Grid.of(
            ("outcome", "requirements", ">time in s"),
            [(verdict, ", ".join(test.requirements) or NOTHING, f"{test.duration_s:.2f}")],
        )
    )
    if test.outcome is not Outcome.PASSED and test.reason:
        items.append(Text(test.reason, "warning" if test.outcome is not Outcome.NOT_RUN else "note"))
    items += [Text(f"{line[0].upper()}{line[1:]}.", "note") for line in test.notes if line]
    if test.judged:
        items.append(_judged_grid(test.judged))
    others = []
    for each in test.attachments:
        path = folder / each.path
        if path.suffix == ".png" and path.is_file():
            with reading(path):
                figure = figure_of_png(path.read_bytes())
            items.append(Picture(figure, each.name, each.name))
        else:
            others.append(each)
    if others:
        items.append(Grid.of(("attached", "file"), [(each.name, each.path) for each in others]))
    return Section(test.name, tuple(items), listed=True, folded=test.outcome is Outcome.PASSED, short=True)


def _judged_grid(judged: Sequence[Judged]) -> Grid:
    headings = (
        *(
            "measurement",
            ">value ± U (95 %)",
            "unit",
            "limit",
            "decision rule",
            ">probability of conformance",
        ),
        "verdict",
    )
    return Grid.of(headings, [_judged_row(each) for each in judged], shown=24)


def _judged_row(each: Judged) -> tuple[str | Cell, ...]:
    measured = each.held.measured
    is_told = measured is not None and measured.is_told
    value = judged_value(measured) if is_told else each.reason or "not measured"
    verdict = Verdict(each.verdict)
    return (
        *(each.name, value, each.unit, bounds_of(each.limit), each.limit.rule),
        conformance_of(each.held),
        Cell(str(verdict), mark(verdict)),
    )


def _appendix(folder: Path, record: SessionRecord) -> Iterator[Item]:
    if (score := record.score) is not None:
        told = [
            f"Tried on {score.mutants} mutants of drive and bench, of which it found {score.caught}; "
            f"{_false(score)} ({', '.join(score.profiles)}; {score.when}).",
            *(f"Not found: {each}." for each in score.missed),
        ]
        yield Section("How well these tests find faults", tuple(Text(each) for each in told))
    versions = Facts(tuple(record.versions.items()))
    yield Section("Software", (versions, Text(f"pytest {' '.join(record.command_line)}", "code")))
    try:
        lines = [
            (each.path, hash_of(folder / each.path).sha256)
            for test in record.tests
            for each in test.attachments
            if (folder / each.path).is_file()
        ]
    except RecordingError as unreadable:
        yield Text(str(unreadable), "warning")
        return
    yield Section(
        "How to verify this",
        (Text(f"benchtool verify {folder.name}", "code"), Grid.of(("file", "SHA-256"), lines, shown=12)),
        paper=False,
    )
