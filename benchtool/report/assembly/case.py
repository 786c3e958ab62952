"""One recorded case in a report: results, figures and provenance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from benchtool.analysis import count_of, measurements_from_json, raw
from benchtool.errors import BenchError
from benchtool.profile import Choice, Profile
from benchtool.protocol.dictionary import Dictionary, toml_key
from benchtool.recording import Bundle, Manifest
from benchtool.report import content
from benchtool.report.assembly.figures import case_figures, panel_of
from benchtool.report.assembly.pictures import picture
from benchtool.report.assembly.recording import plan_of, recording_items
from benchtool.report.content import Item, Picture, Section, Text
from benchtool.report.figures.drawings import figure_names
from benchtool.report.figures.overview import draw_channels
from benchtool.report.provenance import (
    choices_section,
    events_section,
    parameters_section,
    plan_section,
    profile_of,
    quality_section,
    run_facts,
)
from benchtool.report.results import (
    budgets_section,
    limits_section,
    measurements_section,
    tables_section,
)
from benchtool.results import Assessment, RecordedCase
from benchtool.shipped import shipped


def case_items(case: RecordedCase, *, alone: bool = True, brief: bool = False) -> Iterator[Item]:
    """Yield what one case shows and measured; with its limits and remarks, unless it stands `alone` and the
    first page has these. A `brief` one has the first of its figures and no tables, which lie in its
    bundle."""
    result = case.assessment
    limits = {} if result is None else result.judged
    if result is not None and not alone:
        if result.recorded is None:  # a recording has no plan that could set any
            yield limits_section(limits.values())
        yield from remarks(result)
        yield from (Text(f"{text}.", "note") for text in (*unmeasured(case), *refused(case)))
        yield from recording_items(result)
    if figures := _figures(case, 1 if brief else None):
        yield Section("Figures", tuple(figures))
    if result is not None:
        yield measurements_section("Measurements", result.measurements, limits, result.published)
        yield from (Text(f"{text[0].upper()}{text[1:]}.", "note") for text in result.of_sensors)
        if alone:
            yield from (Text(f"{text}.", "note") for text in refused(case))
        if not brief and (tables := tables_section(result.tables)) is not None:
            yield tables
    elif case.error is None and case.bundle.measurements:  # of a table of another tool
        yield measurements_section("Measurements", measurements_from_json(case.bundle.measurements), {}, {})


def case_appendix(case: RecordedCase, *, alone: bool = True, brief: bool = False) -> Iterator[Item]:
    """Yield what is looked up: quality of the data, budgets of uncertainty, events, every channel; with the
    drive, the plan and the profile, if the case stands `alone`."""
    limits = {} if case.assessment is None else case.assessment.judged
    yield quality_section(case.bundle, limits)
    if brief:
        return
    measured = () if case.assessment is None else case.assessment.measurements
    if (budgets := budgets_section(measured)) is not None:
        yield budgets
    if alone:
        yield from circumstances(case.bundle)
    if (events := events_section(case.bundle.events)) is not None:
        yield events
    if case.assessment is not None and figure_names(panel_of(case.assessment)):
        channels = tuple(_every_channel(case))
        yield Section("Every channel", channels, paper=False)


def remarks(result: Assessment) -> Iterator[Item]:
    """Yield what a verdict does not say: limits missed, by how much; where the shaft does not agree; where
    the drive contradicts the profile."""
    for late in result.overdue:
        yield Text(f"Overdue: {late}.", "warning")
    for odd in result.remarks:
        yield Text(f"{odd[0].upper()}{odd[1:]}.", "warning")
    for missed in result.missed:
        yield Text(f"{str(missed.verdict).capitalize()}: {missed}.", "warning")
    apart = result.contradicted
    for each in apart:
        yield Text(f"The transducer disagrees: {each}.", "warning")
    if others := [each for each in result.disagreements if each not in apart]:
        yield Text(
            f"The transducer disagrees with the drive's own estimate, without another verdict: "
            f"{', '.join(f'{each.name}{each.band_text}' for each in others)}.",
            "note",
        )
    for kind, other in (("contradicted", "profile"), ("unstated", "default")):
        for key, values in result.parameter_check.get(kind, {}).items():
            yield Text(
                f"The drive held {key} = {raw(values['drive'])}, the {other} is {raw(values[other])}.",
                "warning" if kind == "contradicted" else "note",
            )


def unmeasured(case: RecordedCase) -> Iterator[str]:
    """Yield what a case has no number for, and why; a sentence each without its full stop."""
    result = case.assessment
    if result is None:
        return
    if result.refusal:
        yield f"Nothing but the operating point was measured: {result.refusal}"
    for title, channels in result.without.items():
        yield f"Not measured for lack of channels: {title} ({', '.join(channels)})"
    for name in result.limits:
        if name not in result.found:
            yield f"Not measured though it has a limit: {name}"


def refused(case: RecordedCase) -> Iterator[str]:
    """Yield the analyses that the rows of a case do not allow, and why; a sentence each without its full
    stop."""
    for reason, titles in ({} if case.assessment is None else case.assessment.refusals).items():
        yield f"Not measured: {', '.join(titles)}: {reason}"


def failure(case: RecordedCase) -> Iterator[Item]:
    """Yield the reason if a case was not measured completely."""
    if case.failure and case.bundle.complete:
        yield Text(f"This recording could not be measured: {case.failure}", "warning")
    elif case.failure:
        yield Text(
            f"This case was cut short: {case.failure}. The data below were recorded until then.", "warning"
        )
    elif case.assessment is None and not case.bundle.measurements:
        yield Text("A recording without a plan: nothing is measured or judged.", "note")


def case_facts(case: RecordedCase) -> content.Facts:
    """Return facts of the run: what, when, with what, and how much was recorded."""
    facts = run_facts(case.bundle.manifest)
    streams = [
        f"{name} {count_of(info.rows, 'row')}"
        + (f", {info.missing_rows} missing" if info.missing_rows else "")
        for name, info in case.bundle.manifest.streams.items()
    ]
    if case.assessment is not None:
        capture = case.assessment.capture
        length_s = len(capture.data) * capture.stride * capture.tick_s
        streams.append(f"captured {raw(length_s)} s at {raw(capture.sample_rate_Hz)} Hz")
    recorded = (("recorded", "; ".join(streams)),) if streams else ()
    return content.Facts((("case", case.name), *coordinates(case), *facts.pairs, *recorded))


def coordinates(case: RecordedCase) -> Iterator[tuple[str, str]]:
    """Yield the variant, point of the sweep and repetition, as far as the plan has any."""
    if case.assessment is None:
        return
    at = case.assessment.coordinates
    if at.variant:
        yield "variant", at.variant
    yield from ((key, raw(value)) for key, value in at.point.items())
    plan = plan_of(case.bundle)
    if plan is not None and plan.repetitions > 1:
        yield "repetition", f"{at.repetition} of {plan.repetitions}"


def circumstances(bundle: Bundle) -> Iterator[Item]:
    """Yield the drive's parameters, the plan and the choices of the profile, as a bundle carries them."""
    manifest = bundle.manifest
    profile = profile_of(manifest)
    yield parameters_section(manifest.parameters, _described(manifest, profile))
    if "plan" in manifest.details:
        yield plan_section(manifest.details["plan"])
    choices: Sequence[Choice] = () if profile is None else profile.choices
    if (section := choices_section(choices)) is not None:
        yield section


def _figures(case: RecordedCase, most: int | None) -> list[Item]:
    """Return the figures of the analyses, or the first few; without any, every recorded channel."""
    if case.assessment is None or not figure_names(panel_of(case.assessment)):
        return list(_every_channel(case))
    return [picture(name, figure) for name, figure in case_figures(case, most).items()]


def _every_channel(case: RecordedCase) -> Iterator[Item]:
    """Yield every channel of the capture or, without one, of the first stream, as far as that can be read."""
    result = case.assessment
    stream = next(iter(case.bundle.streams), None) if result is None else result.stream
    try:
        block = result.capture if result is not None else case.bundle.block(stream) if stream else None
    except BenchError as unreadable:
        yield Text(f"Stream {stream} cannot be read: {unreadable}", "warning")
        return
    if block is None or not len(block.data):
        return
    figure = draw_channels(block, f"{case.name}: every channel of stream {stream}")
    part = "its whole length" if result is None or result.recorded is None else "the rows measured"
    caption = (
        f"Every channel of stream {stream} over {part}, {count_of(len(block.data), 'row')} at "
        f"{raw(block.sample_rate_Hz)} Hz. Long traces are drawn by the least and the greatest value of each "
        f"stretch, so that no peak is lost; a gap in a line is a gap in the data."
    )
    yield Picture(figure, caption, content.describe_figure(figure))


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
