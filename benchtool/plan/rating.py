"""Check of setpoints and stimuli against the motor's rating."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from benchtool.drive import Stimulus
from benchtool.errors import ValueRefused
from benchtool.plan.model import OperatingPoint, Setting
from benchtool.profile import Motor
from benchtool.protocol import Mode

_ONE_SIDED = frozenset({"constant", "step", "staircase", "ramp"})


def beyond_rating(
    point: OperatingPoint,
    stimulus: Stimulus | None,
    motor: Motor,
    parameters: Mapping[str, Setting],
) -> Iterator[tuple[str, str]]:
    """Yield setpoints beyond the rating: the key of the operating point or of the stimulus, and the reason.

    Args:
        point: the operating point.
        stimulus: played by the drive, if any.
        motor: whose rated torque and speed hold.
        parameters: of the drive by TOML key, as the profile and the plan set them.
    """
    torque_Nm, speed_rad_s = motor.T_N_Nm, motor.omega_m_N_rad_s
    for key, value, rated, unit in (
        ("omega_m_rad_s", point.omega_m_rad_s, speed_rad_s, "rad/s"),
        ("hold_speed_rad_s", point.hold_speed_rad_s, speed_rad_s, "rad/s"),
        ("torque_Nm", point.torque_Nm, torque_Nm, "Nm"),
        ("load_torque_Nm", point.load_torque_Nm, torque_Nm, "Nm"),
    ):
        if value is not None and abs(value) > rated:
            yield (
                key,
                f"{key} is {value:g}, the profile rates the motor at {rated:g} {unit}: stay within; "
                f"nothing was sent",
            )
    if stimulus is None:
        return
    try:
        stimulus.require_rated(motor)
        match stimulus.quantity:
            case "torque":
                _require_together(stimulus, point.torque_Nm, torque_Nm)
                _require_within(stimulus, parameters, "torque_limit_Nm")
            case "speed":
                _require_together(stimulus, point.omega_m_rad_s, speed_rad_s)
                allowed = speed_rad_s - abs(point.omega_m_rad_s)
                stimulus.require_within(allowed, "the rated speed less the setpoint")
            case "d_current":
                _require_within(stimulus, parameters, "i_trip_A")
    except ValueRefused as refused:
        yield "stimulus", str(refused)


def require_rated(
    point: OperatingPoint, stimulus: Stimulus | None, motor: Motor, parameters: Mapping[str, Setting]
) -> None:
    """Refuse setpoints that `beyond_rating` finds.

    Raises:
        ValueRefused: a setpoint is beyond the rating; nothing was sent.
    """
    for _, reason in beyond_rating(point, stimulus, motor, parameters):
        raise ValueRefused(reason)


def speed_rad_s(point: OperatingPoint, stimulus: Stimulus | None = None) -> float | None:
    """Return speed at which the steady state of a case is measured; None if the plan does not define it."""
    if stimulus is not None and stimulus.quantity == "speed":
        if stimulus.shape != "constant":
            return None
        return point.omega_m_rad_s + stimulus.offset + stimulus.amplitude
    return point.omega_m_rad_s if point.mode_of_operation is Mode.VELOCITY else point.hold_speed_rad_s


def _require_together(stimulus: Stimulus, setpoint: float, rated: float) -> None:
    """Setpoint and stimulus add up: a shape of one sign may go from one end of the rating to the other."""
    least = 0.0 if stimulus.shape in _ONE_SIDED else -stimulus.amplitude
    ends = (least, stimulus.amplitude)
    reached = max((setpoint + stimulus.offset + end for end in ends), key=abs)
    if abs(reached) > rated:
        raise ValueRefused(
            f"setpoint and stimulus reach {reached:.6g} {stimulus.unit} together, the profile rates the "
            f"motor at {rated:g} {stimulus.unit}: lower one of them; nothing was sent"
        )


def _require_within(stimulus: Stimulus, parameters: Mapping[str, Setting], key: str) -> None:
    limit = parameters.get(key)
    if limit is not None and not isinstance(limit, str):
        stimulus.require_within(limit, f"the drive's {key}")
