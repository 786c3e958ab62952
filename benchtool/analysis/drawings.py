"""Drawings to which several analyses contribute."""

from __future__ import annotations

from typing import Final

from benchtool.analysis.declaration import Drawing

WAVEFORMS: Final = Drawing(
    "waveforms",
    "Waveforms",
    "Torque, phase currents and stator flux: on the left the whole capture by the least and the greatest "
    "value of each stretch, on the right its last two electrical periods, with the fundamental of "
    "each current. Orange lines are limits that the plan judges by.",
)
TORQUE: Final = Drawing(
    "torque",
    "Torque",
    "Torque and its reference over the whole capture.",
    channels=("torque",),
    of_recording=True,
    replaces=("waveforms", "current_spectrum", "flux_trajectory"),
)
STEADY: Final = Drawing(
    "steady",
    "Torque, current and flux of each capture",
    "Torque, phase current a and stator flux over the whole of each capture, on the same axes.",
    channels=("torque", "i_a", "psi_s"),
    of_recording=True,
)
