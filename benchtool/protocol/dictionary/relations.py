"""Limits given by the value of another variable, such as a trip level's by the converter's range."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from benchtool.protocol.dictionary.dictionary import Dictionary
from benchtool.protocol.dictionary.keys import variable_of
from benchtool.protocol.dictionary.variable import Value, Variable

_ROUNDING = 1e-6  # of a float32


@dataclass(frozen=True)
class Relation:
    """`lower` is at most `times` the value of `upper`; 0 means unknown, without a limit.

    Where `share` is stated it is `upper` that is limited: it is at least that share of `lower`.
    """

    lower: Variable
    upper: Variable
    times: float
    share: float | None = None

    def breach(self, values: Mapping[str, Value]) -> str:
        """Return the fault of these values, by name, and the remedy; empty if there is none, or a value is
        missing."""
        lower, upper = values.get(self.lower.name), values.get(self.upper.name)
        if not (isinstance(lower, int | float) and isinstance(upper, int | float)):
            return ""
        if self.share is not None:
            return self._too_low(lower, upper, self.share * lower)
        if upper <= 0:
            return ""
        most = self.times * upper
        if lower <= most * (1.0 + _ROUNDING):
            return ""
        times = "" if self.times == 1 else f"{self.times:g} times "
        return (
            f"{self.lower.name} = {lower:.6g} {self.lower.unit} is above {times}{self.upper.name} "
            f"= {upper:.6g} {self.upper.unit}: give at most {most:.6g} {self.lower.unit}"
        )

    def _too_low(self, lower: float, upper: float, least: float) -> str:
        if upper >= least * (1.0 - _ROUNDING):
            return ""
        return (
            f"{self.upper.name} = {upper:.6g} {self.upper.unit} is below {self.share:g} times "
            f"{self.lower.name} = {lower:.6g} {self.lower.unit}: give at least {least:.6g} {self.upper.unit}"
        )


def relations(dictionary: Dictionary) -> Iterator[Relation]:
    """Yield every relation of two variables that the dictionary states, once."""
    stated: set[tuple[str, str]] = set()
    for variable in dictionary:
        share = None if variable.min_times == 1.0 else variable.min_times
        rows = (
            (variable.name, variable.max_entry, variable.max_times, None),
            (variable.min_entry, variable.name, 1.0, share),
        )
        for lower, upper, times, of_lower in rows:
            if lower in dictionary and upper in dictionary and (lower, upper) not in stated:
                stated.add((lower, upper))
                yield Relation(dictionary[lower], dictionary[upper], times, of_lower)


def first_breach(dictionary: Dictionary, given: Mapping[str, Value], ranges: Mapping[str, Value]) -> str:
    """Return the fault of parameters, by key, on a drive whose sensors have these `ranges`; empty if none.

    Missing parameters have their defaults, except for levels that a drive cuts to its ranges.
    """
    values = {variable.name: variable.default for variable in dictionary if variable.default is not None}
    set_here = [(variable_of(dictionary, key), value) for key, value in given.items()]
    values |= {variable.name: variable.decode(variable.encode(value)) for variable, value in set_here}
    values |= {variable_of(dictionary, key).name: value for key, value in ranges.items()}
    names = {variable.name for variable, _ in set_here}
    found = (
        each.breach(values)
        for each in relations(dictionary)
        if each.lower.name in names or each.upper.name in names
    )
    return next(filter(None, found), "")
