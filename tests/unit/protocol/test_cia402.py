"""The CiA 402 state machine: every statusword, every state, every controlword."""

from __future__ import annotations

import itertools

import pytest

from benchtool.errors import ValueRefused
from benchtool.protocol.cia402 import (
    COMMANDABLE,
    Command,
    State,
    next_command,
    state_of,
    statusword,
    transition,
)

DRIVE_STATES = [state for state in State if state is not State.UNKNOWN]
HEIGHT = [
    State.SWITCH_ON_DISABLED,
    State.READY_TO_SWITCH_ON,
    State.SWITCHED_ON,
    State.OPERATION_ENABLED,
]

# CiA 402-2, state coding, as it is printed: bits 6, 5, 3, 2, 1, 0; x counts for nothing.
PRINTED = {
    "0x 0000": State.NOT_READY_TO_SWITCH_ON,
    "1x 0000": State.SWITCH_ON_DISABLED,
    "01 0001": State.READY_TO_SWITCH_ON,
    "01 0011": State.SWITCHED_ON,
    "01 0111": State.OPERATION_ENABLED,
    "00 0111": State.QUICK_STOP_ACTIVE,
    "0x 1111": State.FAULT_REACTION_ACTIVE,
    "0x 1000": State.FAULT,
}


def printed_state(word: int) -> State:
    bits = f"{word >> 6 & 1}{word >> 5 & 1} {word & 15:04b}"
    found = [
        state
        for pattern, state in PRINTED.items()
        if all(p in ("x", b) for p, b in zip(pattern, bits, strict=True))
    ]
    assert len(found) <= 1
    return found[0] if found else State.UNKNOWN


def test_state_of_every_statusword() -> None:
    by_low_byte = {low: printed_state(low) for low in range(256)}
    assert all(state_of(word) is by_low_byte[word & 0xFF] for word in range(0x10000))
    assert set(by_low_byte.values()) == set(State)


@pytest.mark.parametrize("state", DRIVE_STATES)
def test_statusword_tells_its_state_whatever_the_flags(state: State) -> None:
    for voltage, warning, remote, reached, limit in itertools.product((False, True), repeat=5):
        word = statusword(
            state,
            voltage_enabled=voltage,
            warning=warning,
            remote=remote,
            target_reached=reached,
            internal_limit=limit,
        )
        assert state_of(word) is state
        assert [bool(word >> bit & 1) for bit in (4, 7, 9, 10, 11)] == [
            voltage,
            warning,
            remote,
            reached,
            limit,
        ]
        assert word < 0x1000


def test_no_statusword_for_unknown() -> None:
    with pytest.raises(ValueRefused, match="unknown"):
        statusword(State.UNKNOWN)


def test_next_command_is_total_over_statuswords_and_targets() -> None:
    for target in State:
        answers = {word: next_command(state_of(word), target) for word in range(0x10000)}
        assert {type(answer) for answer in answers.values()} <= {Command, type(None)}
        if target not in COMMANDABLE:
            assert set(answers.values()) == {None}


def drive(state: State, command: Command, previous: int) -> tuple[State, int]:
    """The drive's state after a command's words, and the last word."""
    for word in command.controlwords:
        state, previous = transition(state, word, previous), word
    return state, previous


@pytest.mark.parametrize("target", HEIGHT)
@pytest.mark.parametrize("previous", [0x0000, 0x0006, 0x000F, 0x0080, 0xFFFF])
@pytest.mark.parametrize("start", [*HEIGHT, State.QUICK_STOP_ACTIVE, State.FAULT])
def test_host_walks_a_drive_from_every_state_to_every_target(
    start: State, previous: int, target: State
) -> None:
    state = start
    for _ in range(6):
        command = next_command(state_of(statusword(state)), target)
        if command is None:
            break
        state, previous = drive(state, command, previous)
    assert state is target


@pytest.mark.parametrize("state", [State.NOT_READY_TO_SWITCH_ON, State.FAULT_REACTION_ACTIVE, State.UNKNOWN])
def test_host_waits_in_a_transient_state(state: State) -> None:
    assert {next_command(state, target) for target in State} == {None}


def test_quick_stop_is_asked_of_an_enabled_drive_only() -> None:
    asked = {state: next_command(state, State.QUICK_STOP_ACTIVE) for state in State}
    assert asked.pop(State.OPERATION_ENABLED) is Command.QUICK_STOP
    assert set(asked.values()) == {None}


def test_a_disable_never_passes_through_a_higher_state() -> None:
    for start, target in itertools.combinations(reversed(HEIGHT), 2):
        command = next_command(start, target)
        assert command is not None
        assert drive(start, command, 0)[0] is target


def test_fault_leaves_only_on_a_rising_edge() -> None:
    for previous, word in itertools.product((0x00, 0x0F, 0x80, 0x8F), range(0x100)):
        after = transition(State.FAULT, word, previous)
        rising = bool(word & 0x80) and not previous & 0x80
        assert after is (State.SWITCH_ON_DISABLED if rising else State.FAULT)


def test_fault_reset_is_an_edge_on_the_wire() -> None:
    assert drive(State.FAULT, Command.FAULT_RESET, 0x0080)[0] is State.SWITCH_ON_DISABLED


def test_no_controlword_starts_a_drive_past_its_fault_or_out_of_its_own_transitions() -> None:
    for word in range(0x10000):
        for previous in (0x0000, 0x0080):
            for state in (State.NOT_READY_TO_SWITCH_ON, State.FAULT_REACTION_ACTIVE):
                assert transition(state, word, previous) is state
            assert transition(State.FAULT, word, previous) in (State.FAULT, State.SWITCH_ON_DISABLED)
            assert transition(State.SWITCH_ON_DISABLED, word, previous) in HEIGHT[:2]


# Printed as bits 7, 3, 2, 1, 0 of the controlword, with the transitions that CiA 402-2 numbers.
COMMANDS = {
    "0x110": {2: (0, 1), 6: (2, 1), 8: (3, 1)},
    "00111": {3: (1, 2), 5: (3, 2)},
    "01111": {4: (2, 3)},
    "0xx0x": {7: (1, 0), 9: (3, 0), 10: (2, 0)},
    "0x01x": {7: (1, 0), 10: (2, 0)},
}


@pytest.mark.parametrize("pattern", COMMANDS)
def test_every_controlword_of_a_command_makes_its_transitions(pattern: str) -> None:
    for word in range(0x10000):
        bits = f"{word >> 7 & 1}{word & 15:04b}"
        if all(p in ("x", b) for p, b in zip(pattern, bits, strict=True)):
            for before, after in COMMANDS[pattern].values():
                assert transition(HEIGHT[before], word, 0) is HEIGHT[after]


def test_enable_operation_of_a_ready_drive_passes_through_switched_on() -> None:
    assert transition(State.READY_TO_SWITCH_ON, 0x0F, 0x06) is State.OPERATION_ENABLED


def test_controlwords_on_the_wire() -> None:
    assert {command: command.controlwords for command in Command} == {
        Command.SHUTDOWN: (0x06,),
        Command.SWITCH_ON: (0x07,),
        Command.ENABLE_OPERATION: (0x0F,),
        Command.DISABLE_VOLTAGE: (0x00,),
        Command.QUICK_STOP: (0x02,),
        Command.DISABLE_OPERATION: (0x07,),
        Command.FAULT_RESET: (0x00, 0x80),
    }


def test_quick_stop_of_an_enabled_drive_and_its_end_by_disable_voltage() -> None:
    assert transition(State.OPERATION_ENABLED, 0x02, 0x0F) is State.QUICK_STOP_ACTIVE
    assert transition(State.QUICK_STOP_ACTIVE, 0x0F, 0x02) is State.QUICK_STOP_ACTIVE
    assert transition(State.QUICK_STOP_ACTIVE, 0x00, 0x02) is State.SWITCH_ON_DISABLED


def test_power_stage_is_on_only_where_torque_may_be() -> None:
    assert {state for state in State if state.power_stage_on} == {
        State.OPERATION_ENABLED,
        State.QUICK_STOP_ACTIVE,
        State.FAULT_REACTION_ACTIVE,
    }
