"""Mutants of commands, parameters and what the drive tells of itself."""

from __future__ import annotations

from typing import Any, Final

from benchtool.emulator.firmware import capture_objects, objects
from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.firmware.objects import ObjectStore
from benchtool.emulator.mutants.mutant import Mutant, Substitution
from benchtool.emulator.mutants.supervision import nothing, of_firmware
from benchtool.emulator.servers.drive_node import DriveNode
from benchtool.protocol import State
from benchtool.protocol.dictionary import Entry, Number


def _coasting(_original: Any) -> Any:
    def quick_stop(self: Firmware, *, hold: bool = True) -> None:
        self._enter(State.SWITCH_ON_DISABLED)

    return quick_stop


def _still_switching(original: Any) -> Any:
    def enter(self: Firmware, state: State) -> None:
        on = self.core.command.pwm_enabled
        original(self, state)
        if state is State.SWITCH_ON_DISABLED:
            self.core.command.pwm_enabled = on

    return enter


def _drops_a_key(original: Any) -> Any:
    def store(self: Firmware) -> None:
        original(self)
        self._stored.pop("K_i_speed", None)

    return store


def _keeps_defaults(_original: Any) -> Any:
    def load(self: Firmware) -> bool:
        return True

    return load


def _takes_anything(original: Any) -> Any:
    def raw(entry: Entry, data: bytes) -> Number:
        from dataclasses import replace

        found: Number = original(replace(entry, minimum=None, maximum=None), data)
        return found

    return raw


def _never_locked(original: Any) -> Any:
    def accept(self: ObjectStore, entry: Entry, data: bytes) -> Number:
        is_on, self._power_stage_is_on = self._power_stage_is_on, lambda: False
        try:
            found: Number = original(self, entry, data)
        finally:
            self._power_stage_is_on = is_on
        return found

    return accept


def _velocity_off(original: Any) -> Any:
    def wire(self: Firmware) -> None:
        original(self)
        self.objects.compute("velocity_actual", lambda: round(self.objects["omega_m"] * 1e3 * 1.05))

    return wire


def _torque_off(original: Any) -> Any:
    def wire(self: Firmware) -> None:
        original(self)
        self.objects.compute(
            "torque_actual", lambda: round(self.objects["torque"] / self.objects["T_N"] * 1e3 / 1.06)
        )

    return wire


def _never_limited(original: Any) -> Any:
    return lambda self: original(self) & ~(1 << 11)


def _slow_heartbeat(original: Any) -> Any:
    return lambda self: 2 * original(self)


def _a_tick_late(original: Any) -> Any:
    return lambda **fields: original(**{**fields, "first_tick": (fields["first_tick"] + 1) % 2**32})


def _numbered_once(original: Any) -> Any:
    def control(self: Any, raw: Number) -> None:
        before = self._sequence
        original(self, raw)
        self._sequence = max(1, before)

    return control


COMMANDS: Final = (
    Mutant(
        "quick_stop_coasts",
        "a quick stop that lets the shaft coast",
        substitutions=of_firmware("_quick_stop", _coasting),
    ),
    Mutant(
        "quick_stop_endless",
        "a quick stop that never switches off",
        substitutions=of_firmware("_at_the_end_of_a_quick_stop", lambda _: lambda _self: False),
    ),
    Mutant("halt_ignored", "halt does nothing", substitutions=of_firmware("_set_halt", nothing)),
    Mutant(
        "disable_keeps_switching",
        "a power stage that stays on when the drive is disabled",
        substitutions=of_firmware("_enter", _still_switching),
    ),
    Mutant(
        "nmt_stop_ignored", "NMT stop leaves the power stage on", substitutions=of_firmware("stop", nothing)
    ),
    Mutant(
        "save_drops_a_key",
        "a save that drops one parameter",
        substitutions=of_firmware("_store", _drops_a_key),
    ),
    Mutant("save_ignored", "a save that stores nothing", substitutions=of_firmware("_store", nothing)),
    Mutant(
        "restore_ignored", "defaults that are not restored", substitutions=of_firmware("_restore", nothing)
    ),
    Mutant(
        "stored_not_loaded",
        "stored parameters that are not in force after power-up",
        substitutions=of_firmware("_load_parameters", _keeps_defaults),
    ),
    Mutant(
        "limits_not_checked",
        "parameters beyond their limits are taken",
        substitutions=(Substitution(objects, "_raw", _takes_anything),),
    ),
    Mutant(
        "never_locked",
        "locked parameters are taken while the power stage is on",
        substitutions=(Substitution(ObjectStore, "_accept", _never_locked),),
    ),
    Mutant(
        "velocity_actual_off", "0x606C is 5 % too high", substitutions=of_firmware("_wire_402", _velocity_off)
    ),
    Mutant("torque_actual_off", "0x6077 is 6 % too low", substitutions=of_firmware("_wire_402", _torque_off)),
    Mutant(
        "never_limited",
        "a statusword that never tells of a limit",
        substitutions=of_firmware("_statusword", _never_limited),
    ),
    Mutant(
        "heartbeat_slow",
        "a heartbeat of twice the period",
        substitutions=(Substitution(DriveNode, "_heartbeat_ticks", _slow_heartbeat),),
    ),
    Mutant(
        "capture_late",
        "captures that are stamped a tick late",
        substitutions=(Substitution(capture_objects, "CaptureHeader", _a_tick_late),),
    ),
    Mutant(
        "captures_not_counted",
        "a number of captures that stays at 1",
        substitutions=(Substitution(capture_objects.CaptureObjects, "_control", _numbered_once),),
    ),
)
"""Defects of commands, parameters and objects."""
