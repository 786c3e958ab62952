"""Repeated measurement of a recording with a perturbed sensor, for measurements without declared
sensitivities.

The numerical derivative of JCGM 100:2008, 5.1.3, note 2, which `benchtool.analysis.sensors.instruments` asks
for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from benchtool.analysis import Findings, Measurement, measure
from benchtool.results.analyses import Planned


def remeasured(
    todo: Iterable[Planned], channel: str, findings: Mapping[str, Findings]
) -> Iterator[Measurement]:
    """Yield the measurements of the analyses that found something which has to be measured again.

    Args:
        todo: of the recording as the channel would have been read with another error.
        channel: its name.
        findings: of the recording as it is, by analysis.

    Raises:
        AnalysisError: the data do not allow one of them.
    """
    for each in todo:
        found = findings.get(each.analysis.name)
        if found is not None and each.possible and any(_moved(by, channel) for by in found.measurements):
            yield from measure(each.analysis, each.window, each.settings).measurements


def _moved(each: Measurement, channel: str) -> bool:
    """Return whether a measurement has a value and has to be measured again with errors of a channel."""
    return math.isfinite(each.value) and bool(each.sensitivities.again(channel))
