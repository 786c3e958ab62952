"""A recording measured again as if a sensor had another error, for what declares no sensitivity to it.

The numerical derivative of JCGM 100:2008, 5.1.3, note 2: `benchtool.analysis.instruments` asks for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchtool.analysis import Measurement
from benchtool.analysis.catalogue import catalogue, measure
from benchtool.analysis.instruments import Altered
from benchtool.analysis.sensitivity import declared
from benchtool.block import Block
from benchtool.drive import Mode
from benchtool.plan.model import Plan
from benchtool.plan.operating_point import Seen
from benchtool.profile import Motor
from benchtool.results.analyses import of_plan


def rests_on(plan: Plan, transducer: bool, name: str) -> tuple[str, ...]:
    """The channels of a measurement whose sensitivities are not declared."""
    if name == "load_torque_reached":
        if plan.operating_point.mode_of_operation is Mode.TORQUE:
            return "torque", "omega_m"
        return ("torque_transducer",) if transducer else ("torque",)
    analysis = catalogue().measuring(name)
    settings = None if analysis is None else plan.analyses.settings(analysis)
    if analysis is None or settings is None:
        return ()
    channels = analysis.needs(settings)
    return (*channels, "torque_transducer") if analysis.transducer else channels


def altered_readings(seen: Seen, altered: Altered) -> Seen:
    """What was read, with the error of its channel."""
    if altered.channel not in seen.readings:
        return seen
    values = altered.reading(np.array(seen.readings[altered.channel]))
    return replace(seen, readings={**seen.readings, altered.channel: tuple(values.tolist())})


def measured_again(
    plan: Plan, motor: Motor, capture: Block, transducer: Block | None, channel: str
) -> Iterator[Measurement]:
    """What the analyses of a plan find that rest on a channel and declare no sensitivity to it.

    Raises:
        AnalysisError: the data do not allow one of them.
    """
    for each in of_plan(plan, motor, capture, transducer):
        undeclared = next((name for name in each.analysis.names if declared(name) is None), None)
        if undeclared is None or not each.possible:
            continue
        if channel in rests_on(plan, transducer is not None, undeclared):
            yield from measure(each.analysis, each.window, each.settings).measurements
