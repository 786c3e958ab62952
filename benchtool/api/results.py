"""What was measured: measurements by name, and tables."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchtool.api.named import Named
from benchtool.errors import AnalysisError, PlanError
from benchtool.notebook import table_html

if TYPE_CHECKING:
    from benchtool.analysis import Measurement, Table
    from benchtool.block import Block
    from benchtool.plan import Analyses
    from benchtool.profile import Profile


class Results(Named["Measurement"]):
    """Measurements by name, in the order in which they were made.

        results["torque_ripple_pp"]              # 0.0501 ± 0.0016 Nm
        results["torque_ripple_pp"].value

    `tables` are what has many rows, such as harmonics; `not_measured` says of each analysis that could not be
    made why not.
    """

    def __init__(
        self,
        measurements: Sequence[Measurement],
        tables: Sequence[Table] = (),
        not_measured: Mapping[str, str] | None = None,
    ) -> None:
        self._measurements = {each.name: each for each in measurements}
        self.tables: Mapping[str, Table] = {each.name: each for each in tables}
        self.not_measured: Mapping[str, str] = dict(not_measured or {})

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """All of them."""
        return tuple(self._measurements.values())

    def __getitem__(self, name: str) -> Measurement:
        """Return a measurement by name.

        Raises:
            AnalysisError: there is none; the message names the nearest, or why it was not made.
        """
        if name in self._measurements:
            return self._measurements[name]
        close = difflib.get_close_matches(name, self._measurements, n=1)
        meant = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(self) or 'none'}"
        lacking = "; ".join(f"{title}: {reason}" for title, reason in self.not_measured.items())
        not_made = f" (not measured: {lacking})" if lacking else ""
        raise AnalysisError(f"no measurement '{name}' among these results: {meant}{not_made}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._measurements)

    def to_dict(self) -> dict[str, float]:
        """Return the values by name; nan where undefined."""
        return {each.name: each.value for each in self.measurements}

    def __str__(self) -> str:
        width = max((len(name) for name in self), default=0)
        lines = [f"{each.name:<{width}}  {each}" for each in self.measurements]
        lines += [f"not measured: {title}: {reason}" for title, reason in self.not_measured.items()]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {len(self)} measurements, {len(self.tables)} tables>"

    def _repr_html_(self) -> str:
        rows = [(each.name, str(each), each.definition) for each in self.measurements]
        lacking = "; ".join(f"{title}: {reason}" for title, reason in self.not_measured.items())
        return table_html(
            ("measurement", ">value ± U (95 %)", "definition"),
            rows,
            footer=f"not measured: {lacking}" if lacking else "",
        )


def analyze(
    block: Block,
    profile: str | Path | Profile,
    *,
    analyses: Mapping[str, Any] | None = None,
    transducer: Block | None = None,
) -> Results:
    """Measure a block: everything that its channels allow, or what is asked for.

        results = benchtool.analyze(block, bench.profile)
        results = benchtool.analyze(block.crop(0.1, 0.3), "zhu2011")
        asked = {"steady": False, "step": {"signal": "i_q"}}
        results = benchtool.analyze(step, bench.profile, analyses=asked)

    Args:
        block: a capture, a stream, or a part of one; one without a gap.
        profile: of the motor and its sensors, or the name of one.
        analyses: what to make, as the table `[analyses]` of a plan; `benchtool analyze --list` lists them.
        transducer: what a torque transducer recorded meanwhile; a block that was captured brings its own.

    Raises:
        AnalysisError: nothing can be measured, with the reasons.
        PlanError: an analysis is unknown, or a key of it is wrong.
        ProfileError: there is no such profile.
    """
    from benchtool.profile import Profile, load_profile
    from benchtool.results import analyze as measure

    known = profile if isinstance(profile, Profile) else load_profile(str(profile))
    if transducer is None:
        transducer = _transducer_of(block)
    asked = {} if analyses is None else analyses
    found = measure(block, known, analyses=_analyses(asked), transducer=transducer)
    lacking = {title: f"needs {', '.join(channels)}" for title, channels in found.without.items()}
    return Results(found.measurements, found.tables, lacking)


def _transducer_of(block: Block) -> Block | None:
    """Return what a torque transducer recorded with a block, as long as that is the whole of it."""
    from benchtool.api.recorded import RecordedBlock

    if not isinstance(block, RecordedBlock) or block.transducer is None:
        return None
    apart_s = abs(block.transducer.duration_s - block.duration_s)
    return block.transducer if apart_s <= block.stride * block.tick_s else None


def _analyses(asked: Mapping[str, Any]) -> Analyses:
    from pydantic import ValidationError

    from benchtool.misfits import explain
    from benchtool.plan import Analyses

    try:
        return Analyses.model_validate(dict(asked))
    except ValidationError as failed:
        raise PlanError(f"analyses: {explain(Analyses, failed)}") from None
