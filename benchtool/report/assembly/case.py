"""One recorded case in a report: what it measured and shows, and the circumstances it was recorded in."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence

from pydantic import ValidationError

from benchtool.analysis import measurements_from_json
from benchtool.errors import BenchError
from benchtool.plan.model import Plan
from benchtool.profile import Choice, Profile
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.keys import toml_key
from benchtool.recording import Bundle, Manifest
from benchtool.report import content
from benchtool.report.assembly.figures import case_figures
from benchtool.report.assembly.marks import mark, picture
from benchtool.report.content import Item, Picture, Section, Text
from benchtool.report.figures.overview import draw_channels
from benchtool.report.numbers import number, raw, with_expanded
from benchtool.report.origin import (
    choices_section,
    events_section,
    parameters_section,
    plan_section,
    quality_section,
    run_facts,
)
from benchtool.report.results import Bounds, limits_section, measurements_section, tables_section
from benchtool.results.assessment import Assessment
from benchtool.results.runs import RecordedCase
from benchtool.shipped import shipped


def case_items(case: RecordedCase, *, alone: bool = True) -> Iterator[Item]:
    """What one case measured and shows; with the drive, the plan and the profile, if it stands `alone`."""
    result = case.assessment
    limits: dict[str, Bounds] = {}
    if result is not None:
        limits = {
            name: Bounds(
                limit.min, limit.max, limit.rule, mark(result.verdicts[name]), result.conformances.get(name)
            )
            for name, limit in result.limits.items()
        }
        yield limits_section((*result.measurements, *result.quality), limits)
        yield from remarks(result)
        yield measurements_section("Measurements", result.measurements, limits, result.published)
        yield from (Text(f"{text[0].upper()}{text[1:]}.", "note") for text in result.of_sensors)
        if (tables := tables_section(result.tables)) is not None:
            yield tables
    elif case.error is None and case.bundle.measurements:  # of a table of another tool
        yield measurements_section("Measurements", measurements_from_json(case.bundle.measurements), {}, {})
    if figures := _figures(case):
        yield Section("Figures", tuple(figures))
    if (events := events_section(case.bundle.events)) is not None:
        yield events
    yield quality_section(case.bundle, limits)
    if alone:
        yield from circumstances(case.bundle)


def remarks(result: Assessment) -> Iterator[Item]:
    """What a verdict does not say: limits missed, by how much; where the shaft does not agree; what is not
    measured; where the drive contradicts the profile."""
    for late in result.overdue:
        yield Text(f"Overdue: {late}.", "warning")
    for missed in result.missed:
        yield Text(f"{str(missed.verdict).capitalize()}: {missed}.", "warning")
    for each in result.disagreements:
        verdict = f": {each.verdict} there" if each.verdict is not None else ""
        own, true = (with_expanded(one.value, one.uncertainty) for one in (each.estimate, each.true))
        yield Text(
            f"The transducer disagrees: {each.name} is {own} {each.estimate.unit} by the drive's own "
            f"estimate, {true} {each.true.unit} on the shaft{verdict}.",
            "note" if each.verdict is None or each.verdict is result.verdicts.get(each.name) else "warning",
        )
    if result.refusal:
        yield Text(f"Nothing else was measured: {result.refusal}.", "warning")
    if result.without:
        lacking = (f"{title} ({', '.join(channels)})" for title, channels in result.without.items())
        yield Text(f"Not measured for want of channels: {', '.join(lacking)}.", "note")
    for kind, other in (("contradicted", "profile"), ("unstated", "default")):
        for key, values in result.parameter_check.get(kind, {}).items():
            yield Text(
                f"The drive held {key} = {raw(values['drive'])}, the {other} is {raw(values[other])}.",
                "warning" if kind == "contradicted" else "note",
            )


def failure(case: RecordedCase) -> Iterator[Item]:
    """Why a case was not measured, or not to its end, where that is so."""
    if case.failure and case.bundle.complete:
        yield Text(f"This recording could not be measured: {case.failure}", "warning")
    elif case.failure:
        yield Text(
            f"This case did not come to its end: {case.failure}. What follows came till then.", "warning"
        )
    elif case.assessment is None and not case.bundle.measurements:
        yield Text("A recording without a plan: nothing is measured or judged.", "note")


def case_facts(case: RecordedCase) -> content.Facts:
    """What was run, when and with what, and how much was recorded."""
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
    return content.Facts((("case", case.name), *_coordinates(case), *facts.pairs, *recorded))


def _coordinates(case: RecordedCase) -> Iterator[tuple[str, str]]:
    """Variant, point of the sweep and repetition, as far as the plan has any."""
    if case.assessment is None:
        return
    at = case.assessment.coordinates
    if at.variant:
        yield "variant", at.variant
    yield from ((key, raw(value)) for key, value in at.point.items())
    repetitions = Plan.model_validate(case.bundle.manifest.details["plan"]).repetitions
    if repetitions > 1:
        yield "repetition", f"{at.repetition} of {repetitions}"


def circumstances(bundle: Bundle) -> Iterator[Item]:
    """The drive's parameters, the plan and the choices of the profile, as a bundle carries them."""
    manifest = bundle.manifest
    profile = _profile(manifest)
    yield parameters_section(manifest.parameters, _described(manifest, profile))
    if "plan" in manifest.details:
        yield plan_section(manifest.details["plan"])
    choices: Sequence[Choice] = () if profile is None else profile.choices
    if (section := choices_section(choices)) is not None:
        yield section


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


def _profile(manifest: Manifest) -> Profile | None:
    """The profile that the bundle carries; None if this version does not understand it."""
    try:
        return Profile.model_validate(tomllib.loads(manifest.profile_toml))
    except (tomllib.TOMLDecodeError, RecursionError, ValidationError):
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
