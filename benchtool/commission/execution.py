"""Steps run on a drive: planned, played, captured, estimated; on every exit it is disabled and restored."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import replace
from functools import partial
from itertools import chain
from types import MappingProxyType

from benchtool.block import Block
from benchtool.commission.excitation import Excitation, require_bearable
from benchtool.commission.known import Known
from benchtool.commission.objects import objects_missing, without
from benchtool.commission.planned_energy import planned_energy
from benchtool.commission.playing import played, spent_J
from benchtool.commission.recorder import StepRecorder
from benchtool.commission.results import Commissioning, StepResult, StepVerdict
from benchtool.commission.saving import save, settings_by_key, trial
from benchtool.commission.steps.connections import Connections
from benchtool.commission.steps.current_control import CurrentControl
from benchtool.commission.steps.encoder import DraggedRotor
from benchtool.commission.steps.flux_linkage import BackEmf
from benchtool.commission.steps.inductance import TurningVoltage
from benchtool.commission.steps.mechanics import Reversals
from benchtool.commission.steps.offsets import Offsets
from benchtool.commission.steps.preflight import Preflight
from benchtool.commission.steps.resistance import StandingCurrents
from benchtool.commission.steps.ripple_run import RippleRun
from benchtool.commission.steps.saturation import Pulses
from benchtool.commission.steps.speed_control import SpeedControl
from benchtool.commission.steps.step import (
    FaultTelling,
    Finding,
    LoopStep,
    RefinedStep,
    StagedStep,
    Step,
    Trial,
)
from benchtool.commission.steps.verification import Verification
from benchtool.document import closest
from benchtool.drive import Capability, RemoteDrive
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
    of_each,
)
from benchtool.profile import Profile
from benchtool.protocol import State
from benchtool.protocol.dictionary import Role, Value, setting_of, toml_key

STEPS: tuple[Step, ...] = (
    Preflight(),
    Offsets(),
    Connections(),
    StandingCurrents(),
    DraggedRotor(),
    TurningVoltage(),
    Pulses(),
    BackEmf(),
    Reversals(),
    CurrentControl(),
    SpeedControl(),
    RippleRun(),
    Verification(),
)
"""Every step, in the order in which they are run."""

_QUIET: Mapping[str, Value] = MappingProxyType({"quick_stop_option": "disable"})
_OF_THE_LINK = (0x3210, 0x3220)  # error codes
_FAIL_A_STEP = (AnalysisError, CaptureError, DriveFault, SdoAbort, StimulusError, ValueRefused)


def steps_for(names: Sequence[str]) -> tuple[Step, ...]:
    """Return the steps of these names and those that they need, in order; all without a name.

    Raises:
        UsageError: there is no such step.
    """
    by_name = {step.name: step for step in STEPS}
    wanted: set[str] = set()
    pending = list(names) or list(by_name)
    of_each(partial(_known_step, list(by_name)), dict.fromkeys(pending))
    while pending:
        name = pending.pop()
        wanted.add(name)
        pending += [each for each in by_name[name].needs if each not in wanted]
    return tuple(step for step in STEPS if step.name in wanted)


def _known_step(known: Sequence[str], name: str) -> str:
    """Return the name of a step.

    Raises:
        UsageError: there is no such step.
    """
    if name not in known:
        raise UsageError(f"there is no step '{name}': {closest(name, list(known))}")
    return name


def _too_far(excitations: Sequence[Excitation], known: Known) -> str:
    """Return why excitations cannot be played where the shaft may not turn on and on; empty if they can."""
    if math.isinf(known.travel_rad) or not any(each.mode_of_speed for each in excitations):
        return ""
    return f"it holds the shaft at a speed, and that may turn {known.travel_rad:.4g} rad only"


def planned(steps: Sequence[Step], known: Known) -> dict[str, tuple[Excitation, ...]]:
    """Return what every step would play by what is known now, checked for its heat.

    Raises:
        ValueRefused: a step would warm the winding too much.
    """
    found = {}
    for step in steps:
        excitations = step.plan(known)
        found[step.name] = () if _too_far(excitations, known) else excitations
        require_bearable(found[step.name], known.motor)
    return found


def _tell_energy(steps: Sequence[Step], known: Known, note: Callable[[str], None]) -> None:
    """Say what the steps to come will take, now that the resistance is known."""
    with suppress(ValueRefused):  # the step itself says why
        energy = planned_energy(chain(*planned(steps, known).values()), known)
        note(f"the steps to come take {energy.value_J:.3g} J by R_s = {known.R_s_ohm:.4g} ohm")


def commission(
    drive: RemoteDrive,
    profile: Profile,
    steps: Sequence[Step],
    note: Callable[[str], None] = lambda _: None,
    *,
    recorder: StepRecorder | None = None,
    keep: bool = False,
    force: bool = False,
    travel_rad: float = math.inf,
    watching: AbstractContextManager[object] | None = None,
    ended: Callable[[StepResult], None] = lambda _: None,
) -> Commissioning:
    """Run steps on a connected drive, with the profile as the nameplate.

    A step is left out, with the reason, that takes objects which the drive has not; a drive that captures
    nothing has its ways to stop tried. The drive holds what the
    profile states for as long as this lasts, and what it held before afterwards. A
    step that fails leaves out those that need it; the others are run. A fault stays until it is reset. With
    `keep`, and if every step passed and found nothing wrong, the drive then stores what was estimated.

    Args:
        note: takes a line of progress.
        recorder: records each step, and has those that an earlier session has finished.
        keep: have the drive store the parameters.
        force: store them although something was found that is not as it should be.
        travel_rad: how far the shaft may turn, either way, from where it stands; steps that hold it at a
            speed are then left out.
        watching: entered while steps are run, as a stream that is shown live.
        ended: takes the result of each step that is over, or was in an earlier session.

    Raises:
        CapabilityMissing: the drive cannot be supervised, or cannot store; nothing was sent.
        ValueRefused: a step would warm the winding too much by the nameplate, or the profile states what the
            drive cannot have.
        LinkError, StateError, WriteNotVerified: the drive does not answer as it should; it is disabled, or
            will stop by itself.
        RecordingError: a step cannot be recorded.
    """
    drive.capabilities.require(Capability.SUPERVISED, purpose="a commissioning")
    if reason := without(drive, Capability.CAPTURE):
        known = Known(profile.motor, profile.control_period_s, math.nan)
        tried = tuple(_without_capture(drive, each, known, reason, note) for each in steps)
        return Commissioning(tried, known, not_saved="nothing was found")
    if keep:
        drive.capabilities.require(Capability.STORAGE, purpose="keeping what a commissioning finds")
    stated = stated_parameters(drive, profile)
    results: list[StepResult] = []
    note("putting in force what the profile states")
    with watching or nullcontext(), trial(drive), held(drive, {**stated, **_QUIET}):
        _leave_fault_of_the_link(drive, note)
        began = known = replace(Known.of(drive, profile), travel_rad=travel_rad)
        planned(steps, known)
        for place, step in enumerate(steps):
            done = recorder.finished(step) if recorder is not None else None
            if done is not None:
                note(f"{step.name}: already there")
            result = done or _attempt(drive, step, known, results, note, recorder)
            results.append(result)
            ended(result)
            if result.verdict is StepVerdict.PASS:
                known = known.with_estimates(result.estimates)
                if "R_s" in step.sets:
                    _tell_energy(steps[place + 1 :], known, note)
    values = {**stated, **known.in_force}
    found = Commissioning(tuple(results), began, settings_by_key(drive, values))
    if not keep:
        return replace(found, not_saved="it was not asked for")
    if reason := _why_not(found, force=force):
        return replace(found, not_saved=reason)
    note("writing, reading back and storing the parameters")
    save(drive, values)
    return replace(found, saved=True)


def _why_not(found: Commissioning, *, force: bool) -> str:
    """Return why the parameters are not to be stored; empty if they are."""
    unfinished = [each.name for each in found.results if each.verdict is not StepVerdict.PASS]
    if unfinished:
        failed = any(each.verdict is StepVerdict.FAIL for each in found.results)
        return f"{', '.join(unfinished)} {'did not pass' if failed else 'were left out'}"
    wrong = [finding.what for each in found.results for finding in each.findings if finding.withholds]
    if force or not wrong:
        return ""
    return f"something is not as it should be ({wrong[0]}); correct it, or use --force"


def _attempt(
    drive: RemoteDrive,
    step: Step,
    known: Known,
    before: Sequence[StepResult],
    note: Callable[[str], None],
    recorder: StepRecorder | None,
) -> StepResult:
    failed = [
        each.name for each in before if each.name in step.needs and each.verdict is not StepVerdict.PASS
    ]
    if failed:
        return StepResult(step.name, step.sets, StepVerdict.SKIPPED, f"it needs {', '.join(failed)}")
    with nullcontext() if recorder is None else recorder.recording(step):
        result = _run(drive, step, known, note, recorder)
        if recorder is not None:
            after = known.with_estimates(result.estimates)
            recorder.finish(result, step.loops(after) if isinstance(step, LoopStep) else ())
    return result


def _run(
    drive: RemoteDrive, step: Step, known: Known, note: Callable[[str], None], recorder: StepRecorder | None
) -> StepResult:
    """Return the result of a step, that of its last round where its captures tell how to play it better."""
    result, blocks = _round(drive, step, known, note, recorder)
    rounds = 1
    while blocks and result.verdict is StepVerdict.FAIL and isinstance(step, RefinedStep):
        more = step.refined(blocks, known) if rounds < step.most_rounds else {}
        if not more:
            break
        rounds += 1
        note(f"{step.name}: again with what it has shown, round {rounds} of at most {step.most_rounds}")
        if recorder is not None:
            recorder.next_round()
        known, planned_J, spent = known.with_estimates(more), result.planned_J, result.spent_J
        result, blocks = _round(drive, step, known, note, recorder)
        estimates = {**more, **result.estimates} if result.estimates else {}
        result = replace(
            result,
            estimates=estimates,
            planned_J=planned_J + result.planned_J,
            spent_J=spent + result.spent_J,
        )
    return result


def _round(
    drive: RemoteDrive, step: Step, known: Known, note: Callable[[str], None], recorder: StepRecorder | None
) -> tuple[StepResult, Sequence[Block]]:
    """Play a step once; return what became of it and the captures that its findings rest on, none where it
    did not come to them."""
    result = StepResult(step.name, step.sets, StepVerdict.FAIL)
    blocks: list[Block] = []
    try:
        excitations = step.plan(known)
        if reason := objects_missing(drive, excitations) or _too_far(excitations, known):
            return replace(result, verdict=StepVerdict.SKIPPED, reason=reason), ()
        require_bearable(excitations, known.motor)
        result = replace(result, planned_J=planned_energy(excitations, known).value_J)
        for each in excitations:
            note(f"{step.name}: {each.name}")
            blocks.append(played(drive, each, known))
            if recorder is not None:
                recorder.append(each.name, blocks[-1])
            if isinstance(step, StagedStep) and step.suffices(blocks[-1], known):
                excitations = excitations[: len(blocks)]
                break
        result = replace(result, spent_J=spent_J(excitations, blocks, known))
        estimates = step.estimate(blocks, known)
        if isinstance(step, Trial):
            estimates = {**estimates, **step.attempt(drive, known)}
    except _FAIL_A_STEP as failure:
        return _failed(result, step, failure, drive, known), ()
    findings = step.findings(estimates, known)
    fatal = next((each for each in findings if each.fails), None)
    if fatal is not None:
        return replace(result, reason=fatal.what, findings=findings), blocks
    passed = replace(
        result,
        verdict=StepVerdict.PASS,
        estimates=estimates,
        findings=findings,
        spent_J=spent_J(excitations, blocks, known.with_estimates(estimates)),
    )
    return passed, blocks


def _failed(
    result: StepResult, step: Step, failure: BenchError, drive: RemoteDrive, known: Known
) -> StepResult:
    """Return the result of a step that cannot go on."""
    if isinstance(failure, SetUpError):
        found = (Finding(failure.what, failure.cause, failure.remedy),)
        return replace(result, reason=failure.what, findings=found)
    if isinstance(failure, DriveFault):
        return replace(result, reason=str(failure), findings=(_of_fault(step, failure, drive, known),))
    return replace(result, reason=str(failure))


def _without_capture(
    drive: RemoteDrive, step: Step, known: Known, reason: str, note: Callable[[str], None]
) -> StepResult:
    """Return the result of a step on a drive that captures nothing: what it tries by itself, if that."""
    result = StepResult(step.name, step.sets, StepVerdict.SKIPPED, reason)
    if not isinstance(step, Trial):
        return result
    if lacking := without(drive, Capability.TORQUE):
        return replace(result, reason=lacking)
    note(f"{step.name}: without a capture")
    try:
        estimates = step.attempt(drive, known)
    except _FAIL_A_STEP as failure:
        return _failed(replace(result, verdict=StepVerdict.FAIL), step, failure, drive, known)
    return replace(
        result, verdict=StepVerdict.PASS, estimates=estimates, reason=f"as far as can be: {reason}"
    )


_CAUSES: Mapping[int, tuple[str, str]] = MappingProxyType(
    {
        0x23: (
            "shorted turns, a nameplate's inductance, flux or rated current that is far off, or an encoder "
            "whose angle is not that of the rotor",
            "check cables and winding, the profile's [motor] and i_trip_A, and the encoder",
        ),
        0x32: (
            "the dc link is too low or too high under load, or its limits are of another supply",
            "check supply and cables, u_dc_min_V and u_dc_max_V of the profile",
        ),
        0x73: (
            "the encoder is not connected, or its signals do not come",
            "check the encoder's cable and supply",
        ),
        0x84: (
            "the speed ran away: encoder or phases the wrong way round, a load that drives the shaft, a "
            "rated speed that is far off, or an encoder that loses counts or has other lines than stated",
            "check the encoder, the load machine, and motor.omega_m_N_rad_s of the profile",
        ),
    }
)


def _of_fault(step: Step, fault: DriveFault, drive: RemoteDrive, known: Known) -> Finding:
    """Return a fault of the drive as a finding, with what probably causes it by the class of its code."""
    cause, remedy = "the drive's own supervision acted", "remove what it reports, then reset the fault"
    with suppress(BenchError):  # the code only tells more
        code = drive.optional_number(Role.ERROR_CODE)
        if code is not None and isinstance(step, FaultTelling) and (more := step.of_fault(code, known)):
            return more
        cause, remedy = _CAUSES.get(0 if code is None else int(code) >> 8, (cause, remedy))
    return Finding(f"the drive tripped in step {step.name}: {fault}", cause, remedy)


def _leave_fault_of_the_link(drive: RemoteDrive, note: Callable[[str], None]) -> None:
    """Reset a fault of the dc link's voltage where that is within the profile's limits, which are in force
    now: the drive came with others."""
    if drive.state() is not State.FAULT or drive.optional_number(Role.ERROR_CODE) not in _OF_THE_LINK:
        return
    if drive.number("u_dc_min") <= drive.number("u_dc") <= drive.number("u_dc_max"):
        note("the dc link is within the limits of the profile, not within those that the drive had")
        drive.reset_fault()
        drive.emergencies()


def stated_parameters(drive: RemoteDrive, profile: Profile) -> dict[str, Value]:
    """Return what the profile states, by the dictionary's names; what this drive has not is left out.

    Raises:
        ValueRefused: a value that the drive's parameter cannot have.
    """
    own = {toml_key(variable) for variable in drive.dictionary}
    return {
        setting_of(drive.dictionary, key, value).name: value
        for key, value in profile.stated_parameters.items()
        if key in own or key not in profile.motor.parameters
    }
