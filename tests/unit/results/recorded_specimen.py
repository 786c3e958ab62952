"""A machine on a bench as a stream shows it, whose every level is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchtool.block import Block, Channel, Gap
from benchtool.profile import Profile, load_profile
from benchtool.recording import Bundle, BundleWriter, Manifest
from benchtool.shipped import shipped

PROFILE: Profile = load_profile("zhu2011")
CONTROL_HZ = 10_000.0


def stream(
    operating_points: Sequence[tuple[float, float, float]],
    rate_Hz: float = 250.0,
    *,
    channels: Sequence[str] = ("torque", "omega_m", "i_a", "u_dc"),
    seed: int = 0,
) -> Block:
    """Rows of seconds, speed in rad/s and torque in Nm, one operating point after the other.

    The torque has 0.02 Nm rms of noise, the current is 1 A peak at four times the speed.
    """
    rng = np.random.default_rng(seed)
    counts = [round(seconds * rate_Hz) for seconds, _, _ in operating_points]
    omega_m = np.repeat([point[1] for point in operating_points], counts)
    torque = np.repeat([point[2] for point in operating_points], counts)
    theta_m = np.cumsum(omega_m) / rate_Hz
    rows = len(omega_m)
    values = {
        "omega_m": omega_m + 0.01 * rng.normal(size=rows),
        "torque": torque + 0.02 * rng.normal(size=rows),
        "i_a": np.cos(4.0 * theta_m) + 1e-3 * rng.normal(size=rows),
        "theta_m": np.mod(theta_m, 2.0 * math.pi),
        "u_dc": 122.5 + 0.1 * rng.normal(size=rows),
    }
    units = {"omega_m": "rad/s", "torque": "Nm", "i_a": "A", "theta_m": "rad", "u_dc": "V"}
    named = tuple(Channel(name, units[name]) for name in channels)
    data = np.column_stack([values[name] for name in channels])
    return Block(named, 0, round(CONTROL_HZ / rate_Hz), 1.0 / CONTROL_HZ, data)


def with_gaps(block: Block, *gaps: tuple[int, int]) -> Block:
    """The same rows, of which some are missing before row ROW: (ROW, how many)."""
    return replace(block, gaps=tuple(Gap(row, missing) for row, missing in gaps))


def recording(
    folder: Path, blocks: dict[str, Block], *, finish: bool = True, toml: str | None = None, link: str = ""
) -> Bundle:
    """A bundle as `record` leaves it, with the profile of the paper's machine."""
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    manifest = Manifest(
        what="record", when="2026-03-01T10:00:00", profile_toml=text if toml is None else toml, link=link
    )
    with BundleWriter(folder, manifest) as writer:
        for name, block in blocks.items():
            writer.append(name, block)
        if finish:
            writer.finish()
        else:
            writer.fail("LinkClosed: the adapter vanished")
    return Bundle.open(folder)
