"""The table `[analyses]` of a plan: which kinds of analysis are made, with which settings.

    [analyses]
    steady = true                    # the steady state, by every analysis of it that the channels allow
    steady_from_s = 0.3              # from there on
    torque_orders = false            # but not by this one
    frequency_response = true        # asked for, as it is by default

    [analyses.step]                  # asked for, with settings
    signal = "torque"

The names and their settings are those of the catalogue. An older form, `step = true` beside `step_signal`, is
read as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import (
    Field,
    SerializationInfo,
    ValidationError,
    model_serializer,
    model_validator,
)
from pydantic_core import InitErrorDetails

from benchtool.document import Section, closest
from benchtool.misfits import Path_
from benchtool.plan.former_names import present_name
from benchtool.plan.lazy_catalogue import catalogue

if TYPE_CHECKING:
    from benchtool.analysis import Analysis

_OLDER: Final = {
    ("step", "signal"): "step_signal",
    ("step", "reference"): "step_reference",
    ("frequency_response", "input"): "response_input",
    ("frequency_response", "output"): "response_output",
}
"""Former keys of settings of an analysis."""


class Analyses(Section):
    """Analyses of a plan: the steady state from `steady_from_s` of the capture on, and requested analyses.

    `kinds` has the settings of every analysis that the plan names, None where it is switched off.
    """

    steady: bool = True
    """Measure the steady state by every analysis that the channels allow."""
    steady_from_s: Annotated[float, Field(ge=0)] = 0.0
    """Time of the capture from which it is steady."""
    kinds: dict[str, Section | None] = Field(default_factory=dict)
    """Settings of the analyses that the plan names."""

    def settings(self, analysis: Analysis[Any]) -> Section | None:
        """Return the settings with which an analysis is made; None if it is not.

        For an analysis of a steady state, the channels are not considered here.
        """
        if analysis.name in self.kinds:
            return self.kinds[analysis.name]
        asked = analysis.of_steady_state and self.steady
        settings: Section | None = analysis.settings() if asked else None
        return settings

    def demanded(self) -> Iterator[tuple[Analysis[Any], Section]]:
        """Yield the analyses that the plan requests explicitly, whose channels it must record."""
        for each in catalogue().analyses:
            settings = self.kinds.get(each.name)
            if settings is not None:
                yield each, settings

    def made(self, analysis: Analysis[Any]) -> bool:
        """Return whether the plan includes an analysis."""
        allowed = self.steady or not analysis.of_steady_state
        return allowed and self.settings(analysis) is not None

    @model_validator(mode="before")
    @classmethod
    def _by_the_catalogue(cls, table: Any) -> Any:
        if not isinstance(table, Mapping):
            return table
        own = {key: value for key, value in table.items() if key in ("steady", "steady_from_s")}
        named = {key: value for key, value in table.items() if key not in own}
        if not named:
            return own
        errors: list[InitErrorDetails] = []
        kinds: dict[str, Section | None] = {}
        for analysis in catalogue().analyses:
            beside = {
                key: named.pop(older)
                for (name, key), older in _OLDER.items()
                if name == analysis.name and older in named
            }
            given = named.pop(analysis.name, None)
            if given is None and not beside:
                continue
            try:
                settings = _settings(analysis, given, beside)
            except ValidationError as failed:
                errors += _located(failed, analysis, beside)
                continue
            if settings is not None or (given is False and analysis.of_steady_state):
                kinds[analysis.name] = settings
        known = ("steady", "steady_from_s", *(each.name for each in catalogue().analyses))
        errors += (_error((key,), value, _unknown(key, known)) for key, value in named.items())
        if errors:
            raise ValidationError.from_exception_data(cls.__name__, errors)
        return own | {"kinds": kinds}

    @model_validator(mode="after")
    def _steady_where_it_is_needed(self) -> Analyses:
        for analysis, _ in self.demanded() if self.kinds and not self.steady else ():
            if analysis.of_steady_state:
                raise ValueError(f"{analysis.name} is measured of a steady state: set steady = true")
        return self

    @model_serializer(mode="plain")
    def _document(self, info: SerializationInfo) -> dict[str, Any]:
        """As a document has it, the older keys left behind."""
        kinds = {
            name: False
            if settings is None
            else settings.model_dump(mode=info.mode, exclude_none=bool(info.exclude_none)) or True
            for name, settings in self.kinds.items()
        }
        return {"steady": self.steady, "steady_from_s": self.steady_from_s, **kinds}


def spelled(table: Mapping[str, Any], analysis: str, key: str) -> tuple[Path_, str]:
    """Return where `[analyses]`, as it was read, has a setting, and what it calls it there."""
    older = _OLDER.get((analysis, key), "")
    if older in table:
        return ("analyses", older), older
    return ("analyses", analysis, key), f"analyses.{analysis}.{key}"


def _settings(analysis: Analysis[Any], given: Any, beside: Mapping[str, Any]) -> Section | None:
    """Return settings that a plan gives; None where it switches the analysis off, or does not ask for it."""
    if isinstance(given, Mapping):
        settings: Section = analysis.settings.model_validate({**beside, **given})
        return settings
    if given is not None and not isinstance(given, bool):
        error = _error((), given, "true, false or a table of settings is expected")
        raise ValidationError.from_exception_data(analysis.name, [error])
    checked: Section = analysis.settings.model_validate(beside)
    return checked if given else None


def _located(
    failed: ValidationError, analysis: Analysis[Any], beside: Mapping[str, Any]
) -> Iterator[InitErrorDetails]:
    """Yield the errors of an analysis' settings, by the keys of the document."""
    for each in failed.errors():
        key = each["loc"][:1]
        older = _OLDER.get((analysis.name, str(key[0])), "") if key and key[0] in beside else ""
        place: Path_ = (older, *each["loc"][1:]) if older else (analysis.name, *each["loc"])
        if each["type"] == "extra_forbidden":
            yield _error(
                place, each["input"], _unknown(str(place[-1]), tuple(analysis.settings.model_fields))
            )
        else:
            yield InitErrorDetails(type=each["type"], loc=place, input=each["input"], ctx=each.get("ctx", {}))


def _unknown(key: str, known: Sequence[str]) -> str:
    if (present := present_name(key)) in known:
        return f"unknown key: it is called '{present}' now, write that"
    return f"unknown key: {closest(key, known)}" if known else "unknown key: there is nothing to set"


def _error(place: Path_, seen: Any, reason: str) -> InitErrorDetails:
    return InitErrorDetails(type="value_error", loc=place, input=seen, ctx={"error": ValueError(reason)})
