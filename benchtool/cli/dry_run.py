"""`benchtool run PLAN --dry-run`: what a run would send, play and record; nothing is opened or sent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date
from typing import Any

from benchtool.analysis import count_of, raw
from benchtool.bench import dictionary_of, equipment_of
from benchtool.cli.listing import count, duration, measured
from benchtool.cli.output import Output
from benchtool.cli.run import NamedPlan
from benchtool.plan import Case, Plan, cases, drive_time_s, expected_period_s, not_made
from benchtool.profile import load_profile
from benchtool.protocol.dictionary import TRANSDUCER
from benchtool.results import Calibration, stated_overdue


def show_dry_run(plans: Sequence[NamedPlan], link: str, output: Output) -> int:
    """Print what runs of these plans, which have been checked, would do; returns the exit code."""
    documents = {each.label: _show(each, link, output) for each in plans}
    output.line("nothing was opened or sent")
    output.document({"dry_run": True, "link": link, "plans": documents})
    return 0


def _show(named: NamedPlan, link: str, output: Output) -> dict[str, Any]:
    plan, period_s = named.plan, expected_period_s(load_profile(named.profile), dictionary_of(named.profile))
    todo, bench = cases(plan), equipment_of(named.profile, link)
    lacking = not_made(plan, transducer=bench.has_transducer)
    facts = {
        "profile": named.profile,
        "link": link,
        **{f"bench: {name}": text for name, text in bench.lines().items()},
        "sent to the drive": _settings(plan.setup) or "no parameters",
        "played": _played(plan),
        "recorded": _recorded(plan, period_s),
        "measured": measured(plan),
        **(
            {"not measured": "; ".join(f"{title} {why}" for title, why in lacking.items())} if lacking else {}
        ),
        "limits": ", ".join((*plan.limits, *plan.case_limits)) or "of the operating point alone",
        "duration": f"about {duration(drive_time_s(plan))} of drive time for {count(len(todo))}",
    }
    late = Calibration(load_profile(named.profile).bench, date.today()).overdue(
        (*plan.record.channels, TRANSDUCER)
    )
    facts |= {"calibration overdue": "; ".join(map(str, late))} if late else {}
    output.table(plan.title, ("what", "value"), list(facts.items()))
    rows = [(each.name, _point(each), _settings(each.setup), _settings(each.emulator)) for each in todo]
    output.table("cases", ("case", "operating point", "sent besides", "emulated bench differs by"), rows)
    return {
        **facts,
        **stated_overdue(late),
        "not_measured": lacking,
        "duration_s": drive_time_s(plan),
        "setup": plan.setup,
        "cases": [
            {
                "name": each.name,
                "operating_point": each.operating_point.model_dump(exclude_none=True),
                "setup": dict(each.setup),
                "emulator": dict(each.emulator),
            }
            for each in todo
        ],
    }


def _point(case: Case) -> str:
    point = case.operating_point
    if point.mode == "velocity":
        return f"{raw(point.omega_m_rad_s)} rad/s, load {raw(point.load_torque_Nm)} Nm"
    held = "" if point.hold_speed_rad_s is None else f", shaft held at {raw(point.hold_speed_rad_s)} rad/s"
    loaded = f", load {raw(point.load_torque_Nm)} Nm" if point.load_torque_Nm else ""
    return f"{raw(point.torque_Nm)} Nm{held}{loaded}"


def _settings(values: Mapping[str, float | str]) -> str:
    return ", ".join(f"{key} = {raw(value)}" for key, value in values.items())


def _played(plan: Plan) -> str:
    stimulus = plan.stimulus
    if stimulus is None:
        return "nothing"
    lasts = "" if stimulus.duration_s is None else f", {raw(stimulus.duration_s)} s"
    times = f", {stimulus.repetitions} times" if stimulus.repetitions > 1 else ""
    reaches = f"amplitude {raw(stimulus.amplitude)} {stimulus.unit}"
    return f"{stimulus.shape} of {stimulus.quantity}, {reaches}{lasts}{times}"


def _recorded(plan: Plan, period_s: float | None) -> str:
    record = plan.record
    listed = f"{count_of(len(record.channels), 'channel')} for {raw(record.duration_s)} s"
    if period_s is None:
        return listed
    row_s = period_s * record.stride
    return f"{listed}, {count_of(round(record.duration_s / row_s), 'row')} at {raw(1.0 / row_s)} Hz"
