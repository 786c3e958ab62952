"""What the view writes is what it was given: every sample, name, unit and moment."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import benchtool.live
from benchtool.block import Block, Channel, Gap
from benchtool.errors import EnvironmentFailure
from benchtool.live import FileDestination, LiveView, Setup, names
from benchtool.live.bundle import setup_of, show_bundle
from benchtool.live.columns import parts
from benchtool.recording import Bundle, BundleWriter, Manifest
from tests.unit.live.readback import Recording, assert_holds

_CHANNELS = (
    *(Channel("i_a", "A"), Channel("torque", "Nm"), Channel("psi_alpha", "Wb"), Channel("u_s", "V")),
    *(Channel("psi_beta", "Wb"), Channel("u_dc", "V"), Channel("law_clipped", ""), Channel("power", "W")),
)
_SETUP = Setup("test", psi_Wb=0.17, limits={"torque_ripple_pp": (None, 0.06)}, wall_s=1.7e9)


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
            view.take(each)
    assert view.rows_dropped == {str(path): 0}
    return Recording.read(path)


def test_every_sample_is_there_exactly(tmp_path: Path) -> None:
    whole = block(700)
    recording = recorded(tmp_path / "a.rrd", *parts(whole, 200))
    assert_holds(recording, whole, names.STREAM)
    assert recording.series("/stream/flux") == ["psi_alpha (Wb)", "psi_beta (Wb)"]
    assert recording.series("/stream/counts") == ["law_clipped"]
    assert recording.series("/stream/other") == ["power (W)"]


@settings(max_examples=20, phases=(Phase.explicit, Phase.generate))  # each writes a file: not shrunk
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
    assert wall_ns.tolist() == [1_700_000_000_000_000_000 + k * 1_000_000 for k in range(5)]


def test_a_capture_stands_at_its_place_beside_the_stream(tmp_path: Path) -> None:
    path = tmp_path / "a.rrd"
    capture = block(500, first_tick=1234, stride=1)
    transducer = Block((Channel("torque_transducer", "Nm"),), 24_680, 1, 5e-6, np.arange(100.0)[:, None])
    with LiveView(_SETUP, [FileDestination(path)]) as view:
        view.take(block(300))
        view.captured(capture, trigger_row=100)
        view.captured(transducer, names.TRANSDUCER)
    recording = Recording.read(path)
    assert_holds(recording, capture, names.CAPTURE)
    assert_holds(recording, transducer, names.TRANSDUCER)
    # 20 rows of the transducer are of one tick of the drive
    assert recording.ticks("/bench/transducer/torque")[[0, 19, 20, 99]].tolist() == [1234, 1234, 1235, 1238]
    events = dict(zip(recording.texts(names.EVENTS), recording.ticks(names.EVENTS), strict=True))
    assert events["trigger"] == 1334
    assert 1334 in recording.ticks(names.MARKERS)


def test_faults_are_found_on_the_timeline(tmp_path: Path) -> None:
    path = tmp_path / "a.rrd"
    with LiveView(_SETUP, [FileDestination(path)]) as view:
        view.state("operation enabled")
        view.take(block(20))
        view.event("0x2310 continuous over current", "ERROR")
        view.state("fault")
        view.state("fault")
        view.take(block(20, first_tick=200))
    recording = Recording.read(path)
    assert recording.texts(names.EVENTS) == [
        "state: operation enabled", "0x2310 continuous over current", "state: fault",
    ]  # fmt: skip
    states = recording.rows[names.STATE].column("StateChange:state").to_pylist()
    assert states == [["operation enabled"], ["fault"]]
    assert recording.ticks(names.MARKERS).tolist() == [390, 390]


def test_counters_and_missing_rows_are_shown(tmp_path: Path) -> None:
    first, second = block(20), block(20, first_tick=350)
    second.data[:, 6] = 7.0
    recording = recorded(tmp_path / "a.rrd", first, second)
    assert recording.values(names.QUALITY)[-1].tolist() == [40.0, 15.0, 0.0]
    assert "15 rows of the stream are missing" in recording.texts(names.EVENTS)
    assert "law_clipped: 7 more" in recording.texts(names.EVENTS)


def test_the_limit_of_the_ripple_lies_about_the_mean(tmp_path: Path) -> None:
    whole = block(100)
    recording = recorded(tmp_path / "a.rrd", whole)
    torque = whole.column("torque")
    lowest, highest, lower, upper = recording.values(names.TORQUE_BAND)[-1]
    assert (lowest, highest) == (torque.min(), torque.max())
    assert upper - lower == pytest.approx(0.06)
    assert (upper + lower) / 2.0 == pytest.approx(torque.mean())


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
    }
    manifest = Manifest(
        what="ripple", when="2026-01-01T12:00:00+00:00", details=details, parameters={"R_s_ohm": 0.123}
    )
    with BundleWriter(tmp_path / "run", manifest) as writer:
        writer.append("telemetry", slow)
        writer.append("capture", capture)
        value = {"value": 0.07, "unit": "Nm", "definition": "peak to peak"}
        writer.finish({"torque_ripple_pp": value}, verdict="fail")
    bundle, path = Bundle.open(tmp_path / "run"), tmp_path / "a.rrd"
    show_bundle(bundle, setup_of(bundle, 0.17), [FileDestination(path)], print).close()
    recording = Recording.read(path)
    assert_holds(recording, slow, names.STREAM)
    assert_holds(recording, capture, names.CAPTURE)
    wall_ns = recording.nanoseconds("/stream/torque", names.WALL_TIME)
    assert wall_ns[0] == 1_767_268_800_000_000_000
    events = dict(zip(recording.texts(names.EVENTS), recording.ticks(names.EVENTS), strict=True))
    assert events["trigger"] == 5100
    text = recording.still[names.RESULTS]["TextDocument:text"][0]
    assert "| torque\\_ripple\\_pp | 0.07 | Nm | ≤ 0.06 | fail |" in text
    assert "| R\\_s\\_ohm | 0.123 |" in recording.still[names.PARAMETERS]["TextDocument:text"][0]


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    place = tmp_path / "file" / "a.rrd"
    with pytest.raises(EnvironmentFailure, match=re.escape(f"cannot write {place}: ")):
        FileDestination(place).check()
    noted: list[str] = []
    with LiveView(_SETUP, [FileDestination(place)], noted.append) as view:
        view.take(block(20))
    assert view.outlets == []
    assert noted[0].startswith(f"not shown by {place}: cannot write")


def test_nothing_global_of_rerun_is_touched() -> None:
    folder = Path(benchtool.live.__file__).parent
    text = "\n".join(path.read_text(encoding="utf-8") for path in folder.glob("*.py"))
    assert not re.search(r"\brr\.(init|log|send_columns|save|spawn|set_time|connect_grpc|serve_\w+)\(", text)
    assert not re.search(r"make_(thread_)?default|set_global|set_thread_local", text)
