"""Validation of a plan against profile, dictionary and bench, before anything is opened or sent."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterator, Mapping
from datetime import date
from pathlib import Path
from typing import Any, Final

from benchtool.analysis import PLAYED
from benchtool.analysis.responses import FREQUENCY_RESPONSE
from benchtool.document import by_line, closest, line_of
from benchtool.errors import PlanError, ProfileError, ValueRefused
from benchtool.misfits import Path_
from benchtool.plan.analyses import spelled
from benchtool.plan.cases import Case, cases
from benchtool.plan.model import Plan, Setting
from benchtool.plan.name_check import NameCheck
from benchtool.plan.rating import beyond_rating, speed_rad_s
from benchtool.plan.source import Source
from benchtool.profile import Profile, altered
from benchtool.protocol import MOST_VALUES
from benchtool.protocol.dictionary import Dictionary, sensed_units, setting_of

_FEWEST_PERIODS = 2
_ROWS_AT_THE_ENDS = 63  # of a current, which only feed the interpolation
_PERIODIC: Final = frozenset({"i_a", "theta_m", "psi_alpha", "psi_beta"})
_LONGEST_NAME = 200
_TAKEN: Final = frozenset({"plots", "data"})

Faults = Iterator[tuple[Path_, str]]


def require_known(
    plan: Plan,
    path: Path | None,
    profile: Profile,
    dictionary: Dictionary,
    *,
    transducer: bool,
    profile_file: Path | None = None,
) -> None:
    """Check all names and values of a plan.

    Args:
        plan: as it was read.
        path: of its file, for messages; None of a plan that was made in Python.
        profile: of the motor and the bench that it will run on.
        dictionary: of the drive.
        transducer: whether that bench has a torque transducer.
        profile_file: of the profile, for messages; without it they have the profile's title.

    Raises:
        ProfileError: the profile sets an unknown parameter or an invalid value, or states a sensor of an
            unknown channel.
        PlanError: something is unknown, out of its limits or cannot be measured; the message names file, line
            and key of each such thing, a line for each.
    """
    text = "" if profile_file is None else profile_file.read_text(encoding="utf-8")
    stated = f"profile '{profile.title}'" if profile_file is None else str(profile_file)
    wrong = [
        f"{stated}{line_of(text, location)}, [{'.'.join(map(str, location[:-1]))}]: {reason}"
        for location, reason in by_line(text, _profile_faults(profile, dictionary))
    ]
    if wrong:
        raise ProfileError.of_all(wrong)
    source = Source.of(plan, path)
    found = by_line(source.text, faults_of(plan, source, profile, dictionary, transducer=transducer))
    if reasons := dict.fromkeys(f"{source.place(location)}: {reason}" for location, reason in found):
        raise PlanError.of_all(list(reasons))


def faults_of(
    plan: Plan,
    source: Source,
    profile: Profile,
    dictionary: Dictionary,
    *,
    transducer: bool,
    left_out: Collection[Path_] = (),
) -> Faults:
    """Yield each name and value of a plan that is unknown, out of its limits or cannot be measured: where,
    and why.

    Args: as `require_known`; `source` is where the plan comes from, and `left_out` are the places where
        something else is wrong, for which the plan has other values.
    """
    stream = "stream_sequence" in dictionary
    units = {variable.name: variable.unit for variable in dictionary if variable.role == "signal"}
    units.pop(PLAYED, None)  # has the unit of the quantity that plays
    if plan.stimulus is not None:
        units[PLAYED] = plan.stimulus.unit
    channels = plan.record.channels
    if {("record",), ("record", "channels")} & set(left_out):
        channels = (*units, PLAYED)  # what is recorded is not known, so that nothing lacks a channel
    naming = NameCheck(plan, profile.motor, transducer, stream, frozenset(channels), units)
    yield from itertools.chain(
        _setting_faults(plan, dictionary),
        _channel_faults(plan, dictionary),
        _case_faults(plan),
        _bench_faults(plan, profile),
        _rating_faults(plan, profile),
        _record_faults(plan, profile, dictionary),
        _window_faults(plan, profile, dictionary),
        _as_written(naming.faults(), source.document),
    )


def _profile_faults(profile: Profile, dictionary: Dictionary) -> Faults:
    """Yield the parameters and sensors that a profile states and that cannot be: where, and why."""
    for key, value in profile.drive.parameters.items():
        try:
            setting_of(dictionary, key, value)
        except ValueRefused as refused:
            yield ("drive", "parameters", key), str(refused)
    for name, reason in _sensor_faults(profile, dictionary):
        yield ("bench", "channels", name), reason
    clock = {} if profile.bench.clock is None else {"clock": profile.bench.clock}
    today = date.today()
    for location, instrument in (
        *((("channels", name), sensor) for name, sensor in profile.bench.channels.items()),
        *(((name,), one) for name, one in clock.items()),
    ):
        if instrument.calibrated is not None and instrument.calibrated > today:
            why = f"calibrated on {instrument.calibrated}, and today is {today}: state the day when it was"
            yield ("bench", *location, "calibrated"), why


def _sensor_faults(profile: Profile, dictionary: Dictionary) -> Iterator[tuple[str, str]]:
    """Yield the sensors of unknown channels, and errors stated in a wrong unit."""
    units = sensed_units(dictionary)
    for name, sensor in profile.bench.channels.items():
        if name not in units:
            yield name, f"no channel '{name}' of drive or torque transducer: {closest(name, list(units))}"
        elif reason := sensor.misfit(units[name]):
            yield name, f"'{name}' {reason}"


def _as_written(faults: Faults, document: Mapping[str, Any]) -> Faults:
    """Yield the faults of names by the keys as written, with units and in older forms."""
    for location, reason in faults:
        match location:
            case ("analyses", str(analysis), str(key)):
                place, called = spelled(document.get("analyses", {}), analysis, key)
                yield place, f"{called} {reason}"
            case (*tables, str(name)):
                table: Any = document
                for each in tables:
                    table = table.get(each, {}) if isinstance(table, Mapping) else {}
                with_unit = (key for key in table if key.startswith(f"{name}_")) if name not in table else ()
                yield (*tables, next(iter(with_unit), name)), reason
            case _:
                yield location, reason


def _setting_faults(plan: Plan, dictionary: Dictionary) -> Faults:
    """Yield the unknown parameters and invalid values."""
    for location, key, value in _settings(plan):
        try:
            variable = setting_of(dictionary, key, value)
        except ValueRefused as refused:
            yield location, str(refused)
            continue
        if variable.role in ("signal", "command") or not variable.writable:
            yield location, f"'{key}' is not a parameter to set up: see 'benchtool params list'"


def _channel_faults(plan: Plan, dictionary: Dictionary) -> Faults:
    """Yield the unknown signals."""
    known = [variable.name for variable in dictionary if variable.role == "signal"]
    for channel in plan.record.channels:
        if channel not in known:
            yield ("record", "channels"), f"no signal '{channel}' to capture: {closest(channel, known)}"


def _case_faults(plan: Plan) -> Faults:
    """Yield the cases that would share a name or a folder, and names that are invalid for a folder."""
    todo = cases(plan)
    if len(todo) == 1:
        return  # its folder is that of the run
    seen: dict[str, str] = {}
    for case in todo:
        place = _stated_at(plan, case)
        folder = case.folder.casefold()
        if folder in seen:
            other = f"'{seen[folder]}'" if seen[folder] != case.name else "another"
            yield (
                place,
                f"case '{case.name}' would share its folder with {other}: rename a variant or a value",
            )
        seen[folder] = case.name
        if not folder.strip(".") or folder.startswith(".") or folder in _TAKEN:
            yield place, f"case '{case.name}' would have the folder '{case.folder}': give it another name"
        if len(folder.encode()) > _LONGEST_NAME:
            yield place, f"case '{case.name[:40]}...' has {len(folder)} characters: give it a shorter name"


def _stated_at(plan: Plan, case: Case) -> Path_:
    """Return the key that determines the name of a case, if it is unique."""
    for number, variant in enumerate(plan.variants):
        if variant.name and case.variant == variant.name:
            return "variants", number, "name"
    if plan.sweep.setup or plan.sweep.emulator or plan.sweep.operating_point:
        return ("sweep",)
    return ("case",) if plan.case else ("setup", "law")


def _bench_faults(plan: Plan, profile: Profile) -> Faults:
    """Yield the invalid alterations of the emulated bench."""
    sections: list[tuple[Path_, dict[str, float]]] = [(("emulator",), plan.emulator)]
    sections += [
        (("variants", number, "emulator"), variant.emulator) for number, variant in enumerate(plan.variants)
    ]
    sections += [
        (("sweep", "emulator"), {key: value})
        for key, values in plan.sweep.emulator.items()
        for value in values
    ]
    for location, alterations in sections:
        for key, value in alterations.items():
            try:
                altered(profile, {key: value})
            except ProfileError as refused:
                yield (*location, key), str(refused)


def _rating_faults(plan: Plan, profile: Profile) -> Faults:
    """Yield the setpoints and stimuli beyond the motor's rating, in any case."""
    for case in cases(plan):
        parameters = {**profile.drive.parameters, **plan.setup, **case.setup}
        for key, reason in beyond_rating(case.operating_point, plan.stimulus, profile.motor, parameters):
            if key in plan.sweep.operating_point:
                yield ("sweep", "operating_point", key), reason
            elif key == "stimulus":
                yield ("stimulus",), reason
            else:
                yield ("operating_point", key), reason


def _record_faults(plan: Plan, profile: Profile, dictionary: Dictionary) -> Faults:
    """Yield captures longer than the drive records, and stimuli that do not fit its control period."""
    record = plan.record
    period_s = expected_period_s(profile, dictionary)
    if period_s is None:
        return
    rows = round(record.duration_s / (period_s * record.stride))
    shown = f"record.duration_s = {record.duration_s:g} makes {rows} rows of {period_s * record.stride:g} s"
    place = ("record", "duration_s")
    remedy = "shorten it, or record every so many ticks with stride"
    if rows < 2:
        yield place, f"{shown}: at least 2 are needed, lengthen it"
    if "capture_rows" in dictionary:
        most = dictionary["capture_rows"].maximum
        if most is not None and rows > most:
            yield place, f"{shown}, the drive records {most:g} at most: {remedy}"
    values = rows * len(record.channels)
    if "capture_data" in dictionary and values > MOST_VALUES:
        yield (
            place,
            f"{shown} and {len(record.channels)} channels, {values} values, the drive has room for "
            f"{MOST_VALUES}: {remedy}",
        )
    if plan.stimulus is None:
        return
    try:
        table = plan.stimulus.table(period_s)
        for name, value in table.items():
            if name in dictionary:
                dictionary[name].encode(value)
    except ValueRefused as refused:
        yield ("stimulus",), str(refused)


def expected_period_s(profile: Profile, dictionary: Dictionary) -> float | None:
    """Return the control period by the profile, or else the usual one by the dictionary; None if neither
    states it."""
    if profile.drive.control_period_s is not None:
        return profile.drive.control_period_s
    period_s = dictionary["control_period"].default if "control_period" in dictionary else None
    return period_s if isinstance(period_s, int | float) else None


def _window_faults(plan: Plan, profile: Profile, dictionary: Dictionary) -> Faults:
    """Yield the windows that are too short for their analyses."""
    record, analyses = plan.record, plan.analyses
    if analyses.steady and analyses.steady_from_s >= record.duration_s:
        yield (
            ("analyses", "steady_from_s"),
            f"steady_from_s = {analyses.steady_from_s:g} leaves nothing of the {record.duration_s:g} s that "
            f"are recorded: begin earlier or record longer",
        )
    elif analyses.steady and _PERIODIC & set(record.channels):
        yield from _period_faults(plan, profile, expected_period_s(profile, dictionary) or 0.0)
    stimulus = plan.stimulus
    if stimulus is None or not analyses.made(FREQUENCY_RESPONSE):
        return
    after_s = record.duration_s - record.pretrigger_s
    length_s = stimulus.duration_s
    if length_s is None and stimulus.prbs_clock_s is not None and stimulus.prbs_length is not None:
        length_s = stimulus.prbs_clock_s * ((1 << stimulus.prbs_length) - 1)
    if stimulus.repetitions > 1 and length_s is not None and after_s < 2.0 * length_s:
        yield (
            ("record", "duration_s"),
            f"the stimulus repeats itself every {length_s:g} s and {after_s:g} s of it are recorded: two "
            f"repetitions at least are needed, of which the first is left out",
        )


def _period_faults(plan: Plan, profile: Profile, period_s: float) -> Faults:
    """Yield the cases with fewer than two electrical periods in steady state."""
    record = plan.record
    window_s = record.duration_s - plan.analyses.steady_from_s
    lost_s = _ROWS_AT_THE_ENDS * period_s * record.stride if "i_a" in record.channels else 0.0
    for case in cases(plan):
        omega_m = speed_rad_s(case.operating_point, plan.stimulus)
        if omega_m is None:
            continue
        f_e_Hz = profile.motor.pole_pairs * abs(omega_m) / (2.0 * math.pi)
        periods = max(0.0, window_s - lost_s) * f_e_Hz
        if periods >= _FEWEST_PERIODS:
            continue
        least = f"record {_FEWEST_PERIODS / f_e_Hz + lost_s:.3g} s at least" if f_e_Hz else "the shaft stands"
        yield (
            ("record", "duration_s"),
            f"the steady state lasts {window_s:g} s, {periods:.2g} electrical periods at {omega_m:g} rad/s "
            f"(case '{case.name}'), {_FEWEST_PERIODS} are needed: {least}, or set analyses.steady = false",
        )


def _settings(plan: Plan) -> Iterator[tuple[Path_, str, Setting]]:
    for key, value in plan.setup.items():
        yield ("setup", key), key, value
    for key, values in plan.sweep.setup.items():
        for value in values:
            yield ("sweep", "setup", key), key, value
    for number, variant in enumerate(plan.variants):
        for key, value in variant.setup.items():
            yield ("variants", number, "setup", key), key, value
