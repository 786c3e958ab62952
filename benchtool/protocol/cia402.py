"""The CiA 402 power drive state machine as total functions, for the host and for the drive.

Sources: CiA 402-2 (IEC 61800-7-201), "Finite state automaton of the power drive system": the coding of the
statusword 0x6041, the command coding of the controlword 0x6040, and the transitions 0 to 16. Transitions that
the drive makes by itself (0, 1, 13, 14 and the end of a quick stop) are not caused by a controlword and
belong to the firmware. Transition 16, optional there, is not supported.
"""

from __future__ import annotations

from enum import StrEnum

from benchtool.errors import ValueRefused

_FAULT_RESET_BIT = 0x80


class State(StrEnum):
    """States of the power drive system; the value is the display name."""

    NOT_READY_TO_SWITCH_ON = "not ready to switch on"
    SWITCH_ON_DISABLED = "switch on disabled"
    READY_TO_SWITCH_ON = "ready to switch on"
    SWITCHED_ON = "switched on"
    OPERATION_ENABLED = "operation enabled"
    QUICK_STOP_ACTIVE = "quick stop active"
    FAULT_REACTION_ACTIVE = "fault reaction active"
    FAULT = "fault"
    UNKNOWN = "unknown"

    @property
    def power_stage_on(self) -> bool:
        """Whether the inverter may be switching."""
        return self in (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE, State.FAULT_REACTION_ACTIVE)


class Command(StrEnum):
    """Commands of the controlword."""

    SHUTDOWN = "shutdown"
    SWITCH_ON = "switch on"
    ENABLE_OPERATION = "enable operation"
    DISABLE_VOLTAGE = "disable voltage"
    QUICK_STOP = "quick stop"
    DISABLE_OPERATION = "disable operation"
    FAULT_RESET = "fault reset"

    @property
    def controlwords(self) -> tuple[int, ...]:
        """What to write, in this order; two words for the fault reset, which is an edge of bit 7."""
        return _CONTROLWORDS[self]


_CONTROLWORDS = {
    Command.SHUTDOWN: (0x06,),
    Command.SWITCH_ON: (0x07,),
    Command.ENABLE_OPERATION: (0x0F,),
    Command.DISABLE_VOLTAGE: (0x00,),
    Command.QUICK_STOP: (0x02,),
    Command.DISABLE_OPERATION: (0x07,),
    Command.FAULT_RESET: (0x00, _FAULT_RESET_BIT),
}

# State, its mask of the statusword, and the value.
_STATUS_CODING = (
    (State.NOT_READY_TO_SWITCH_ON, 0x4F, 0x00),
    (State.SWITCH_ON_DISABLED, 0x4F, 0x40),
    (State.READY_TO_SWITCH_ON, 0x6F, 0x21),
    (State.SWITCHED_ON, 0x6F, 0x23),
    (State.OPERATION_ENABLED, 0x6F, 0x27),
    (State.QUICK_STOP_ACTIVE, 0x6F, 0x07),
    (State.FAULT_REACTION_ACTIVE, 0x4F, 0x0F),
    (State.FAULT, 0x4F, 0x08),
)
_STATUS_BITS = {state: bits for state, _, bits in _STATUS_CODING}

# Command, its mask of the controlword, and the value. "Switch on" and "disable operation"
# share one code; the state tells which is meant.
_COMMAND_CODING = (
    (Command.SHUTDOWN, 0x87, 0x06),
    (Command.SWITCH_ON, 0x8F, 0x07),
    (Command.ENABLE_OPERATION, 0x8F, 0x0F),
    (Command.DISABLE_VOLTAGE, 0x82, 0x00),
    (Command.QUICK_STOP, 0x86, 0x02),
)

# Effect of a command in a state, with the number of the transition.
_TRANSITIONS = {
    (State.SWITCH_ON_DISABLED, Command.SHUTDOWN): State.READY_TO_SWITCH_ON,  # 2
    (State.READY_TO_SWITCH_ON, Command.SWITCH_ON): State.SWITCHED_ON,  # 3
    (State.READY_TO_SWITCH_ON, Command.ENABLE_OPERATION): State.OPERATION_ENABLED,  # 3 and then 4
    (State.READY_TO_SWITCH_ON, Command.DISABLE_VOLTAGE): State.SWITCH_ON_DISABLED,  # 7
    (State.READY_TO_SWITCH_ON, Command.QUICK_STOP): State.SWITCH_ON_DISABLED,  # 7
    (State.SWITCHED_ON, Command.ENABLE_OPERATION): State.OPERATION_ENABLED,  # 4
    (State.SWITCHED_ON, Command.SHUTDOWN): State.READY_TO_SWITCH_ON,  # 6
    (State.SWITCHED_ON, Command.DISABLE_VOLTAGE): State.SWITCH_ON_DISABLED,  # 10
    (State.SWITCHED_ON, Command.QUICK_STOP): State.SWITCH_ON_DISABLED,  # 10
    (State.OPERATION_ENABLED, Command.SWITCH_ON): State.SWITCHED_ON,  # 5, as "disable operation"
    (State.OPERATION_ENABLED, Command.SHUTDOWN): State.READY_TO_SWITCH_ON,  # 8
    (State.OPERATION_ENABLED, Command.DISABLE_VOLTAGE): State.SWITCH_ON_DISABLED,  # 9
    (State.OPERATION_ENABLED, Command.QUICK_STOP): State.QUICK_STOP_ACTIVE,  # 11
    (State.QUICK_STOP_ACTIVE, Command.DISABLE_VOLTAGE): State.SWITCH_ON_DISABLED,  # 12
}

# The states a host can ask for, by height: how much of the power system is on.
_HEIGHT = {
    State.SWITCH_ON_DISABLED: 0,
    State.READY_TO_SWITCH_ON: 1,
    State.SWITCHED_ON: 2,
    State.OPERATION_ENABLED: 3,
}
_ONE_UP = {
    State.SWITCH_ON_DISABLED: Command.SHUTDOWN,
    State.READY_TO_SWITCH_ON: Command.SWITCH_ON,
    State.SWITCHED_ON: Command.ENABLE_OPERATION,
}
_STRAIGHT_DOWN = {
    State.SWITCH_ON_DISABLED: Command.DISABLE_VOLTAGE,
    State.READY_TO_SWITCH_ON: Command.SHUTDOWN,
    State.SWITCHED_ON: Command.DISABLE_OPERATION,
}

COMMANDABLE: frozenset[State] = frozenset(_HEIGHT) | {State.QUICK_STOP_ACTIVE}


def state_of(statusword: int) -> State:
    """Return the state coded in a statusword; UNKNOWN for a pattern that the standard does not define. Never
    raises."""
    for state, mask, bits in _STATUS_CODING:
        if statusword & mask == bits:
            return state
    return State.UNKNOWN


def next_command(state: State, target: State) -> Command | None:
    """Return the host's next command on the way from `state` to `target`.

    None where nothing is to be sent: the target is reached, the drive must first leave a transient or unknown
    state by itself, or no command leads there (only COMMANDABLE states can be asked for, and a quick stop
    only of an enabled drive). Out of a fault the way leads through the fault reset.
    """
    if state is target or target not in COMMANDABLE:
        return None
    if state is State.FAULT:
        return Command.FAULT_RESET if target in _HEIGHT else None
    if target is State.QUICK_STOP_ACTIVE:
        return Command.QUICK_STOP if state is State.OPERATION_ENABLED else None
    if state is State.QUICK_STOP_ACTIVE:
        return Command.DISABLE_VOLTAGE
    if state not in _HEIGHT:
        return None
    return _ONE_UP[state] if _HEIGHT[state] < _HEIGHT[target] else _STRAIGHT_DOWN[target]


def transition(state: State, controlword: int, previous_controlword: int) -> State:
    """Return the drive's state after a controlword was written.

    Args:
        state: state before.
        controlword: the value written; the bits of the operation mode (4 to 6) and halt (8) play no part.
        previous_controlword: the value before, against which bit 7 shows a rising edge.
    """
    if state is State.FAULT:
        rising = controlword & ~previous_controlword & _FAULT_RESET_BIT
        return State.SWITCH_ON_DISABLED if rising else state  # 15
    for command, mask, bits in _COMMAND_CODING:
        if controlword & mask == bits:
            return _TRANSITIONS.get((state, command), state)
    return state


def statusword(
    state: State,
    *,
    voltage_enabled: bool = False,
    warning: bool = False,
    remote: bool = True,
    target_reached: bool = False,
    internal_limit: bool = False,
) -> int:
    """Return the statusword of a drive in `state`: bits 0 to 3, 5 and 6 from the state, bits 4, 7, 9, 10 and
    11 given.

    Raises:
        ValueRefused: UNKNOWN, which is what a host may see but no drive can be in.
    """
    if state is State.UNKNOWN:
        raise ValueRefused("no statusword tells the state 'unknown': give a state of the drive")
    flags = (voltage_enabled, 4), (warning, 7), (remote, 9), (target_reached, 10), (internal_limit, 11)
    return _STATUS_BITS[state] | sum(1 << bit for on, bit in flags if on)
