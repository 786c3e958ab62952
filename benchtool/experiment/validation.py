"""A plan against the drive's dictionary, before anything is opened or sent."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from benchtool.document import line_of
from benchtool.errors import PlanError, ValueRefused
from benchtool.experiment.plan import Plan, Setting
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.keys import variable_of

Location = tuple[str | int, ...]


def require_known(plan: Plan, path: Path, dictionary: Dictionary) -> None:
    """Check every parameter and channel that the plan at `path` names, and every value it sets.

    Raises:
        PlanError: one is unknown, of the wrong unit or out of its limits; the message names file and line.
    """
    text = path.read_text(encoding="utf-8")
    for location, key, value in _settings(plan):
        place = f"{path}{line_of(text, (*location, key))}"
        try:
            variable = variable_of(dictionary, key)
            variable.encode(value)
        except ValueRefused as refused:
            raise PlanError(f"{place}: {refused}") from None
        if variable.role in ("signal", "command") or not variable.writable:
            raise PlanError(f"{place}: '{key}' is not a parameter to set up: see 'benchtool params list'")
    for channel in plan.record.channels:
        if channel not in dictionary or dictionary[channel].role != "signal":
            known = ", ".join(variable.name for variable in dictionary if variable.role == "signal")
            raise PlanError(
                f"{path}{line_of(text, ('record', 'channels'))}: no signal '{channel}' to capture: "
                f"the drive has {known}"
            )
    for key, channel in _analysed(plan):
        if channel not in plan.record.channels:
            raise PlanError(
                f"{path}{line_of(text, ('analyses', key))}: {key} is '{channel}', which record.channels does "
                f"not have: add it there, or choose one of {', '.join(plan.record.channels)}"
            )


def _analysed(plan: Plan) -> Iterator[tuple[str, str]]:
    """The keys of `analyses` that name a channel, and that channel."""
    analyses = plan.analyses
    if analyses.step:
        yield "step_signal", analyses.step_signal
        yield "step_reference", analyses.step_reference
    if analyses.frequency_response:
        yield "response_input", analyses.response_input
        yield "response_output", analyses.response_output


def _settings(plan: Plan) -> Iterator[tuple[Location, str, Setting]]:
    for key, value in plan.setup.items():
        yield ("setup",), key, value
    for key, values in plan.sweep.setup.items():
        for value in values:
            yield ("sweep", "setup"), key, value
    for number, variant in enumerate(plan.variants):
        for key, value in variant.setup.items():
            yield ("variants", number, "setup"), key, value
