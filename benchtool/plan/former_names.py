"""Names that measurements and analyses had in earlier versions.

A plan that is to run is refused with the name to write. The plan of a recording is brought up to date when it
is read (`upgraded`), so that earlier bundles are measured again under the present names.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

_RENAMED: Final = tuple(
    (re.compile(former), present)
    for former, present in (
        (r"^true_torque_", "transducer_torque_"),
        (r"_ripple_p99(?=_|$)", "_ripple_percentile_range"),
        (r"^dead_time(?=_[mu]?s$|$)", "step_latency"),
        (r"^current_thd(?=_percent$|$)", "current_thd_f"),
        (r"^current_thd(?:_f_noise)?_corrected(?=_percent$|$)", "current_thd_f"),
        (r"^current_thd_n(?=_percent$|$)", "current_thd_f_plus_noise"),
        (r"^current_thdg(?=_percent$|$)", "current_thd_f_groups"),
        (r"^current_thds(?=_percent$|$)", "current_thd_f_subgroups"),
        (r"_(adc_saturated|law_clipped)$", r"_\1_count"),
    )
)
_ORDER: Final = re.compile(r"(torque|speed)_order_([1-9]\d*)")


def present_name(name: str) -> str:
    """Return the name today of what had this one, which may end with a unit; the same where it has not
    changed."""
    for former, present in _RENAMED:
        name = former.sub(present, name)
    return name


def upgraded(plan: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document of a recorded plan under the present names.

    An order that a limit, a table or a published number names is listed in the settings of its analysis,
    without which it would not be measured.
    """
    found = dict(plan)
    for key in ("limits", "case_limits", "published", "analyses"):
        if isinstance(table := found.get(key), Mapping):
            found[key] = {
                present_name(str(name)): _names(value) if key in ("case_limits", "published") else value
                for name, value in table.items()
            }
    if isinstance(names := found.get("tabulate"), list | tuple):
        found["tabulate"] = [present_name(str(name)) for name in names]
    if isinstance(name := found.get("figure_of"), str):
        found["figure_of"] = present_name(name)
    return _with_orders(found)


def _names(table: Any) -> Any:
    return (
        {present_name(str(k)): value for k, value in table.items()} if isinstance(table, Mapping) else table
    )


def _with_orders(plan: dict[str, Any]) -> dict[str, Any]:
    named = [*plan.get("limits", {}), *plan.get("tabulate", ()), plan.get("figure_of", "")]
    for key in ("case_limits", "published"):
        named += [name for table in plan.get(key, {}).values() for name in table]
    analyses = dict(plan.get("analyses", {}))
    for channel, order in dict.fromkeys(
        found.groups() for name in named if (found := _ORDER.fullmatch(name))
    ):
        stated = analyses.get(f"{channel}_orders", True)
        settings = dict(stated) if isinstance(stated, Mapping) else {}
        listed = settings.get("orders", ())
        if stated is not False and int(order) not in listed:
            analyses[f"{channel}_orders"] = {**settings, "orders": [*listed, int(order)]}
    return {**plan, "analyses": analyses} if analyses else plan
