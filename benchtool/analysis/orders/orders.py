"""Orders: what a signal repeats per mechanical revolution, such as cogging and torque ripple."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from benchtool.analysis.declaration import Analysis, Findings, NoSettings, Quantity
from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.analysis.orders.angle import AngleCoverage, angle_coverage
from benchtool.analysis.orders.angle_orders import sector_means
from benchtool.analysis.orders.order_spectrum import (
    FEWEST_REVOLUTIONS,
    LARGEST_WOBBLE_RAD,
    OrderSpectrum,
    fitted_orders,
    resampled_orders,
)
from benchtool.analysis.periods import track_angle
from benchtool.analysis.uncertainty import Uncertainty
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.errors import AnalysisError

_LARGEST_LISTED = 10
_SECTORS = 72
_FEWEST_TO_REPEAT = 4  # revolutions
_STANDS_OUT = 4.5  # standard uncertainties: by chance once in a hundred records of 200 orders (Rayleigh)
_SMALLEST_MEAN = 1e-3  # of the largest order: below it "percent of mean" says nothing


@dataclass(frozen=True)
class Orders:
    """Result of `order_analysis`: NAME_order_largest, NAME_order_K, table NAME_orders.

    Measurements are of the largest ten orders that stand out of the noise, by more than 4.5 standard
    uncertainties; the table has all.
    """

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    spectrum: OrderSpectrum


def order_analysis(
    block: Block,
    channel: str,
    name: str = "torque",
    *,
    angle: str = "theta_m",
    pole_pairs: int | None = None,
    slots: int | None = None,
) -> Orders:
    """Orders of one channel of a recording with a mechanical angle, over at least two revolutions.

    In steady state the channel is resampled to equal steps of a smooth track of the angle, and the DFT over
    whole revolutions gives the orders (`resampled_orders`). Where rows are missing, the speed changes or the
    angle wobbles about that track by more than 1.5 mrad rms, sines are fitted on the measured angle instead
    (`fitted_orders`). The definition of each number says which.

    Args:
        block: any recording; gaps are allowed.
        channel: what to analyse.
        name: what the measurements and the table are named after ("torque", "current").
        angle: the channel with the mechanical angle, rad, wrapped or not.
        pole_pairs: p, to say in the definitions what an order is.
        slots: Q of the stator, for the same.

    Raises:
        AnalysisError: no such channel, a dead signal, fewer than two mechanical revolutions.
    """
    try:
        spectrum = resampled_orders(block, channel, angle)
    except AnalysisError:  # a gap, another speed: no hindrance to what needs no time, which refuses the rest
        spectrum = _by_angle(block, channel, angle)
    return describe_orders(spectrum, name, pole_pairs, slots)


def _by_angle(block: Block, channel: str, angle: str) -> OrderSpectrum:
    coverage = angle_coverage(block.column(angle), angle)
    if coverage.revolutions < FEWEST_REVOLUTIONS:
        raise AnalysisError(
            f"'{angle}' covers {coverage.revolutions:.2f} mechanical revolutions, at least "
            f"{FEWEST_REVOLUTIONS:g} are needed for orders: record a longer window"
        )
    if coverage.resolution_rad > LARGEST_WOBBLE_RAD:  # then the steps of the angle are no wobble
        try:
            return resampled_orders(block, channel, angle, coverage.resolution_rad)
        except AnalysisError:
            pass
    basis = Basis(len(block.data), block.sample_rate_Hz, gaps=len(block.gaps))
    return fitted_orders(
        coverage, block.column(channel), channel, block.unit(channel), angle, basis, _wobble_rad(coverage)
    )


def _wobble_rad(coverage: AngleCoverage) -> float:
    """Rms of what repeats in every revolution of the angle's deviation from a smooth track, and of its noise.

    The rotor may turn like that, or the encoder err: 0 where time or coverage do not tell.
    """
    try:
        track = track_angle(coverage.angle_rad, 1)
    except AnalysisError:
        return 0.0
    numbers = np.arange(track.samples, dtype=np.float64)
    forwards = math.copysign(1.0, float(coverage.angle_rad[-1] - coverage.angle_rad[0]))
    deviation = forwards * coverage.angle_rad - track.at(numbers)
    mean, _ = sector_means(coverage, deviation, _SECTORS)
    repeated = max(0.0, float(np.nanvar(mean)) - coverage.resolution_rad**2 / 12.0)
    if coverage.revolutions < _FEWEST_TO_REPEAT:
        repeated = 0.0
    # from sample to sample only noise of the angle changes; that of its steps is taken into account elsewhere
    noise = 0.5 * float(np.mean(np.diff(deviation) ** 2)) if coverage.resolution_rad == 0.0 else 0.0
    return math.sqrt(repeated + noise)


def describe_orders(
    spectrum: OrderSpectrum, name: str, pole_pairs: int | None = None, slots: int | None = None
) -> Orders:
    """The spectrum as measurements and a table, named after `name`; see `Orders`."""
    highest = int(spectrum.order[-1])
    what = f"{spectrum.signal} per mechanical revolution, by {spectrum.method}"
    shares = f"in percent of |mean| {abs(spectrum.mean):.6g} {spectrum.unit} and of the largest"
    listed = [order for order in map(int, spectrum.largest) if _stands_out(spectrum, order)]
    measurements = [
        _largest(spectrum, name, f"of orders 1 to {highest} of {what}", listed),
        *(
            Measurement(
                f"{name}_order_{order}",
                float(spectrum.amplitude[order - 1]),
                spectrum.unit,
                f"peak amplitude of order {order}{_parenthesis(order, pole_pairs, slots)} of {what}",
                spectrum.basis,
                Uncertainty(
                    float(spectrum.standard[order - 1]),
                    spectrum.uncertainty_source,
                    float(spectrum.dof[order - 1]),
                ),
            )
            for order in listed[:_LARGEST_LISTED]
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
    )
    return Orders(tuple(measurements), (table,), spectrum)


def _stands_out(spectrum: OrderSpectrum, order: int) -> bool:
    """Whether an order is more than the largest that noise makes of some hundred."""
    amplitude, standard = spectrum.amplitude[order - 1], spectrum.standard[order - 1]
    return bool(amplitude > _STANDS_OUT * standard)


def _largest(spectrum: OrderSpectrum, name: str, which: str, listed: list[int]) -> Measurement:
    text = f"order with the largest peak amplitude above {_STANDS_OUT:g} standard uncertainties, {which}"
    if listed:
        return Measurement(f"{name}_order_largest", float(listed[0]), "", text, spectrum.basis)
    reason = "no order stands out of the noise"
    return Measurement.undefined(f"{name}_order_largest", "", text, reason, spectrum.basis)


def order_meaning(order: int, pole_pairs: int | None = None, slots: int | None = None) -> str:
    """What a machine with these pole pairs and slots has at that order, or nothing.

    Cogging is at multiples of the least common multiple of slots and poles (Hanselman, Brushless Permanent
    Magnet Motor Design); ripple of the phase harmonics 6m - 1 and 6m + 1 at 6m times the pole pairs.
    """
    meanings = []
    if pole_pairs is not None and order % pole_pairs == 0:
        multiple = order // pole_pairs
        if multiple == 1:
            meanings.append("electrical fundamental, p")
        elif multiple % 6 == 0:
            meanings.append(f"{multiple}p, phase harmonics {multiple - 1} and {multiple + 1}")
        else:
            meanings.append(f"{multiple}p, electrical harmonic")
    if slots is not None and pole_pairs is not None and order % (lcm := math.lcm(slots, 2 * pole_pairs)) == 0:
        meanings.append(f"{_times(order // lcm)}cogging, lcm of {slots} slots and {2 * pole_pairs} poles")
    elif slots is not None and order % slots == 0:
        meanings.append(f"{_times(order // slots)}slots")
    if order == 1 and not meanings:
        meanings.append("once per revolution")
    return "; ".join(meanings)


def _times(multiple: int) -> str:
    return "" if multiple == 1 else f"{multiple} x "


def _parenthesis(order: int, pole_pairs: int | None, slots: int | None) -> str:
    meaning = order_meaning(order, pole_pairs, slots)
    return f" ({meaning})" if meaning else ""


def _rows(spectrum: OrderSpectrum) -> Iterator[tuple[float, ...]]:
    largest, mean = float(spectrum.amplitude.max()), abs(spectrum.mean)
    of_mean = 100.0 / mean if mean > _SMALLEST_MEAN * largest else math.nan
    of_largest = 100.0 / largest if largest > 0.0 else math.nan
    for order, amplitude, standard in zip(spectrum.order, spectrum.amplitude, spectrum.standard, strict=True):
        value = float(amplitude)
        yield float(order), value, of_mean * value, of_largest * value, float(standard)


def _orders_of(channel: str, name: str, unit: str) -> Analysis[NoSettings]:
    """The analysis of a channel's orders under the names NAME_order_largest and NAME_order_K."""

    def measure(window: Window, _: NoSettings) -> Findings:
        theta_m = np.unwrap(window.block.column("theta_m"))
        if abs(float(theta_m[-1] - theta_m[0])) < FEWEST_REVOLUTIONS * 2.0 * np.pi:
            return Findings(())
        slots = None if window.motor is None else window.motor.slots
        found = order_analysis(window.block, channel, name, pole_pairs=window.pole_pairs, slots=slots)
        return Findings(found.measurements, found.tables, found)

    return Analysis(
        name=f"{name}_orders",
        title=f"{name} orders",
        measure=measure,
        quantities=(
            Quantity(
                (f"{name}_order_largest",),
                "",
                "order with the largest amplitude, of orders 1 to 200 or to where the data end; undefined "
                "where none stands out",
            ),
            Quantity(
                (f"{name}_order_K",),
                unit,
                "peak amplitude of order K, for the ten largest that stand out",
                pattern=rf"{name}_order_[1-9]\d*",
            ),
        ),
        settings=NoSettings,
        channels=("theta_m", channel),
    )


TORQUE_ORDERS: Final = _orders_of("torque", "torque", "Nm")
SPEED_ORDERS: Final = _orders_of("omega_m", "speed", "rad/s")
