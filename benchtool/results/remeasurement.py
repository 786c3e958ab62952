"""Repeated measurement of a recording with a perturbed sensor, for measurements without declared
sensitivities.

The numerical derivative of JCGM 100:2008, 5.1.3, note 2: `benchtool.analysis.instruments` asks for it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Set
from dataclasses import replace

import numpy as np

from benchtool.analysis import Measurement, Perturbed, catalogue, measure
from benchtool.plan import Analyses, CaseReadings, Plan
from benchtool.protocol import Mode
from benchtool.results.analyses import Planned


def rests_on(plan: Plan, transducer: bool, name: str) -> tuple[str, ...]:
    """Return the channels of a measurement whose sensitivities are not declared."""
    if name == "load_torque_reached":
        if plan.operating_point.mode_of_operation is Mode.TORQUE:
            return "torque", "omega_m"
        return ("torque_transducer",) if transducer else ("torque",)
    return channels_of(plan.analyses, name)


def is_of_spectra(name: str) -> bool:
    """Return whether a measurement is of ratios of spectra."""
    analysis = catalogue().measuring(name)
    return analysis is not None and analysis.of_spectra


def channels_of(analyses: Analyses, name: str) -> tuple[str, ...]:
    """Return the channels of a measurement by one of these analyses; none if none of them gives it."""
    analysis = catalogue().measuring(name)
    settings = None if analysis is None else analyses.settings(analysis)
    if analysis is None or settings is None:
        return ()
    channels = analysis.needs(settings)
    return (*channels, "torque_transducer") if analysis.transducer else channels


def perturbed_readings(seen: CaseReadings, altered: Perturbed) -> CaseReadings:
    """Return the readings with the error of their channel."""
    if altered.channel not in seen.readings:
        return seen
    values = altered.reading(np.array(seen.readings[altered.channel]))
    return replace(seen, readings={**seen.readings, altered.channel: tuple(values.tolist())})


def names_of_undeclared(measurements: Iterable[Measurement]) -> frozenset[str]:
    """Return the names of the measurements that have a value and declare no sensitivities."""
    return frozenset(
        each.name for each in measurements if math.isfinite(each.value) and not each.sensitivities.is_declared
    )


def remeasured(
    analyses: Analyses, todo: Iterable[Planned], channel: str, undeclared: Set[str]
) -> Iterator[Measurement]:
    """Yield what these analyses find that rest on a channel and declare no sensitivity to it.

    Args:
        analyses: with the settings that `todo` has.
        todo: of the recording as the channel would have been read with another error.
        channel: its name.
        undeclared: the names of the measurements that declare no sensitivities.

    Raises:
        AnalysisError: the data do not allow one of them.
    """
    for each in todo:
        own = next((name for name in undeclared if each.analysis.quantity(name) is not None), None)
        if own is None or not each.possible:
            continue
        if channel in channels_of(analyses, own):
            yield from measure(each.analysis, each.window, each.settings).measurements
