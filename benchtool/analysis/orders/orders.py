"""Orders: what a signal repeats per mechanical revolution, such as cogging and torque ripple."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Final

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from pydantic import Field

from benchtool.analysis.declaration import Analysis, Drawing, Findings, Quantity
from benchtool.analysis.measurement import Basis, LineColumn, Measurement, Table
from benchtool.analysis.named_after import named_after
from benchtool.analysis.orders.angle import (
    TURN,
    AngleCoverage,
    angle_coverage,
    few_revolutions,
    least_step_rad,
    unwrapped_angle,
    without_counts,
)
from benchtool.analysis.orders.angle_orders import sector_means
from benchtool.analysis.orders.held_angle import held_angle
from benchtool.analysis.orders.order_spectrum import (
    BY_CHANCE,
    FEWEST_REVOLUTIONS,
    HIGHEST_ORDER,
    LARGEST_WOBBLE_RAD,
    OrderSpectrum,
    Revolutions,
    angle_of,
    counted_of,
    fitted_orders,
    resampled_orders,
    revolutions_of,
)
from benchtool.analysis.orders.orders_of_machine import MACHINE_ORDERS, machine_orders, order_meaning
from benchtool.analysis.orders.wobble import Wobble, repeated_wobble_rad
from benchtool.analysis.orders.wobble_source import WobbleSource, source_of_wobble
from benchtool.analysis.periods import track_angle
from benchtool.analysis.quantisation.resolution import resolution
from benchtool.analysis.sensitivity import Sensitivities
from benchtool.analysis.spectra.flat_crests import crest_is_flat, flat_crest, with_flat_crest
from benchtool.analysis.uncertainty import Uncertainty
from benchtool.analysis.validity import require_finite, require_unheld
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.document import Array, Section
from benchtool.errors import AnalysisError

_LARGEST_LISTED = 10
_CHANNELS: Final = "torque", "omega_m"
_SECTORS = 72
_NEARLY_ALL = 1.4  # half of a variance
_FEWEST_TO_REPEAT, _TURNED_BACK = 4, 0.1  # revolutions
_MAY_BE_MORE = 2.0  # standard uncertainties
_BELOW_THAT = 1.25  # noise alone reads up to 2.45 u in 95 % of records (Rayleigh): U is as much
_NO_SLOTS = "the number of slots is not known: state motor.slots in the profile"
_NOT_TOLD = "too few revolutions to tell noise from the orders: record two at least"
_WANDERS = "the amplitude wanders, and so few revolutions do not tell for how long: record 8 at least"
_SMALLEST_MEAN = 1e-3  # of the largest order: below it "percent of mean" has no meaning


@dataclass(frozen=True)
class Orders:
    """Result of `order_analysis`.

    Measurements are the largest order and its amplitude, NAME_order_largest and NAME_order_largest_amplitude;
    the orders of the machine as far as pole pairs and slots are known, such as NAME_order_6p; and
    NAME_order_K, of the orders that were named or, where none were, of the ten largest that stand out of the
    noise: of noise alone, one does in a hundred records (`OrderSpectrum.stands_out_above`). The table
    NAME_orders has all. Pole pairs and slots are
    those that orders were explained with.
    """

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    spectrum: OrderSpectrum
    pole_pairs: int | None = None
    slots: int | None = None

    def with_flat_crest(self, share: float) -> Orders:
        """Return those of a current that is level at its crests for this share of a period."""
        measurements = tuple(with_flat_crest(each, share) for each in self.measurements)
        reason = crest_is_flat(share)
        tables = tuple(each.without_uncertainty(reason) for each in self.tables)
        return replace(self, measurements=measurements, tables=tables)


def order_analysis(
    block: Block,
    channel: str,
    name: str = "",
    *,
    angle: str = "theta_m",
    pole_pairs: int | None = None,
    slots: int | None = None,
    orders: Sequence[int] | None = None,
    known: Revolutions | None = None,
) -> Orders:
    """Return the orders of one channel of a recording with a mechanical angle, over at least two revolutions.

    In steady state the channel is resampled to equal steps of a smooth track of the angle, and the DFT over
    whole revolutions gives the orders (`resampled_orders`). Where rows are missing, the speed changes or the
    angle wobbles about that track by more than 1.5 mrad rms, sines are fitted on the measured angle instead
    (`fitted_orders`), and where the orders themselves tell whether that wobble is the rotor's, by what they
    tell (`source_of_wobble`). A mean or an amplitude that a curve of few constants explains from revolution
    to revolution is stated at the level of that course (`order_courses`). The definition of each number says
    which.

    Args:
        block: any recording; gaps are allowed.
        channel: what to analyse.
        name: what the measurements and the table are named after; by default the channel, of omega_m "speed".
        angle: the channel with the mechanical angle, rad, wrapped or not.
        pole_pairs: p, to name the cause of an order in the definitions.
        slots: Q of the stator, for the same.
        orders: those to measure; None for the ten largest.
        known: channels that are resampled along the angle already.

    Raises:
        AnalysisError: no such channel, a dead or clipped signal, fewer than two mechanical revolutions.
    """
    require_unheld(block.column(channel), channel, block.unit(channel))
    name = name or named_after(channel)
    found = describe_orders(_spectrum(block, channel, angle, known), name, pole_pairs, slots, orders)
    share = 0.0
    if pole_pairs is not None and block.unit(channel) == "A":
        samples = np.ascontiguousarray(block.column(channel))
        turns = pole_pairs * np.unwrap(block.column(angle)) / (2.0 * np.pi)
        share = flat_crest(samples, turns, resolution(samples))
    return found.with_flat_crest(share) if share else found


def _spectrum(block: Block, channel: str, angle: str, known: Revolutions | None) -> OrderSpectrum:
    """Return the orders along the smooth track or along the angle: the one that the signal turns with, where
    it tells."""
    try:
        smooth, source = _by_time(block, channel, angle, known)
    except AnalysisError:  # a gap or a change of speed: orders by angle do not need time, and refuse the rest
        return _by_angle(block, channel, angle)
    if not source.is_rotor:
        return source.with_what_is_told(smooth)
    return source.with_what_is_told(_by_angle(block, channel, angle))


def _by_time(
    block: Block,
    channel: str,
    angle: str,
    known: Revolutions | None = None,
    largest_wobble_rad: float = LARGEST_WOBBLE_RAD,
) -> tuple[OrderSpectrum, WobbleSource]:
    if known is None or channel not in known.samples:
        known = revolutions_of(block, (channel,), angle, largest_wobble_rad)
    smooth = resampled_orders(block, channel, angle, known=known)
    return smooth, source_of_wobble(np.ascontiguousarray(block.column(channel)), known.track, smooth)


def _by_angle(block: Block, channel: str, angle: str) -> OrderSpectrum:
    lost = held_angle(unwrapped_angle(np.ascontiguousarray(block.column(angle)), angle))
    if np.any(lost):
        block = block.without(lost)
    times = block.ticks().astype(np.float64)
    angle_rad = angle_of(block, angle)
    counted = counted_of(block, channel, angle_rad)
    angle_rad = without_counts(angle_rad, times) if counted is None else counted.angle_rad
    coverage = angle_coverage(angle_rad, angle)
    if few := few_revolutions(coverage.angle_rad, angle, FEWEST_REVOLUTIONS):
        raise AnalysisError(few)
    step_rad = max(coverage.resolution_rad, least_step_rad(block.column(angle)))
    if step_rad > LARGEST_WOBBLE_RAD:  # then the steps of the angle are not a wobble
        try:
            smooth, _ = _by_time(block, channel, angle, None, step_rad)  # steps hide whose a wobble is
        except AnalysisError:
            pass
        else:
            return smooth
    rate_Hz = block.sample_rate_Hz
    basis = Basis(len(block.data), rate_Hz, float(np.ptp(times)) / rate_Hz, gaps=len(block.gaps))
    wobble, source = _wobble_of(coverage, times), WobbleSource()
    if wobble.rms_rad > LARGEST_WOBBLE_RAD:
        try:
            smooth, source = _by_time(block, channel, angle, None, _NEARLY_ALL * wobble.rms_rad)
        except AnalysisError:  # it moves otherwise as well
            pass
        else:
            if source.is_sensor:
                return source.with_what_is_told(smooth)
    values, unit = np.ascontiguousarray(block.column(channel)), block.unit(channel)
    fitted = fitted_orders(coverage, values, channel, unit, angle, basis, wobble, counted)
    return source.with_what_is_told(fitted)


def _wobble_of(coverage: AngleCoverage, times: NDArray[np.float64]) -> Wobble:
    """Return the angle's deviation from a smooth track that repeats every revolution, and its noise.

    Of fewer than four revolutions it is that of all of the deviation. It may be a motion of the rotor or an
    error of the encoder; none where time or coverage do not show it.
    `times` are those of the rows, shape (n,), in any unit.
    """
    try:
        track_angle(coverage.angle_rad, 1)
    except AnalysisError:  # no steady speed, but where it reversed one on the longer way
        way = _longer_way(coverage.angle_rad)
        if way == slice(None) or np.ptp(coverage.angle_rad[way]) < FEWEST_REVOLUTIONS * TURN:
            return Wobble()
        return _wobble_of(angle_coverage(coverage.angle_rad[way]), times[way])
    deviation = coverage.angle_rad - Polynomial.fit(times, coverage.angle_rad, 2)(times)
    mean = windowed = deviation  # few revolutions do not show what repeats: all of it may be the encoder's
    if coverage.revolutions >= _FEWEST_TO_REPEAT:
        # a course that does not repeat is no whole number of cycles, and leaks less under a Hann window
        window = 1.0 - np.cos(TURN * (np.arange(len(times)) + 0.5) / len(times))
        windowed = window * deviation
        mean, _ = sector_means(coverage, windowed, _SECTORS)
    repeated = max(0.0, float(np.nanvar(mean)) - coverage.resolution_rad**2 / 12.0)
    # from sample to sample only noise of the angle changes; that of its steps is taken into account elsewhere
    noise = 0.5 * float(np.mean(np.diff(deviation) ** 2)) if coverage.resolution_rad == 0.0 else 0.0
    return Wobble(math.sqrt(repeated + noise), repeated_wobble_rad(coverage.angle_rad, windowed))


def _longer_way(angle_rad: NDArray[np.float64]) -> slice:
    """Return the rows of an angle, shape (n,), before it turned back for good, or behind that, whichever are
    more; all of them where it did not."""
    at = int(np.argmax(np.abs(angle_rad - angle_rad[0])))
    if abs(angle_rad[-1] - angle_rad[at]) < _TURNED_BACK * TURN:
        return slice(None)
    return slice(0, at + 1) if 2 * at > len(angle_rad) else slice(at, None)


def describe_orders(
    spectrum: OrderSpectrum,
    name: str,
    pole_pairs: int | None = None,
    slots: int | None = None,
    orders: Sequence[int] | None = None,
) -> Orders:
    """Return spectrum as measurements and a table, named after `name`; arguments as of `order_analysis`."""
    highest = int(spectrum.order[-1])
    what = f"{spectrum.signal} per mechanical revolution, by {spectrum.method}"
    shares = f"in percent of |mean| {abs(spectrum.mean):.6g} {spectrum.unit} and of the largest"
    standing_out = [order for order in map(int, spectrum.largest) if _stands_out(spectrum, order)]
    named = standing_out[:_LARGEST_LISTED] if orders is None else orders
    machine = {key: order for key, order in machine_orders(pole_pairs, slots).items() if order is not None}
    measurements = [
        *_largest(spectrum, name, f"of orders 1 to {highest} of {what}", standing_out),
        *(
            _amplitude(spectrum, f"{name}_order_{key}", order, what, pole_pairs, slots)
            for key, order in (*machine.items(), *((str(order), order) for order in dict.fromkeys(named)))
        ),
    ]
    table = Table(
        f"{name}_orders",
        f"peak amplitude of each order of {what}; {shares}; standard uncertainty from the "
        f"{spectrum.uncertainty_source}; orders above {highest} are not excluded and may add to these",
        (
            *(("order", ""), ("amplitude", spectrum.unit), ("percent_of_mean", "%")),
            *(("percent_of_largest", "%"), ("uncertainty", spectrum.unit)),
        ),
        tuple(_rows(spectrum)),
        spectrum.basis,
        lines=(LineColumn("amplitude", "uncertainty", spectrum.signal),),
    )
    return Orders(tuple(measurements), (table,), spectrum, pole_pairs, slots)


def _stands_out(spectrum: OrderSpectrum, order: int) -> bool:
    """Return whether an order exceeds the largest that noise causes among all of them."""
    return bool(spectrum.amplitude[order - 1] > spectrum.stands_out_above[order - 1])


def _largest(
    spectrum: OrderSpectrum, name: str, which: str, standing_out: list[int]
) -> Iterator[Measurement]:
    """Yield the order with the largest amplitude, and that amplitude."""
    number, amplitude = f"{name}_order_largest", f"{name}_order_largest_amplitude"
    text = (
        f"order with the largest peak amplitude that stands out of the noise, as by chance in one of "
        f"{round(1.0 / BY_CHANCE)} records, {which}"
    )
    of_it = f"peak amplitude of the {text}"
    reason = _of_no_largest(spectrum, standing_out)
    if reason:
        yield Measurement.undefined(number, "", text, reason, spectrum.basis)
        none = Measurement.undefined(amplitude, spectrum.unit, of_it, reason, spectrum.basis)
        yield replace(none, below=_most(spectrum))
        return
    order = standing_out[0]
    basis = replace(_at(spectrum, order), order=order)
    unmoved = Sensitivities.unmoved(spectrum.signal).chosen
    why = "it is a whole number: this order is the largest, or another one is"
    yield Measurement(number, float(order), "", text, basis, uncertainty_reason=why, sensitivities=unmoved)
    value, uncertain = float(spectrum.amplitude[order - 1]), _uncertainty(spectrum, order)
    own = Sensitivities.of_line(spectrum.signal, value).chosen
    told = None if order in spectrum.untold else uncertain
    why = _WANDERS if told is None else ""
    yield Measurement(
        amplitude, value, spectrum.unit, of_it, basis, told, uncertainty_reason=why, sensitivities=own
    )


def _most(spectrum: OrderSpectrum) -> float | None:
    """Return what the amplitude of each order is less than; None where that is not known of all."""
    most = float(np.max(spectrum.amplitude + _MAY_BE_MORE * spectrum.standard))
    return most if math.isfinite(most) and not spectrum.untold else None


def _of_no_largest(spectrum: OrderSpectrum, standing_out: list[int]) -> str:
    """Return why it is not known which order is the largest; empty where it is."""
    if not np.any(np.isfinite(spectrum.standard)):
        return _NOT_TOLD
    if not standing_out:
        return "no order stands out of the noise"
    largest = int(spectrum.largest[0])
    if largest != standing_out[0]:
        return (
            f"order {largest} reads {spectrum.amplitude[largest - 1]:.3g} {spectrum.unit}, more than order "
            f"{standing_out[0]}, the largest that stands out of the noise: record more revolutions"
        )
    others = np.setdiff1d(spectrum.order, standing_out) - 1
    most = spectrum.amplitude[others] + _MAY_BE_MORE * spectrum.standard[others]
    larger = others[most > spectrum.amplitude[largest - 1]] + 1
    if not len(larger):
        return ""
    return (
        f"order {larger[0]} does not stand out of the noise and may be larger than order {largest}: record "
        f"more revolutions at an even speed"
    )


def _amplitude(
    spectrum: OrderSpectrum, name: str, order: int, what: str, pole_pairs: int | None, slots: int | None
) -> Measurement:
    """Return the peak amplitude of one order, whether or not it stands out."""
    text = f"peak amplitude of order {order}{_parenthesis(order, pole_pairs, slots)} of {what}"
    highest = int(spectrum.order[-1])
    if order > highest:
        reason = f"orders end at {highest} here: sample faster or turn slower"
        return Measurement.undefined(name, spectrum.unit, text, reason, spectrum.basis)
    if spectrum.step > 0.0 and math.isnan(float(spectrum.standard[order - 1])):
        reason = (
            f"steps of {spectrum.step:.3g} {spectrum.unit} are about as coarse as what {spectrum.signal} "
            f"does, and may hide the order: choose a finer range, or let in noise of half a step"
        )
        return Measurement.undefined(name, spectrum.unit, text, reason, spectrum.basis)
    value, uncertain = float(spectrum.amplitude[order - 1]), _uncertainty(spectrum, order)
    own, basis = Sensitivities.of_line(spectrum.signal, value), _at(spectrum, order)
    if not math.isfinite(uncertain.standard):
        why = _WANDERS if order in spectrum.untold else _NOT_TOLD
        return Measurement(name, value, spectrum.unit, text, basis, uncertainty_reason=why, sensitivities=own)
    return Measurement(name, value, spectrum.unit, text, basis, uncertain, sensitivities=own)


def _at(spectrum: OrderSpectrum, order: int) -> Basis:
    """Return the basis of one order: its frequency is so many times that of the first."""
    first_Hz = spectrum.basis.frequency_Hz
    return replace(spectrum.basis, frequency_Hz=None if first_Hz is None else order * first_Hz)


def _uncertainty(spectrum: OrderSpectrum, order: int) -> Uncertainty:
    """Return the standard uncertainty of an amplitude; wider where noise alone may have made it."""
    if _stands_out(spectrum, order):
        return spectrum.uncertainty(order)
    found = spectrum.uncertainty(order, _BELOW_THAT)
    return replace(found, source=f"{found.source}, x {_BELOW_THAT:g} as noise alone may read that much")


def _parenthesis(order: int, pole_pairs: int | None, slots: int | None) -> str:
    meaning = order_meaning(order, pole_pairs, slots)
    return f" ({meaning})" if meaning else ""


def _rows(spectrum: OrderSpectrum) -> Iterator[tuple[float, ...]]:
    largest, mean = float(spectrum.amplitude.max()), abs(spectrum.mean)
    of_mean = 100.0 / mean if mean > _SMALLEST_MEAN * largest else math.nan
    of_largest = 100.0 / largest if largest > 0.0 else math.nan
    for order, amplitude in zip(spectrum.order, spectrum.amplitude, strict=True):
        value, standard = float(amplitude), _uncertainty(spectrum, int(order)).standard
        yield float(order), value, of_mean * value, of_largest * value, standard


class OrderSettings(Section):
    """The orders to measure beside the largest and those of the machine: `orders = [1, 24]`."""

    orders: Array[Annotated[int, Field(ge=1, le=HIGHEST_ORDER)]] = ()
    """Orders per mechanical revolution that are measured in any case."""


def _few_revolutions(window: Window) -> str:
    require_finite(window.block.column("theta_m"), "theta_m")
    return few_revolutions(np.unwrap(window.block.column("theta_m")), "theta_m", FEWEST_REVOLUTIONS)


def _resampled(window: Window) -> Revolutions | None:
    """Return both channels along the angle; None where one is missing or cannot be resampled."""
    if not set(_CHANNELS) <= set(window.block.names):
        return None
    try:
        return revolutions_of(window.block, _CHANNELS)
    except AnalysisError:  # said by the analysis that it concerns
        return None


def _orders_of(channel: str, name: str, unit: str) -> Analysis[OrderSettings]:
    """Return the analysis of a channel's orders, measurements named after `name`."""

    def measure(window: Window, settings: OrderSettings) -> Findings:
        if few := window.cached(_few_revolutions):
            return analysis.undefined(window.block, settings, few)
        slots = None if window.motor is None else window.motor.slots
        found = order_analysis(
            window.block,
            channel,
            name,
            pole_pairs=window.pole_pairs,
            slots=slots,
            orders=settings.orders,
            known=window.cached(_resampled),
        )
        unknown = tuple(
            Measurement.undefined(
                f"{name}_order_{key}", unit, f"peak amplitude of order {key} of {channel}", _NO_SLOTS
            )
            for key, order in machine_orders(window.pole_pairs, slots).items()
            if order is None
        )
        return Findings((*found.measurements, *unknown), found.tables, found)

    analysis = Analysis(
        name=f"{name}_orders",
        title=f"{name} orders",
        measure=measure,
        quantities=(
            Quantity(
                (f"{name}_order_largest",),
                "",
                "order with the largest amplitude, of orders 1 to 200 or to where the data end; undefined "
                "where none stands out, or one that does not is larger",
            ),
            Quantity(
                (f"{name}_order_largest_amplitude",),
                unit,
                "peak amplitude of that order; where that is not told, below the greatest of amplitude and "
                "twice its standard uncertainty",
            ),
            Quantity(
                tuple(f"{name}_order_{key}" for key in MACHINE_ORDERS),
                unit,
                "peak amplitude of order p, 2p, 6p, 12p, of the number of slots, of lcm(slots, 2p)",
            ),
            Quantity(
                (f"{name}_order_K",),
                unit,
                f"peak amplitude of order K, of those that `orders` of `[analyses.{name}_orders]` names; the "
                f"level of its course, where a drift, a step, an exponential or a swing explains it",
                pattern=rf"{name}_order_([1-9]\d*)",
                numbers="orders",
            ),
        ),
        settings=OrderSettings,
        fewest_revolutions=FEWEST_REVOLUTIONS,
        channels=("theta_m", channel),
        figures=(
            Drawing(
                f"{name}_orders",
                f"Orders of {name}",
                f"Peak amplitude of the orders of {name}, per mechanical revolution; grey is twice the "
                f"standard uncertainty of each, from which a true order stands out.",
            ),
        ),
    )
    return analysis


TORQUE_ORDERS: Final = _orders_of(_CHANNELS[0], "torque", "Nm")
SPEED_ORDERS: Final = _orders_of(_CHANNELS[1], "speed", "rad/s")
