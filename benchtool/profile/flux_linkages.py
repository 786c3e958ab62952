"""Flux linkages over currents as a table, as finite elements or a flux map on a bench give them."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Final

from pydantic import Field, model_validator

from benchtool.document import Array, Section

Current = Annotated[float, Field(ge=-1e4, le=1e4)]
Flux = Annotated[float, Field(ge=-100, le=100)]
Currents = Annotated[Array[Current], Field(min_length=3, max_length=41)]
Table = Annotated[Array[Array[Flux]], Field(max_length=41)]

MOST_CURL: Final = 0.05
"""Of the inductance: by how much the mutual inductances of the axes may differ in a mesh of a table, whose
flux linkages are taken as linear between its points."""


class FluxLinkages(Section):
    """Flux linkages psi_d and psi_q over i_d and i_q, peak, in d/q with the d axis on the rotor flux.

    A field has one energy, so that the mutual inductances of the axes are the same, d psi_d / d i_q =
    d psi_q / d i_d. A table that contradicts it is refused.
    """

    i_d_A: Currents
    """Currents along the rotor flux, rising, with zero among or between them."""
    i_q_A: Currents
    """Currents across the rotor flux, likewise."""
    psi_d_Wb: Table
    """Flux linkage along the rotor flux: a row for each i_d, in it a value for each i_q."""
    psi_q_Wb: Table
    """Flux linkage across the rotor flux, likewise."""

    @model_validator(mode="after")
    def _is_of_a_field(self) -> FluxLinkages:
        self._require_grid()
        self._require_rising()
        self._require_reciprocal()
        return self

    def _require_grid(self) -> None:
        for key, values in (("i_d_A", self.i_d_A), ("i_q_A", self.i_q_A)):
            if any(second <= first for first, second in pairwise(values)):
                raise ValueError(f"{key} does not rise from each value to the next: sort it, and the tables")
            if not values[0] <= 0.0 <= values[-1]:
                raise ValueError(
                    f"{key} is from {values[0]:g} to {values[-1]:g} A: zero is expected within, where the "
                    f"rotor flux is told"
                )
        expected = f"{len(self.i_d_A)} rows, one for each i_d, of {len(self.i_q_A)} values"
        for key, table in (("psi_d_Wb", self.psi_d_Wb), ("psi_q_Wb", self.psi_q_Wb)):
            if len(table) != len(self.i_d_A) or any(len(row) != len(self.i_q_A) for row in table):
                rows, most = len(table), max(map(len, table), default=0)
                raise ValueError(f"{key} has {rows} rows of up to {most} values: {expected} are expected")

    def _require_rising(self) -> None:
        rows = range(len(self.i_d_A))
        for k, row in enumerate(zip(*self.psi_d_Wb, strict=True)):
            for n, (first, second) in enumerate(pairwise(row)):
                if second <= first:
                    raise ValueError(
                        f"psi_d_Wb falls with i_d from {self.i_d_A[n]:g} to {self.i_d_A[n + 1]:g} A at i_q = "
                        f"{self.i_q_A[k]:g} A: an inductance is positive; rows are of i_d, is the table "
                        f"transposed?"
                    )
        for k in rows:
            for n, (first, second) in enumerate(pairwise(self.psi_q_Wb[k])):
                if second <= first:
                    raise ValueError(
                        f"psi_q_Wb falls with i_q from {self.i_q_A[n]:g} to {self.i_q_A[n + 1]:g} A at i_d = "
                        f"{self.i_d_A[k]:g} A: an inductance is positive; rows are of i_d, is the table "
                        f"transposed?"
                    )

    def _require_reciprocal(self) -> None:
        """Refuse a mesh around which the flux linkages, as forces of a field, would do work."""
        for k, (d_0, d_1) in enumerate(pairwise(self.i_d_A)):
            for n, (q_0, q_1) in enumerate(pairwise(self.i_q_A)):
                d, q = self.psi_d_Wb, self.psi_q_Wb
                along = d[k + 1][n] + d[k + 1][n + 1] - d[k][n] - d[k][n + 1]
                across = q[k][n + 1] + q[k + 1][n + 1] - q[k][n] - q[k + 1][n]
                inductance = 0.5 * ((along / (d_1 - d_0)) * (across / (q_1 - q_0))) ** 0.5
                by_q = 0.5 * (d[k][n + 1] + d[k + 1][n + 1] - d[k][n] - d[k + 1][n]) / (q_1 - q_0)
                by_d = 0.5 * (q[k + 1][n] + q[k + 1][n + 1] - q[k][n] - q[k][n + 1]) / (d_1 - d_0)
                if abs(by_q - by_d) > MOST_CURL * inductance:
                    raise ValueError(
                        f"psi_d_Wb and psi_q_Wb are of no field: between i_d = {d_0:g} and {d_1:g} A, i_q = "
                        f"{q_0:g} and {q_1:g} A psi_d changes with i_q by {by_q:.3g} H and psi_q with i_d by "
                        f"{by_d:.3g} H, which are the same in any machine; at most {MOST_CURL:.0%} of "
                        f"{inductance:.3g} H may lie between: check signs, order and rotor angle of the table"
                    )
