"""Steps run on a drive: planned, played, captured, estimated; on every exit it is disabled and restored."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType

from benchtool.analysis import Measurement
from benchtool.block import Block
from benchtool.commission.excitation import Excitation, require_bearable
from benchtool.commission.known import Known
from benchtool.commission.steps.encoder import DraggedRotor
from benchtool.commission.steps.flux_linkage import BackEmf
from benchtool.commission.steps.inductance import TurningVoltage
from benchtool.commission.steps.mechanics import Reversals
from benchtool.commission.steps.offsets import Offsets
from benchtool.commission.steps.preflight import Preflight
from benchtool.commission.steps.resistance import StandingCurrents
from benchtool.commission.steps.step import Finding, Step, Trial
from benchtool.drive import Capability, Capture, RemoteDrive, play
from benchtool.drive.parameters import held
from benchtool.errors import (
    AnalysisError,
    BenchError,
    CaptureError,
    DriveFault,
    SdoAbort,
    SetUpError,
    StimulusError,
    UsageError,
    ValueRefused,
)
from benchtool.profile import Profile
from benchtool.protocol import Mode, State
from benchtool.protocol.dictionary import Role, Value, setting_of

STEPS: tuple[Step, ...] = (
    Preflight(),
    Offsets(),
    StandingCurrents(),
    DraggedRotor(),
    TurningVoltage(),
    BackEmf(),
    Reversals(),
)
"""Every step, in the order in which they are run."""

_QUIET: Mapping[str, Value] = MappingProxyType({"quick_stop_option": "disable"})
_OF_THE_LINK = (0x3210, 0x3220)  # error codes
_AT_REST = 0.01  # of the rated speed
_LONGEST_BRAKING_S, _BRAKING_POLL_S = 5.0, 0.02
_FAIL_A_STEP = (AnalysisError, CaptureError, DriveFault, SdoAbort, StimulusError, ValueRefused)


class StepVerdict(StrEnum):
    """What became of a step."""

    PASS = "pass"
    FAIL = "fail"
    SKIPPED = "skipped"


@dataclass(frozen=True)
class StepResult:
    """One step: its verdict with a reason, the parameters that it is for, what it estimated and found, and
    the heat in the winding in J, as planned with the resistance known then."""

    name: str
    sets: tuple[str, ...]
    verdict: StepVerdict
    reason: str = ""
    estimates: Mapping[str, Measurement] = field(default_factory=lambda: MappingProxyType({}))
    findings: tuple[Finding, ...] = ()
    planned_J: float = 0.0


@dataclass(frozen=True)
class Commissioning:
    """What was run, in order; `known` is the nameplate it began with."""

    results: tuple[StepResult, ...]
    known: Known

    @property
    def passed(self) -> bool:
        """Whether every step passed, and nothing was found that is not as it should be."""
        return all(each.verdict is StepVerdict.PASS and not each.findings for each in self.results)


def steps_for(names: Sequence[str]) -> tuple[Step, ...]:
    """Return the steps of these names and those that they need, in order; all without a name.

    Raises:
        UsageError: there is no such step.
    """
    by_name = {step.name: step for step in STEPS}
    wanted: set[str] = set()
    pending = list(names) or list(by_name)
    while pending:
        name = pending.pop()
        if name not in by_name:
            raise UsageError(f"there is no step '{name}': {', '.join(by_name)} are known; name one of them")
        wanted.add(name)
        pending += [each for each in by_name[name].needs if each not in wanted]
    return tuple(step for step in STEPS if step.name in wanted)


def planned(steps: Sequence[Step], known: Known) -> dict[str, tuple[Excitation, ...]]:
    """Return what every step would play by what is known now, checked for its heat.

    Raises:
        ValueRefused: a step would warm the winding too much.
    """
    found = {}
    for step in steps:
        found[step.name] = step.plan(known)
        require_bearable(found[step.name], known.motor)
    return found


def commission(
    drive: RemoteDrive, profile: Profile, steps: Sequence[Step], note: Callable[[str], None] = lambda _: None
) -> Commissioning:
    """Run steps on a connected drive, with the profile as the nameplate.

    The drive holds what the profile states for as long as this lasts, and what it held before afterwards:
    nothing is kept. A step that fails leaves out those that need it; the others are run. A fault stays until
    it is reset.

    Args:
        note: takes a line of progress.

    Raises:
        CapabilityMissing: the drive cannot play or capture; nothing was sent.
        ValueRefused: a step would warm the winding too much by the nameplate, or the profile states what the
            drive cannot have.
        LinkError, StateError, WriteNotVerified: the drive does not answer as it should; it is disabled, or
            will stop by itself.
    """
    drive.capabilities.require(
        Capability.STIMULUS, Capability.CAPTURE, Capability.SUPERVISED, purpose="a commissioning"
    )
    results: list[StepResult] = []
    with held(drive, {**_stated(drive, profile), **_QUIET}):
        _leave_fault_of_the_link(drive, note)
        known = Known.of(drive, profile.motor)
        planned(steps, known)
        for step in steps:
            result = _attempt(drive, step, known, results, note)
            results.append(result)
            if result.verdict is StepVerdict.PASS:
                known = known.with_estimates(result.estimates)
    return Commissioning(tuple(results), known)


def _attempt(
    drive: RemoteDrive, step: Step, known: Known, before: Sequence[StepResult], note: Callable[[str], None]
) -> StepResult:
    failed = [
        each.name for each in before if each.name in step.needs and each.verdict is not StepVerdict.PASS
    ]
    if failed:
        return StepResult(step.name, step.sets, StepVerdict.SKIPPED, f"it needs {', '.join(failed)}")
    excitations = step.plan(known)
    require_bearable(excitations, known.motor)
    heat_J = sum(each.energy_J(known.R_s_ohm) for each in excitations)
    try:
        blocks = []
        for each in excitations:
            note(f"{step.name}: {each.name}")
            blocks.append(_played(drive, each, known))
        estimates = step.estimate(blocks, known)
        if isinstance(step, Trial):
            estimates = {**estimates, **step.attempt(drive, known)}
    except SetUpError as wrong:
        found = (Finding(wrong.what, wrong.cause, wrong.remedy),)
        return StepResult(step.name, step.sets, StepVerdict.FAIL, wrong.what, {}, found, heat_J)
    except _FAIL_A_STEP as reason:
        return StepResult(step.name, step.sets, StepVerdict.FAIL, str(reason), planned_J=heat_J)
    findings = step.findings(estimates, known)
    fatal = next((each for each in findings if each.fails), None)
    if fatal is not None:
        return StepResult(step.name, step.sets, StepVerdict.FAIL, fatal.what, {}, findings, heat_J)
    return StepResult(step.name, step.sets, StepVerdict.PASS, "", estimates, findings, heat_J)


def _played(drive: RemoteDrive, excitation: Excitation, known: Known) -> Block:
    """Play one excitation with its parameters in force; the drive is disabled when this returns or raises."""
    with ExitStack() as stack:
        stack.enter_context(held(drive, excitation.parameters))
        if excitation.stimulus is None:
            capture = Capture(drive, excitation.request)
            capture.wait()
            return capture.read()
        mode = excitation.stimulus.modes[-1]  # a d-current plays at a speed
        stack.enter_context(drive.enabled(mode))
        if mode is Mode.VELOCITY:
            drive.write("omega_m_command", excitation.omega_m_rad_s)
            drive.wait(excitation.settle_s)
        block = play(drive, excitation.stimulus, excitation.request, motor=known.motor)
        if mode is Mode.VELOCITY:
            _bring_to_rest(drive, known)
    if block is None:
        raise BenchError(f"the excitation '{excitation.name}' was not captured")
    return block


def _leave_fault_of_the_link(drive: RemoteDrive, note: Callable[[str], None]) -> None:
    """Reset a fault of the dc link's voltage where that is within the profile's limits, which are in force:
    the drive came with others."""
    if drive.state() is not State.FAULT or drive.optional_number(Role.ERROR_CODE) not in _OF_THE_LINK:
        return
    if drive.number("u_dc_min") <= drive.number("u_dc") <= drive.number("u_dc_max"):
        note("the dc link is within the limits of the profile, not within those that the drive had")
        drive.reset_fault()
        drive.emergencies()


def _bring_to_rest(drive: RemoteDrive, known: Known) -> None:
    """Have the speed controller brake, so that the next excitation finds a shaft at rest; a shaft that does
    not come to rest is left to coast."""
    drive.write("omega_m_command", 0.0)
    slow_rad_s = _AT_REST * known.motor.omega_m_N_rad_s
    waited_s = 0.0
    while abs(drive.number("omega_m")) > slow_rad_s and waited_s < _LONGEST_BRAKING_S:
        drive.wait(_BRAKING_POLL_S)
        waited_s += _BRAKING_POLL_S


def _stated(drive: RemoteDrive, profile: Profile) -> dict[str, Value]:
    """Return what the profile states, by the dictionary's names; what this drive has not is left out.

    Raises:
        ValueRefused: a value that the drive's parameter cannot have.
    """
    return {
        setting_of(drive.dictionary, key, value).name: value
        for key, value in profile.stated_parameters.items()
    }
