"""Whether it is safe to spin: what the drive reads at rest, and its two ways to stop, both tried."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from benchtool.analysis import Basis, Contribution, Measurement, combined
from benchtool.block import Block
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.nameplate import probable_cause
from benchtool.commission.saving import through_a_loss
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.step import Finding
from benchtool.drive import Capability, CaptureRequest, RemoteDrive
from benchtool.errors import SetUpError
from benchtool.profile import Motor
from benchtool.protocol import Mode, State

_ROWS = 500
_LARGEST_READING = 0.25  # of the rated current, peak, without current
_STEADY = 0.05  # of the dc link
_LINK_SHARE = 0.9  # of what the EMF at the rated speed needs
_SPUN = 0.4  # of the rated speed, to which later steps spin
_HOTTEST_DEGC = 100.0
_LIMITS = ("i_trip", "u_dc", "u_dc_min", "u_dc_max", "omega_m_trip")
_OVERLOAD = 1.1
_OFF, _NEAR = 1.3, 0.1  # of a rotor flux that is another one; of a factor between conventions
_TOO_MUCH = 4.0  # times the rated torque, that the rated current makes by the rotor flux
_SLACK_S, _POLL_S = 0.5, 0.01  # of the supervision of the link
_ALIVE_S = 0.2


class Preflight:
    """Read what can be read with the power stage off, then see the drive stop by itself, at zero current.

    The heartbeat of the host is withheld once while the drive is enabled: it has to switch off within the
    time that is configured. Then a quick stop has to switch it off as well. The supervision is armed as
    before in between.
    """

    name = "preflight"
    needs: tuple[str, ...] = ()
    sets: tuple[str, ...] = ()

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a capture with the power stage off."""
        return (Excitation("at rest", None, CaptureRequest((*CURRENTS, "u_dc"), _ROWS)),)

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `u_dc`.

        Raises:
            SetUpError: what is read is not that of a motor at rest on a dc link that suits it.
        """
        (block,) = blocks
        _require_rated_current(known, float(known.held.get("i_trip", math.inf)))
        for phase, channel in zip("abc", CURRENTS, strict=True):
            reading = float(block.column(channel).mean())
            if abs(reading) > _LARGEST_READING * known.I_N_A:
                raise SetUpError(
                    f"the current of output {phase} reads {reading:.4g} A with the power stage off, "
                    f"the rated "
                    f"one is {known.I_N_A:.4g} A peak",
                    "the shaft is being turned, the sensor or its supply is broken, or the rated "
                    "current is wrong",
                    "hold the shaft still, check the sensor and motor.I_N_A_rms of the profile",
                )
        u_dc = block.column("u_dc")
        mean, scatter = float(u_dc.mean()), float(u_dc.std())
        if scatter > _STEADY * mean:
            raise SetUpError(
                f"the dc link reads {mean:.4g} V and varies by {scatter:.3g} V rms with the power stage off",
                "a supply without capacitor, a loose contact, or a broken sensor",
                "check the supply and its cables",
            )
        _require_link(mean, known)
        lines = [
            Contribution("scatter", "A", scatter / math.sqrt(len(u_dc)), len(u_dc) - 1.0),
            Contribution("step of the converter of the dc link", "B", known.link_step_V / math.sqrt(12.0)),
        ]
        basis = Basis(samples=len(u_dc), sample_rate_Hz=1.0 / known.control_period_s)
        u = combined([each for each in lines if each.standard > 0.0], "scatter and converter")
        return {"u_dc": Measurement("u_dc", mean, "V", "mean with the power stage off", basis, u)}

    def attempt(self, drive: RemoteDrive, known: Known) -> Mapping[str, Measurement]:
        """Try the ways to stop; return `link_loss_time`.

        Raises:
            SetUpError: limits that do not protect, a drive that does not stop by itself.
            DriveFault: it cannot be enabled.
        """
        drive.check()
        mode = Mode.CURRENT if drive.capabilities.findings[Capability.STIMULUS].available else Mode.TORQUE
        _require_limits(drive, known)
        _require_cool(drive)
        with through_a_loss(drive):
            stopped_s = _withhold_heartbeat(drive, mode)
        _try_quick_stop(drive, mode)
        u = combined([Contribution("polling", "B", _POLL_S / math.sqrt(12.0))], "polling")
        definition = "from the last heartbeat of the host to the power stage off"
        return {"link_loss_time": Measurement("link_loss_time", stopped_s, "s", definition, uncertainty=u)}

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return whether the dc link suits the rated speed."""
        u_dc, needed = found["u_dc"].value, _needed_V(known, 1.0)
        if u_dc >= _LINK_SHARE * needed:
            return ()
        return (
            Finding(
                f"the dc link is {u_dc:.4g} V, the rated speed needs {needed:.4g} V",
                "the dc link is too low, or rated speed, rotor flux or pole pairs of the nameplate are wrong",
                "raise the supply's voltage, or check motor.omega_m_N_rad_s, psi_r_Wb and pole_pairs",
                fails=False,
                withholds=False,  # every step stays below half of the rated speed
            ),
        )


def _needed_V(known: Known, share: float) -> float:
    """Return the dc link that the EMF at a share of the rated speed needs, sqrt(3) p psi_r omega."""
    motor = known.motor
    return math.sqrt(3.0) * motor.pole_pairs * motor.psi_r_Wb * share * motor.omega_m_N_rad_s


def _require_link(u_dc_V: float, known: Known) -> None:
    needed = _needed_V(known, _SPUN) + math.sqrt(3.0) * known.motor.R_s_ohm * known.I_N_A
    if u_dc_V < needed:
        looks = _flux_by_torque(known.motor, known.I_N_A)
        raise SetUpError(
            f"the dc link is {u_dc_V:.4g} V, {needed:.4g} V are needed for {_SPUN:.0%} of the rated speed",
            f"{looks}, or the dc link is too low"
            if looks
            else "the dc link is too low, or rated speed, rotor flux or pole pairs are stated wrong",
            "check motor.omega_m_N_rad_s, psi_r_Wb and pole_pairs, or raise the supply's voltage",
        )


def _flux_by_torque(motor: Motor, I_N_A: float) -> str:
    """Return what the nameplate's rotor flux looks like beside that by which the rated current makes the
    rated torque; empty where the two agree, or are apart by no telling factor."""
    of_torque_Wb = motor.T_N_Nm / (1.5 * motor.pole_pairs * I_N_A)
    if motor.psi_r_Wb < _OFF * of_torque_Wb:
        return ""
    return probable_cause("psi_r", of_torque_Wb, motor, _NEAR)


def _require_limits(drive: RemoteDrive, known: Known) -> None:
    """Check that the limits of the drive are armed and belong to this motor, of a drive that has them."""
    if not all(name in drive.dictionary for name in _LIMITS):
        return
    motor = known.motor
    i_trip, least, most = (drive.number(name) for name in ("i_trip", "u_dc_min", "u_dc_max"))
    range_A = drive.number("i_full_scale") if "i_full_scale" in drive.dictionary else math.inf
    _require_rated_current(known, i_trip, range_A)
    if not drive.number("omega_m_trip") > 0.5 * motor.omega_m_N_rad_s:
        raise SetUpError(
            f"the drive trips at {drive.number('omega_m_trip'):.4g} rad/s, half of the rated speed is "
            f"{0.5 * motor.omega_m_N_rad_s:.4g} rad/s",
            "omega_m_trip is too low, or the rated speed too high",
            "check drive.parameters.omega_m_trip_rad_s and motor.omega_m_N_rad_s of the profile",
        )
    u_dc = drive.number("u_dc")
    if not least <= u_dc <= most:
        raise SetUpError(
            f"the dc link is {u_dc:.4g} V, the drive's limits are {least:.4g} V and {most:.4g} V",
            "the dc link is too low or too high, or limits of another supply",
            "set the supply's voltage, or u_dc_min_V and u_dc_max_V in [drive.parameters] of the profile",
        )


def _require_rated_current(known: Known, i_trip_A: float, range_A: float = math.inf) -> None:
    """Check that the rated current is one that the drive bears and measures, and that fits the rated
    torque."""
    motor, cause = known.motor, "the rated current is stated too high, by a factor of ten or in another unit"
    remedy = "check motor.I_N_A_rms of the profile against the nameplate, and i_trip_A with it"
    if i_trip_A < _OVERLOAD * known.I_N_A:
        raise SetUpError(
            f"the drive trips at {i_trip_A:.4g} A, the rated current is {known.I_N_A:.4g} A peak",
            "the rated current is too high (peak taken for rms, or another motor), or i_trip is too low",
            "check motor.I_N_A_rms and drive.parameters.i_trip_A of the profile",
        )
    if max(known.I_N_A, i_trip_A) > range_A:
        raise SetUpError(
            f"the rated current is {known.I_N_A:.4g} A peak and the drive trips at {i_trip_A:.4g} A, its "
            f"sensors read up to {range_A:.4g} A",
            cause,
            remedy,
        )
    makes_Nm = 1.5 * motor.pole_pairs * motor.psi_r_Wb * known.I_N_A
    heat_W = 1.5 * motor.R_s_ohm * known.I_N_A**2
    if makes_Nm > _TOO_MUCH * motor.T_N_Nm and heat_W > motor.T_N_Nm * motor.omega_m_N_rad_s:
        raise SetUpError(
            f"the rated current of {known.I_N_A:.4g} A peak makes {makes_Nm:.4g} Nm and {heat_W:.4g} W of "
            f"heat, the rated torque is {motor.T_N_Nm:.4g} Nm",
            cause,
            remedy,
        )


def _require_cool(drive: RemoteDrive) -> None:
    """Check the temperatures that the drive tells of, if any."""
    for variable in drive.dictionary:
        if "temperature" not in variable.name or variable.unit != "degC" or not variable.readable:
            continue
        if variable.role == "parameter":  # a level
            continue
        if (reading := drive.number(variable.name)) > _HOTTEST_DEGC:
            raise SetUpError(
                f"{variable.label} is {reading:.0f} degC, at most {_HOTTEST_DEGC:.0f} degC is expected",
                "motor or drive are hot, or the sensor is not connected",
                "let them cool down, or check the sensor",
            )


def _withhold_heartbeat(drive: RemoteDrive, mode: Mode) -> float:
    """Enable at zero current or torque, fall silent, and return after which time the drive had switched
    off."""
    drive.enable(mode)
    timeout_s = drive.supervision.timeout_s
    drive.stop_heartbeat()
    silent_s = drive.clock.now_s()
    try:
        while drive.state().power_stage_on:
            if drive.clock.now_s() - silent_s > timeout_s + _SLACK_S:
                raise SetUpError(
                    f"the drive is still on {timeout_s + _SLACK_S:g} s after the host's last heartbeat, it "
                    f"is to switch off after {timeout_s:g} s",
                    "the supervision of the link does not act (objects 0x1016 and 0x6007)",
                    "do not spin this motor before the drive's firmware or its configuration is corrected",
                )
            drive.clock.wait(_POLL_S)
        return drive.clock.now_s() - silent_s
    finally:
        drive.disable()
        drive.supervise()
        drive.clock.wait(_ALIVE_S)
        if drive.state() is State.FAULT:
            drive.reset_fault()
        drive.emergencies()  # the loss of this host is not one to report


def _try_quick_stop(drive: RemoteDrive, mode: Mode) -> None:
    with drive.enabled(mode):
        drive.quick_stop()
        silent_s = drive.clock.now_s()
        while drive.state().power_stage_on:
            if drive.clock.now_s() - silent_s > _SLACK_S:
                raise SetUpError(
                    f"the drive is still on {_SLACK_S:g} s after a quick stop",
                    "quick_stop_option or the firmware keeps it on",
                    "do not spin this motor before a quick stop switches the drive off",
                )
            drive.clock.wait(_POLL_S)
