"""All families by name. To add a kind of signal, add a module in this package and a line here."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.coverage import (
    angles,
    answers,
    balances,
    channels,
    coarse,
    coarse_lines,
    controlled,
    disturbances,
    dynamic,
    encounters,
    few_turns,
    held_speeds,
    identified,
    inverter_states,
    limit_cycles,
    lines,
    loops,
    mixed,
    near_lines,
    pairs,
    part_turns,
    revolutions,
    same_places,
    sensed_answers,
    sensors,
    shaft_torque,
    sidebands,
    speed_orders,
    stale_rows,
    stamps,
    threes,
    unusual,
)
from benchmarks.coverage.families import Family

FAMILIES: Mapping[str, Family] = {
    each.name: each
    for each in (
        *disturbances.FAMILIES,
        *angles.FAMILIES,
        *channels.FAMILIES,
        *stamps.FAMILIES,
        *stale_rows.FAMILIES,
        *dynamic.FAMILIES,
        *identified.FAMILIES,
        *balances.FAMILIES,
        *inverter_states.FAMILIES,
        *unusual.FAMILIES,
        *mixed.FAMILIES,
        *encounters.FAMILIES,
        *few_turns.FAMILIES,
        *part_turns.FAMILIES,
        *pairs.FAMILIES,
        *threes.FAMILIES,
        *sidebands.FAMILIES,
        *answers.FAMILIES,
        *shaft_torque.FAMILIES,
        *revolutions.FAMILIES,
        *speed_orders.FAMILIES,
        *same_places.FAMILIES,
        *lines.FAMILIES,
        *loops.FAMILIES,
        *near_lines.FAMILIES,
        *coarse.FAMILIES,
        *coarse_lines.FAMILIES,
        *controlled.FAMILIES,
        *held_speeds.FAMILIES,
        *limit_cycles.FAMILIES,
        *sensors.FAMILIES,
        *sensed_answers.FAMILIES,
    )
}
