"""The layout of the viewer for a drive: a panel for all there is to show, with nothing to arrange first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import rerun.blueprint as rrb

from benchtool.block import Channel
from benchtool.live import names
from benchtool.live.panels.locus import NEEDED
from benchtool.live.panels.spectrum import chosen

_MARKERS = (names.ERROR, names.WARNING, names.TRIGGER)
_FOLLOWED_S = 20.0
_TOGETHER = rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal)  # to zoom one plot is to zoom all
_COLLAPSED = rrb.PlotLegend(visible=False)  # it would cover the data; the key and the pointer tell names


@dataclass(frozen=True)
class Layout:
    """What a recording holds, channels by source (`names.STREAM` ...).

    `psi_Wb` is the radius of the flux plane's circle; `followed` shows the last seconds before the cursor,
    else everything is shown; `states` adds a band of the drive's states.
    """

    stream: tuple[Channel, ...] = ()
    capture: tuple[Channel, ...] = ()
    transducer: tuple[Channel, ...] = ()
    psi_Wb: float = 0.0
    followed: bool = True
    states: bool = False

    def with_source(self, source: str, channels: tuple[Channel, ...]) -> Layout:
        """Return the layout with the channels of one source."""
        match source:
            case names.STREAM:
                return replace(self, stream=channels)
            case names.CAPTURE:
                return replace(self, capture=channels)
        return replace(self, transducer=channels)

    def sources(self) -> dict[str, tuple[Channel, ...]]:
        """Return the channels by source, of the sources that there are."""
        every = {names.STREAM: self.stream, names.CAPTURE: self.capture, names.TRANSDUCER: self.transducer}
        return {source: channels for source, channels in every.items() if channels}

    @property
    def flux_plane(self) -> bool:
        """Whether there are flux vectors to show."""
        return any(set(NEEDED) <= _names(channels) for channels in self.sources().values())

    @property
    def spectrum(self) -> bool:
        """Whether there is a channel whose spectrum is shown."""
        return any(chosen(tuple(_names(channels))) for channels in self.sources().values())


def blueprint(layout: Layout) -> rrb.Blueprint:
    """Return the layout as Rerun's blueprint: signals on the left, shapes and spectra in the middle, words
    right."""
    left: list[rrb.View | rrb.Container | None] = [
        rrb.TextDocumentView(origin=names.KEY, name="key", titlebar=False),
        _plot(layout, {"torque": "torque (Nm)"}, (names.TORQUE_BAND, names.CAPTURE_BAND, *_MARKERS)),
        _plot(layout, {"current": "phase currents (A)", "current_vector": "current vector (A)"}),
        _beside(
            _plot(layout, {"speed": "speed (rad/s)"}),
            _plot(layout, {"flux": "stator flux (Wb)", "flux_vector": "stator flux vector (Wb)"}),
        ),
        _plot(layout, {"voltage": "voltage (V)"}) if not layout.flux_plane else None,
    ]
    middle: list[rrb.View | rrb.Container | None] = [
        _flux_plane(layout) if layout.flux_plane else None,
        rrb.Tabs(_spectrum(), _waterfall()) if layout.spectrum else None,
        _harmonics() if layout.spectrum else None,
    ]
    right: list[rrb.View | rrb.Container | None] = [
        rrb.Tabs(
            rrb.TextDocumentView(origin=names.RESULTS, name="results"),
            rrb.TextDocumentView(origin=names.PARAMETERS, name="parameters"),
        ),
        rrb.TextLogView(
            origin=names.EVENTS,
            name="state, faults and events",
            columns=rrb.TextLogColumns(
                timeline_columns=[_timeline_column()],
                text_log_columns=["LogLevel", "Body"],
            ),
        ),
        rrb.StateTimelineView(origin=names.STATE, name="state") if layout.states else None,
        rrb.Tabs(
            rrb.TextDocumentView(origin=names.COUNTERS, name="data quality"),
            rrb.TimeSeriesView(
                origin=names.QUALITY,
                name="data quality over time",
                plot_legend=_COLLAPSED,
                axis_x=_TOGETHER,
                time_ranges=_range(layout),
            ),
        ),
    ]
    return rrb.Blueprint(
        rrb.Horizontal(
            _column(left, [0.9, 3.0, 3.0, 2.0, 2.0]),
            _column(middle, [4.0, 2.5, 2.5]),
            _column(right, [5.0, 3.5, 1.5, 2.5]),
            column_shares=[4.8, 3.2, 4.0],
        ),
        rrb.TimePanel(state="collapsed", timeline=names.DRIVE_TIME, play_state="following"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
        auto_views=False,
        auto_layout=False,
    )


def _timeline_column() -> rrb.encodings.TimelineColumn:
    return rrb.encodings.TimelineColumn(names.DRIVE_TIME)


def _column(parts: Iterable[rrb.View | rrb.Container | None], shares: list[float]) -> rrb.Vertical:
    kept = [(part, share) for part, share in zip(parts, shares, strict=False) if part is not None]
    return rrb.Vertical(*(part for part, _ in kept), row_shares=[share for _, share in kept])


def _beside(*parts: rrb.View | None) -> rrb.Horizontal | None:
    kept = [part for part in parts if part is not None]
    return rrb.Horizontal(*kept) if kept else None


def _plot(
    layout: Layout, titles: Mapping[str, str], extra: tuple[str, ...] = ()
) -> rrb.TimeSeriesView | None:
    """Return a plot, from every source, of the first of these quantities that one has; None if none has
    any."""
    for quantity, title in titles.items():
        entities = [
            f"{source}/{quantity}"
            for source, channels in layout.sources().items()
            if quantity in names.columns_by_quantity(channels)
        ]
        if entities:
            return rrb.TimeSeriesView(
                origin="/",
                contents=[*entities, *extra],
                name=title,
                axis_x=_TOGETHER,
                plot_legend=_COLLAPSED,
                time_ranges=_range(layout),
            )
    return None


def _range(layout: Layout) -> list[rrb.VisibleTimeRange] | None:
    if not layout.followed:
        return None
    return [
        rrb.VisibleTimeRange(
            names.DRIVE_TIME,
            start=rrb.TimeRangeBoundary.cursor_relative(seconds=-_FOLLOWED_S),
            end=rrb.TimeRangeBoundary.cursor_relative(seconds=0.0),
        )
    ]


def _flux_plane(layout: Layout) -> rrb.Spatial2DView:
    reach = 1.6 * layout.psi_Wb
    return rrb.Spatial2DView(
        origin=names.LOCUS,
        name="flux vector (Wb), beta up",
        visual_bounds=rrb.VisualBounds2D(x_range=[-reach, reach], y_range=[-reach, reach]),
    )


def _spectrum() -> rrb.BarChartView:
    return rrb.BarChartView(
        origin=f"{names.SPECTRUM}/lines",
        name="spectrum (dB re 1 mA), Hz",
        plot_legend=_COLLAPSED,
    )


def _harmonics() -> rrb.BarChartView:
    return rrb.BarChartView(
        origin=f"{names.SPECTRUM}/harmonics",
        name="harmonics (%) by order",
        plot_legend=_COLLAPSED,
    )


def _waterfall() -> rrb.TensorView:
    return rrb.TensorView(
        origin=f"{names.SPECTRUM}/waterfall",
        name="waterfall (dB re 1 mA)",
        scalar_mapping=rrb.TensorScalarMapping(colormap="inferno", mag_filter="nearest"),
        view_fit="fill",
        slice_selection=rrb.TensorSliceSelection(width=1, height=0),
    )


def _names(channels: tuple[Channel, ...]) -> set[str]:
    return {channel.name for channel in channels}
