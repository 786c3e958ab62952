"""Capabilities of a drive, by the objects in its dictionary.

A capability is available when the dictionary has every object that it needs, with the necessary access.
Standard objects are looked up by role; names are of benchtool's own dictionary, where no standard defines
such an object.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import PurePath
from typing import Any, Final, Self

from benchtool.errors import CapabilityMissing
from benchtool.protocol import CYCLIC_POSITION, PROFILE_POSITION, Mode, first_supported
from benchtool.protocol.dictionary import Dictionary, Role

_SHOWN = 4
_DATA: Final = "capture_data"  # bytes; all others are numbers


class Capability(StrEnum):
    """Capabilities that a drive may have."""

    SUPERVISED = "supervised"
    TORQUE = "torque"
    VELOCITY = "velocity"
    POSITION = "position"
    STREAM = "stream"
    CAPTURE = "capture"
    STIMULUS = "stimulus"
    TICK = "tick"
    STORAGE = "storage"


@dataclass(frozen=True)
class _Object:
    """An object that a capability needs."""

    of: Role | str
    written: bool = False

    def found(self, dictionary: Dictionary) -> str | None:
        """Return the address and role or name, `0x6071:0 target_torque`; None if it is missing, or not
        accessible."""
        variable = dictionary.get(self.of)
        if variable is None or not (variable.writable if self.written else variable.readable):
            return None
        if variable.type.numpy is None and self.of != _DATA:
            return None
        return f"{variable.label} {self.of.title if isinstance(self.of, Role) else self.of}"

    def wanted(self, dictionary: Dictionary) -> str:
        """Return what to look for, and the access if the object is there without it."""
        label = self.of.label if isinstance(self.of, Role) else self.of
        if self.of not in dictionary:
            return label
        return f"{label}, a {'writable' if self.written else 'readable'} number"


@dataclass(frozen=True)
class _Needs:
    """Objects that a capability needs, and the consequence of lacking it.

    One of `modes` (0x6060) suffices. `beside` are optional objects that extend it.
    """

    objects: tuple[_Object, ...]
    cost: str
    modes: tuple[int, ...] = ()
    beside: tuple[_Object, ...] = ()

    def missing(self, dictionary: Dictionary) -> tuple[str, ...]:
        """Return the missing objects."""
        absent = [each.wanted(dictionary) for each in self.objects if each.found(dictionary) is None]
        variable = dictionary.get(Role.SUPPORTED_MODES)
        stated = None if variable is None else variable.raw_default
        if self.modes and isinstance(stated, int) and stated and first_supported(self.modes, stated) is None:
            bits = " or ".join(str(mode - 1) for mode in self.modes)
            absent.append(f"{Role.SUPPORTED_MODES.label}, bit {bits}")
        return tuple(absent)


def _read(*of: Role | str) -> tuple[_Object, ...]:
    return tuple(_Object(each) for each in of)


def _written(*of: Role | str) -> tuple[_Object, ...]:
    return tuple(_Object(each, written=True) for each in of)


_STATES = (*_written(Role.CONTROLWORD), *_read(Role.STATUSWORD), *_written(Role.MODE_OF_OPERATION))
_TICK = _read("tick", "control_period")

_NEEDS: Final[Mapping[Capability, _Needs]] = {
    Capability.SUPERVISED: _Needs(
        _written(Role.CONSUMER_HEARTBEAT),
        "the motor would run on when this host or the cable dies",
        beside=_written(Role.ABORT_CONNECTION_OPTION),
    ),
    Capability.TORQUE: _Needs(
        (*_STATES, *_written(Role.TARGET_TORQUE)),
        "the drive cannot be enabled to make a torque",
        Mode.TORQUE.codes,
        _read(Role.TORQUE_ACTUAL, Role.MOTOR_RATED_TORQUE),
    ),
    Capability.VELOCITY: _Needs(
        (*_STATES, *_written(Role.TARGET_VELOCITY)),
        "the drive cannot be enabled to hold a speed",
        Mode.VELOCITY.codes,
        _read(Role.VELOCITY_ACTUAL),
    ),
    Capability.POSITION: _Needs(
        (*_STATES, *_written(Role.TARGET_POSITION)),
        "the drive cannot be enabled to go to a position",
        (PROFILE_POSITION, CYCLIC_POSITION),
        _read(Role.POSITION_ACTUAL),
    ),
    Capability.STREAM: _Needs(
        (*_TICK, *_read("stream_sequence"), *_written(Role.TPDO_COB_ID, Role.TPDO_MAPPING)),
        "signals cannot be recorded or shown while they happen",
    ),
    Capability.CAPTURE: _Needs(
        (
            *_TICK,
            *_written("capture_control", "capture_rows", "capture_stride", "capture_pretrigger"),
            *_written("capture_trigger", "capture_trigger_signal", "capture_trigger_level"),
            *_written("capture_channel_1"),
            *_read("capture_state", "capture_rows_done", "capture_sequence", _DATA),
        ),
        "ripple and spectra cannot be measured at the control rate",
    ),
    Capability.STIMULUS: _Needs(
        (
            *_TICK,
            *_written("stimulus_control", "stimulus_quantity", "stimulus_shape", "stimulus_amplitude"),
            *_written("stimulus_offset", "stimulus_ticks", "stimulus_repetitions"),
            *_written("stimulus_frequency_start", "stimulus_frequency_end", "stimulus_steps"),
            *_written("stimulus_prbs_clock", "stimulus_prbs_length", "stimulus_seed"),
            *_written("stimulus_frame", "stimulus_angle", "stimulus_omega_e", "stimulus_turn_ticks"),
            *_read("stimulus_state", "torque_limit", "i_trip", "u_dc", "omega_m_command"),
            *_read(Role.MODE_OF_OPERATION_DISPLAY),
        ),
        "step and frequency responses cannot be measured: no host's timer paces an experiment",
    ),
    Capability.TICK: _Needs(_TICK, "samples have no time base of the drive, and are placed by arrival only"),
    Capability.STORAGE: _Needs(
        _written(Role.STORE_PARAMETERS),
        "what is set is forgotten at the next reset or power off",
        beside=_written(Role.RESTORE_DEFAULT_PARAMETERS),
    ),
}


@dataclass(frozen=True)
class Finding:
    """Whether a capability is available, and by which objects, or which are missing."""

    available: bool
    by: tuple[str, ...]
    missing: tuple[str, ...]


@dataclass(frozen=True)
class Capabilities:
    """What a drive can do, by capability; `source` names its EDS."""

    source: str
    findings: Mapping[Capability, Finding]

    @classmethod
    def of(cls, dictionary: Dictionary) -> Self:
        """Return the capabilities of the drive that a dictionary describes."""
        findings = {capability: _finding(dictionary, needs) for capability, needs in _NEEDS.items()}
        return cls(PurePath(dictionary.source).name, findings)

    def __contains__(self, capability: object) -> bool:
        return isinstance(capability, Capability) and self.findings[capability].available

    def require(self, *wanted: Capability, purpose: str) -> None:
        """Check that the drive has these capabilities.

        Args:
            purpose: what takes them: "a jog", "the plan".

        Raises:
            CapabilityMissing: one is missing; the message names the objects and the consequence.
        """
        for capability in wanted:
            finding = self.findings[capability]
            if not finding.available:
                more = len(finding.missing) - _SHOWN
                listed = ", ".join(finding.missing[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
                raise CapabilityMissing(
                    f"no '{capability}': {cost(capability)}; {purpose} takes it, and {self.source} has not "
                    f"{listed}: {_remedy(capability)}; nothing was sent"
                )

    def to_json(self) -> dict[str, dict[str, Any]]:
        """By name, each with `available`, `by` and `missing`."""
        return {str(capability): asdict(finding) for capability, finding in self.findings.items()}


def cost(capability: Capability) -> str:
    """Return the consequence of lacking a capability."""
    return _NEEDS[capability].cost


def _finding(dictionary: Dictionary, needs: _Needs) -> Finding:
    if missing := needs.missing(dictionary):
        return Finding(False, (), missing)
    labels = (each.found(dictionary) for each in (*needs.objects, *needs.beside))
    return Finding(True, tuple(label for label in labels if label is not None), ())


def _remedy(capability: Capability) -> str:
    """Return the remedy for a missing capability."""
    if any(isinstance(each.of, str) for each in _NEEDS[capability].objects):
        return "it takes firmware of benchtool's dictionary (docs/how_to/port_firmware.md)"
    if capability is Capability.SUPERVISED:
        return (
            "if another sub-index of it is to be used, name that under [roles] in its profile; only "
            "allow_unsupervised = true under [drive] lets the drive run without"
        )
    return "if the drive has such an object elsewhere, name it under [roles] in its profile"
