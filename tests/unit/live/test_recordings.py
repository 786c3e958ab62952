"""The view writes exactly its input: every sample, name, unit and time."""

from __future__ import annotations

import re
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from hypothesis import Phase, given, settings, strategies as st

import benchtool.live
from benchtool.analysis import Measurement
from benchtool.block import Block, Channel, Gap
from benchtool.errors import EnvironmentFailure
from benchtool.link.clock_anchor import ClockAnchor
from benchtool.live import FileDestination, LiveView, Setup, certificate_document, names, results_document
from benchtool.live.blueprint import Layout, blueprint
from benchtool.live.bundle import limits_of, setup_of, show_bundle
from benchtool.live.messages import Columns, parts
from benchtool.live.panels.key import key_document
from benchtool.recording import Bundle, BundleWriter, Event, EventFile, Level, Manifest
from tests.at_length import at_length
from tests.unit.live.readback import Recording, assert_holds

_CHANNELS = (
    *(Channel("i_a", "A"), Channel("torque", "Nm"), Channel("psi_alpha", "Wb"), Channel("u_s", "V")),
    *(Channel("psi_beta", "Wb"), Channel("u_dc", "V"), Channel("law_clipped", ""), Channel("power", "W")),
)
_SETUP = Setup(
    "test", psi_Wb=0.17, limits={"torque_ripple_pp": (None, 0.06)}, mark=ClockAnchor(0, 1e-4, 1.7e9)
)


def block(rows: int, *, first_tick: int = 0, stride: int = 10, gaps: tuple[Gap, ...] = ()) -> Block:
    """A sine of 25 Hz and noise."""
    random = np.random.default_rng(rows + first_tick)
    data = random.standard_normal((rows, len(_CHANNELS)))
    data[:, 0] = 0.6 * np.sin(2.0 * np.pi * 25.0 * (first_tick + stride * np.arange(rows)) * 1e-4)
    data[:, 5], data[:, 6] = 122.5, 0.0
    return Block(_CHANNELS, first_tick, stride, 1e-4, data, gaps)


def recorded(path: Path, *blocks: Block, setup: Setup = _SETUP) -> Recording:
    path.unlink(missing_ok=True)
    with LiveView(setup, [FileDestination(path)]) as view:
        for each in blocks:
            view.add_block(each)
    assert view.rows_dropped == {str(path): 0}
    return Recording.read(path)


def test_every_sample_is_there_exactly(tmp_path: Path) -> None:
    whole = block(700)
    recording = recorded(tmp_path / "a.rrd", *parts(whole, 200))
    assert_holds(recording, whole, names.STREAM)
    assert recording.series("/stream/flux_vector") == ["psi_alpha (Wb)", "psi_beta (Wb)"]
    assert recording.series("/stream/counts") == ["law_clipped"]
    assert recording.series("/stream/other") == ["power (W)"]


@settings(max_examples=10, phases=(Phase.explicit, Phase.generate))  # each writes a file: not shrunk
@given(
    gaps=st.lists(
        st.tuples(st.integers(0, 99), st.integers(1, 2000)), max_size=4, unique_by=lambda gap: gap[0]
    ),
    cut=st.integers(1, 100),
    first_tick=st.integers(0, 1 << 33),
)
def test_gaps_break_the_line_where_rows_are_missing(
    gaps: list[tuple[int, int]], cut: int, first_tick: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    inside = tuple(Gap(row, missing) for row, missing in sorted(gaps) if row)
    whole = block(100, first_tick=first_tick, gaps=inside)
    recording = recorded(tmp_path_factory.mktemp("gaps") / "a.rrd", *parts(whole, cut))
    assert_holds(recording, whole, names.STREAM)
    values, ticks = recording.values("/stream/torque"), recording.ticks("/stream/torque")
    broken = ticks[np.isnan(values).all(axis=1)]
    before = [int(whole.ticks()[gap.row - 1]) + whole.stride for gap in inside]
    assert broken.tolist() == before
    assert np.all(np.diff(ticks) > 0)


def test_moments_are_told_on_three_timelines(tmp_path: Path) -> None:
    recording = recorded(tmp_path / "a.rrd", block(5, first_tick=20_000))
    entity = "/stream/torque"
    assert recording.ticks(entity).tolist() == [20_000, 20_010, 20_020, 20_030, 20_040]
    drive_ns = recording.nanoseconds(entity, names.DRIVE_TIME)
    assert drive_ns.tolist() == [2_000_000_000 + k * 1_000_000 for k in range(5)]
    wall_ns = recording.nanoseconds(entity, names.WALL_TIME)
    assert wall_ns.tolist() == [1_700_000_002_000_000_000 + k * 1_000_000 for k in range(5)]


def test_without_a_mark_the_first_row_is_of_the_time_of_its_arrival(tmp_path: Path) -> None:
    before_s = time.time()
    recording = recorded(tmp_path / "a.rrd", block(100), setup=Setup("test", psi_Wb=0.17))
    wall_s = recording.nanoseconds("/stream/torque", names.WALL_TIME) * 1e-9
    assert wall_s[-1] - wall_s[0] == pytest.approx(0.099, abs=1e-6)
    assert before_s - 1e-3 <= wall_s[-1] <= time.time()


def test_the_fundamental_is_marked_where_it_is(tmp_path: Path) -> None:
    path = tmp_path / "a.rrd"
    rows = block(20_000, stride=1)
    with LiveView(_SETUP, [FileDestination(path)]) as view:
        view.captured(rows)
    recording = Recording.read(path)

    def drawn(entity: str, component: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        data = recording.rows[entity].column(f"BarChart:{component}").to_pylist()[-1][0]
        return np.asarray(data["buffer"], dtype=np.float64)

    mark = f"{names.SPECTRUM}/lines/fundamental"
    assert drawn(mark, "abscissa") == pytest.approx([25.0], abs=0.01)
    assert drawn(mark, "values") == pytest.approx([20.0 * np.log10(600.0)], abs=0.2)  # 0.6 A
    assert len(drawn(f"{names.SPECTRUM}/lines/amplitude", "values")) <= 400


def test_the_hexagon_follows_the_dc_link(tmp_path: Path) -> None:
    charging = [block(20, first_tick=200 * k) for k in range(4)]
    for each, u_dc_V in zip(charging, (0.0, 30.0, 122.5, 123.0), strict=True):
        each.data[:, 5] = u_dc_V
    label = recorded(tmp_path / "a.rrd", *charging).still[f"{names.LOCUS}/scale"]["Points2D:labels"]
    assert label == ["122.5 V dc: vertices 81.67 V, 1 mWb is 0.384 V"]


def test_an_error_before_any_row_is_of_the_time_that_the_drive_tells(tmp_path: Path) -> None:
    path = tmp_path / "a.rrd"
    with LiveView(_SETUP, [FileDestination(path)]) as view:
        view.event(Event(text="refused", level=Level.ERROR, tick=36_000_000))
    recording = Recording.read(path)
    assert recording.nanoseconds(names.EVENTS, names.WALL_TIME).tolist() == [1_700_003_600_000_000_000]
    later = Setup("test", psi_Wb=0.17, mark=ClockAnchor(36_000_000, 1e-4, 1.7e9))
    with LiveView(later, [FileDestination(path)]) as view:
        view.event(Event(text="refused"))
    recording = Recording.read(path)
    for entity in (names.EVENTS, names.QUALITY):
        assert recording.nanoseconds(entity, names.WALL_TIME).tolist() == [1_700_000_000_000_000_000]


def test_a_capture_stands_at_its_place_beside_the_stream(tmp_path: Path) -> None:
    path = tmp_path / "a.rrd"
    capture = block(500, first_tick=1234, stride=1)
    transducer = Block((Channel("torque_transducer", "Nm"),), 24_680, 1, 5e-6, np.arange(100.0)[:, None])
    with LiveView(_SETUP, [FileDestination(path)]) as view:
        view.add_block(block(300))
        view.captured(capture, trigger_row=100)
        view.captured(transducer, names.TRANSDUCER)
    recording = Recording.read(path)
    assert_holds(recording, capture, names.CAPTURE)
    assert_holds(recording, transducer, names.TRANSDUCER)
    # 20 rows of the transducer are of one tick of the drive
    assert recording.ticks("/bench/transducer/torque")[[0, 19, 20, 99]].tolist() == [1234, 1234, 1235, 1238]
    events = dict(zip(recording.texts(names.EVENTS), recording.ticks(names.EVENTS), strict=True))
    assert events["trigger"] == 1334
    assert recording.ticks(names.TRIGGER).tolist() == [1334]
    assert not {names.ERROR, names.WARNING} & set(recording.rows)


def test_faults_are_found_on_the_timeline(tmp_path: Path) -> None:
    path = tmp_path / "a.rrd"
    with LiveView(_SETUP, [FileDestination(path)]) as view:
        view.event(Event(text="enabled", state="operation enabled"))
        view.add_block(block(20))
        view.event(Event(text="0x2310 continuous overcurrent", level=Level.ERROR, tick=215))
        view.event(Event(text="in fault", level=Level.ERROR, state="fault"))
        view.add_block(block(20, first_tick=200))
        view.event(Event(text="over", tick=500))
    recording = Recording.read(path)
    assert dict(zip(recording.texts(names.EVENTS), recording.ticks(names.EVENTS), strict=True)) == {
        "enabled": 190,
        "0x2310 continuous overcurrent": 215,
        "in fault": 390,
        "over": 500,
    }
    states = recording.rows[names.STATE].column("StateChange:state").to_pylist()
    assert states == [["operation enabled"], ["fault"]]
    assert recording.ticks(names.ERROR).tolist() == [215, 390]
    assert recording.still[names.ERROR]["SeriesPoints:names"] == ["error"]


def test_counters_and_missing_rows_are_shown(tmp_path: Path) -> None:
    first, second = block(20), block(20, first_tick=350)
    second.data[:, 6] = 7.0
    counted = {"link_frames_received": 100, "link_frames_dropped": 0}
    path = tmp_path / "a.rrd"
    with LiveView(_SETUP, [FileDestination(path)]) as view:
        view.count(lambda: counted)
        view.count_drops(lambda: 3)
        view.add_block(first)
        counted["link_frames_dropped"] = 2
        view.add_block(second)
    recording = Recording.read(path)
    assert recording.series(names.RECEPTION) == ["telemetry_rows_received", "link_frames_received"]
    assert recording.values(names.RECEPTION)[-1].tolist() == [40.0, 100.0]
    assert recording.series(names.QUALITY) == [
        "telemetry_rows_missing", "rows_not_shown (queue)", f"rows_not_shown ({path})", "link_frames_dropped",
    ]  # fmt: skip
    assert recording.values(names.QUALITY)[0].tolist() == [0.0, 3.0, 0.0, 0.0]
    assert recording.values(names.QUALITY)[-1].tolist() == [15.0, 3.0, 0.0, 2.0]
    told = recording.rows[names.COUNTERS].column("TextDocument:text").to_pylist()[-1][0]
    assert "**telemetry rows missing 15**" in told
    assert "**link frames dropped 2**" in told
    events = dict(zip(recording.texts(names.EVENTS), recording.ticks(names.EVENTS), strict=True))
    assert events == {"15 rows of the stream are missing": 200, "law_clipped: 7 more": 540}
    assert recording.ticks(names.WARNING).tolist() == [200, 540]


@pytest.mark.parametrize(("rows", "length"), [(7, 700), (200, 1400), *at_length((4, 560))])
def test_the_limit_of_the_ripple_lies_about_the_mean(tmp_path: Path, rows: int, length: int) -> None:
    whole = block(length)
    recording = recorded(tmp_path / "a.rrd", *parts(whole, rows))
    torque = whole.column("torque")
    ticks = recording.ticks(names.TORQUE_BAND)
    # wherever half a second lies about it
    assert ticks.tolist() == list(range(2500, 10 * (length - 250), 200))
    assert recording.series(names.TORQUE_BAND)[0] == "lowest torque (Nm)"
    for tick, (lowest, highest, lower, upper) in zip(ticks, recording.values(names.TORQUE_BAND), strict=True):
        place = int(tick) // whole.stride
        window = torque[place - 250 : place + 251]
        assert (lowest, highest) == (window.min(), window.max())
        assert upper - lower == pytest.approx(0.06)
        assert (upper + lower) / 2.0 == pytest.approx(window.mean())


def test_a_band_does_not_reach_over_a_gap(tmp_path: Path) -> None:
    recording = recorded(tmp_path / "a.rrd", block(700), block(700, first_tick=8000))
    ticks, values = recording.ticks(names.TORQUE_BAND), recording.values(names.TORQUE_BAND)
    drawn = ~np.isnan(values).any(axis=1)
    assert ticks[drawn].tolist() == [*range(2500, 4490, 200), *range(10_500, 12_490, 200)]
    assert ticks[~drawn].tolist() == [8000]


def test_the_circle_is_the_flux_that_is_asked_for(tmp_path: Path) -> None:
    def asking(psi_Wb: float, first_tick: int) -> Block:
        channels = (Channel("psi_s_reference", "Wb"),)
        return Block(channels, first_tick, 10, 1e-4, np.full((20, 1), psi_Wb))

    blocks = [asking(psi_Wb, 200 * k) for k, psi_Wb in enumerate((0.0, 0.0, 0.19, 0.1901, 0.12))]
    recording = recorded(tmp_path / "a.rrd", *blocks)
    entity = f"{names.LOCUS}/reference"
    strips = recording.rows[entity].column("LineStrips2D:strips").to_pylist()
    radii = [float(np.hypot(*np.array(strip[0]).T).max()) for strip in strips]
    assert radii == pytest.approx([0.17, 0.19, 0.12])
    assert recording.ticks(entity).tolist() == [0, 400, 800]


def test_quality_of_the_whole_replaces_the_counters(tmp_path: Path) -> None:
    path = tmp_path / "a.rrd"
    with LiveView(_SETUP, [FileDestination(path)]) as view:
        view.add_block(block(20))
        view.quality(certificate_document([("rows_fine", 0.0, ""), ("jitter", 0.0012, "s")]))
    text = Recording.read(path).still[names.COUNTERS]["TextDocument:text"][0]
    assert text.splitlines()[2:] == ["| jitter | 0.0012 | s |", "| rows\\_fine | 0 |  |"]


def test_a_bundle_is_shown_as_it_was_recorded(tmp_path: Path) -> None:
    slow, capture = block(900, gaps=(Gap(300, 7),)), block(800, first_tick=5000, stride=1)
    details = {
        "case": "warm",
        "plan": {
            "limits": {"torque_ripple_pp": {"max": 0.06}},
            "stimulus": {"shape": "step"},
            "record": {"pretrigger_s": 0.01},
        },
        "verdicts": {"torque_ripple_pp": "fail"},
        "wall": {"tick": 20_000, "tick_s": 1e-4, "wall_s": 1.7e9},
    }
    manifest = Manifest(
        what="ripple", when="2026-01-01T12:00:00+00:00", details=details, parameters={"R_s_ohm": 0.123}
    )
    with BundleWriter(tmp_path / "run", manifest) as writer:
        writer.append("telemetry", slow)
        writer.append("capture", capture)
        happened = EventFile(tmp_path / "run").append
        happened(Event(text="enabled", tick=100, state="operation enabled"))
        happened(Event(text="too fast", level=Level.ERROR, tick=5000))
        value = {"value": 0.07, "unit": "Nm", "definition": "peak to peak"}
        writer.finish({"torque_ripple_pp": value}, verdict="fail")
    bundle, path = Bundle.open(tmp_path / "run"), tmp_path / "a.rrd"
    setup = setup_of(bundle.manifest, "run", 0.17)
    show_bundle(bundle, setup, [FileDestination(path)], print).close()
    recording = Recording.read(path)
    assert_holds(recording, slow, names.STREAM)
    assert_holds(recording, capture, names.CAPTURE)
    wall_ns = recording.nanoseconds("/stream/torque", names.WALL_TIME)
    assert wall_ns[0] == 1_699_999_998_000_000_000  # the first row is of tick 0
    events = dict(zip(recording.texts(names.EVENTS), recording.ticks(names.EVENTS), strict=True))
    assert events["trigger"] == 5100
    assert (events["enabled"], events["too fast"]) == (100, 5000)
    assert recording.ticks(names.ERROR).tolist() == [5000]
    (mean_Nm,) = recording.values(names.ERROR)[0]
    assert abs(mean_Nm) < 0.5  # where the torque was, so that it is seen
    text = recording.still[names.RESULTS]["TextDocument:text"][0]
    assert "| torque\\_ripple\\_pp | 0.07 | Nm | ≤ 0.06 | fail |" in text
    assert "| R\\_s\\_ohm | 0.123 |" in recording.still[names.PARAMETERS]["TextDocument:text"][0]


def test_the_key_names_each_series_with_the_colour_that_it_is_drawn_in() -> None:
    channels = (Channel("i_a", "A"), Channel("i_b", "A"), Channel("torque", "Nm"), Channel("u_dc", "V"))
    document = key_document({names.STREAM: channels[:1], names.CAPTURE: channels})
    assert document.text is not None
    (text,) = document.text.as_arrow_array().to_pylist()
    assert "**current** i\\_a blue, i\\_b orange" in text
    assert "torque blue, least and greatest white, limits of the ripple red" in text
    assert "u\\_dc" not in text  # voltages are not plotted beside these
    assert "slow stream in light tones" in text
    assert "light tones" not in str(key_document({names.CAPTURE: channels}).text)


def test_no_plot_has_a_legend_over_its_data() -> None:
    channels = (
        Channel("i_a", "A"),
        Channel("torque", "Nm"),
        Channel("psi_alpha", "Wb"),
        Channel("psi_beta", "Wb"),
    )
    views: list[rrb.View] = []

    def collect(part: rrb.View | rrb.Container) -> None:
        views.extend([part] if isinstance(part, rrb.View) else [])
        for each in getattr(part, "contents", ()) if isinstance(part, rrb.Container) else ():
            collect(each)

    collect(blueprint(Layout(capture=channels, states=True)).root_container)
    plots = [view for view in views if view.class_identifier in ("TimeSeries", "BarChart")]
    assert len(plots) >= 4
    shown = [view.name for view in plots if _legend(view)]
    assert shown == []


def _legend(view: rrb.View) -> bool:
    """Whether a plot has a legend: by default it has."""
    legend = view.properties.get("PlotLegend")
    assert legend is None or isinstance(legend, rrb.PlotLegend)
    return legend is None or legend.visible is None or bool(legend.visible.as_arrow_array().to_pylist()[0])


def test_results_stand_by_analysis_what_is_limited_first_and_why_there_is_no_number() -> None:
    measurements = (
        Measurement("torque_mean", 0.65, "Nm", "mean"),
        Measurement("torque_ripple_pp", 0.07, "Nm", "peak to peak"),
        Measurement.undefined("current_thd_f", "%", "harmonics", "i_a is clipped"),
        Measurement("omega_m_reached", 15.7, "rad/s", "mean"),
    )
    document = results_document("a run", measurements, {"torque_ripple_pp": (None, 0.06)})
    assert document.text is not None
    (text,) = document.text.as_arrow_array().to_pylist()
    assert text.splitlines()[4:] == [
        "| torque\\_ripple\\_pp | 0.07 | Nm | ≤ 0.06 |  |",
        "",
        "| measurement | value | unit |",
        "|---|---:|---|",
        "| *torque ripple* | | |",
        "| torque\\_mean | 0.65 | Nm |",
        "| *current spectrum* | | |",
        "| current\\_thd\\_f | – | % |",
        "| omega\\_m\\_reached | 15.7 | rad/s |",
        "",
        "undefined:",
        "",
        "- current\\_thd\\_f: i_a is clipped",
    ]


def test_a_repetition_has_the_limits_of_its_group_and_its_own() -> None:
    plan = {
        "limits": {"a": {"max": 1.0}},
        "case_limits": {"warm": {"a": {"max": 2.0}, "b": {"min": 3.0}}, "warm.2": {"b": {"min": 4.0}}},
    }
    assert limits_of(plan, "warm.1", "warm") == {"a": (None, 2.0), "b": (3.0, None)}
    assert limits_of(plan, "warm.2", "warm") == {"a": (None, 2.0), "b": (4.0, None)}
    assert limits_of(plan, "cold") == {"a": (None, 1.0)}


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    place = tmp_path / "file" / "a.rrd"
    with pytest.raises(EnvironmentFailure, match=re.escape(f"cannot write {place}: ")):
        FileDestination(place).check()
    noted: list[str] = []
    with LiveView(_SETUP, [FileDestination(place)], noted.append) as view:
        view.add_block(block(20))
    assert view.sinks == []
    assert noted[0].startswith(f"not shown by {place}: cannot write")


def test_a_file_that_fails_is_not_reopened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """That would cut off what it holds."""
    path, noted = tmp_path / "a.rrd", list[str]()
    with LiveView(_SETUP, [FileDestination(path)], noted.append) as view:
        view.add_block(block(20))
        view.sinks[0].send([_Broken()], 7)
        view.add_block(block(20, first_tick=200))
        view.add_block(block(20, first_tick=400))
    assert noted == [f"{path} is gone, the measurement goes on without it; no space left on device"]
    assert Recording.read(path).ticks("/stream/torque").tolist() == list(range(0, 200, 10))
    assert view.rows_dropped == {str(path): 47}


class _Broken(Columns):
    """What a disk does that is full."""

    def __init__(self) -> None:
        super().__init__("/broken", (), ())

    def send(self, stream: rr.RecordingStream) -> None:
        raise RuntimeError("no space left on device")


def test_trying_a_file_leaves_nothing_behind(tmp_path: Path) -> None:
    path = tmp_path / "new" / "a.rrd"
    FileDestination(path).check()
    assert list(path.parent.iterdir()) == []
    path.write_bytes(b"kept")
    FileDestination(path).check()
    assert path.read_bytes() == b"kept"


def test_a_disk_that_is_about_to_be_full_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = {"B": 1 << 30}
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=free["B"]))
    monkeypatch.setattr("benchtool.live.sinks.file._LOOKING_S", 0.0)
    path, noted = tmp_path / "a.rrd", list[str]()
    with LiveView(_SETUP, [FileDestination(path)], noted.append) as view:
        view.add_block(block(20))
        free["B"] = 1 << 20
        view.add_block(block(20, first_tick=200))
        free["B"] = 1 << 30
        view.add_block(block(20, first_tick=400))
    assert noted == [
        f"{path} is gone, the measurement goes on without it; less than 32 MiB are free on its disk"
    ]
    rows = Recording.read(path).rows
    shown = len(rows["/stream/torque"]) if "/stream/torque" in rows else 0
    assert shown in (0, 20)  # the first block may have waited still
    assert view.rows_dropped == {str(path): 60 - shown}
    free["B"] = 0
    with pytest.raises(EnvironmentFailure, match="0 MiB are free there, 32 MiB are needed"):
        FileDestination(path).check()


def test_nothing_global_of_rerun_is_touched() -> None:
    folder = Path(benchtool.live.__file__).parent
    text = "\n".join(path.read_text(encoding="utf-8") for path in folder.glob("*.py"))
    assert not re.search(r"\brr\.(init|log|send_columns|save|spawn|set_time|connect_grpc|serve_\w+)\(", text)
    assert not re.search(r"make_(thread_)?default|set_global|set_thread_local", text)
