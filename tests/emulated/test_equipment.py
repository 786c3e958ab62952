"""Equipment of a profile: instruments on CAN against the emulated machine, and the operator."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import can
import numpy as np
import pytest

from benchtool.analysis.crop import crop_to
from benchtool.bench.can_frames import MessageListener
from benchtool.bench.dbc import DbcTransducer
from benchtool.bench.equipment import Temperatures
from benchtool.bench.operator import Confirmation
from benchtool.bench.session import Session, equipment_of, open_session
from benchtool.block import Block
from benchtool.errors import BenchError, NoAnswer, ProfileError, UsageError, ValueRefused
from benchtool.plan.model import Plan
from benchtool.profile.equipment import CanTransducer
from benchtool.protocol.cia402 import State
from benchtool.protocol.dbc import DbcMessage
from benchtool.recording import Bundle
from benchtool.results.assessment import Assessment
from benchtool.run.runner import RunInfo, run_plan
from benchtool.shipped import shipped

from .conftest import Opener, Wire

INFO = RunInfo("2020-01-01T00:00:00+00:00", 0, ("run",))
CHANNELS = ("i_a", "torque", "psi_s", "theta_m", "omega_m", "u_dc", "switching_count")
RESOLUTION_NM = 0.0005


def _dbc() -> str:
    """Frames of a fast transducer (CAN FD), of a slow one with a counter, and of a power analyser."""
    burst = [
        f' SG_ t{n} : {16 * n}|16@1- ({RESOLUTION_NM},0) [-16.384|16.3835] "N.m" Host' for n in range(32)
    ]
    return "\n".join(
        (
            'VERSION ""',
            "NS_ :",
            "BS_:",
            "BU_: Sensor Host",
            "BO_ 801 Burst: 64 Sensor",
            *burst,
            "",
            "BO_ 802 Torque: 8 Sensor",
            ' SG_ count : 0|8@1+ (1,0) [0|255] "" Host',
            *(f' SG_ torque_{n} : {8 + 16 * n}|16@1- (1,0) [-20000|20000] "mNm" Host' for n in range(2)),
            "",
            "BO_ 803 Power: 8 Sensor",
            ' SG_ voltage : 0|32@1+ (0.001,0) [0|1000] "V" Host',
            ' SG_ current : 32|24@1- (0.001,0) [-100|100] "A" Host',
            ' SG_ percent : 56|8@1+ (1,0) [0|100] "" Host',
            "",
            "BO_ 804 Heat: 2 Sensor",
            ' SG_ winding : 0|8@1- (1,0) [-40|120] "degC" Host',
            ' SG_ speed : 8|8@1- (1,0) [-40|120] "rpm" Host',
            "",
            "BO_ 1409 Stolen: 8 Sensor",  # 0x581, the SDO responses of node 1
            ' SG_ torque : 0|16@1- (1,0) [0|0] "mNm" Host',
            "",
            f"BO_ {0x80000000 | 805} Long: 8 Sensor",
            ' SG_ torque : 0|16@1- (1,0) [0|0] "mNm" Host',
            "",
            'BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","reserved","reserved",'
            '"reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved",'
            '"StandardCAN_FD","ExtendedCAN_FD";',
            'BA_DEF_DEF_ "VFrameFormat" "StandardCAN";',
            'BA_ "VFrameFormat" BO_ 801 14;',
            "",
        )
    )


BURST = {
    "kind": "can",
    "message": "Burst",
    "rate_Hz": 6250.0,
    "signals": [f"t{number}" for number in range(32)],
}
SLOW = {
    "kind": "can",
    "message": "Torque",
    "rate_Hz": 1000.0,
    "signals": ["torque_0", "torque_1"],
    "counter": "count",
    "delay_s": 0.0005,
    "delay_limit_s": 1e-6,
}
Bench = dict[str, dict[str, Any]]


@pytest.fixture
def bench(tmp_path: Path) -> Callable[[Bench], str]:
    """Writes the paper's profile with a `[bench]`, and its DBC file beside it."""

    def write(tables: Bench) -> str:
        (tmp_path / "bench.dbc").write_text(_dbc(), encoding="utf-8")
        text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
        for name, table in tables.items():
            content = {**({"dbc": "bench.dbc"} if table["kind"] == "can" else {}), **table}
            text += f"\n[bench.{name}]\n"
            text += "".join(f"{key} = {json.dumps(value)}\n" for key, value in content.items())
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


class RunObserver:
    """Keeps the notes, and does something when one of them comes."""

    def __init__(self, at: str = "", action: Callable[[], None] = lambda: None) -> None:
        self.notes: list[str] = []
        self._at, self._action = at, action

    def begin(self, case: str, number: int, count: int) -> None: ...

    def note(self, text: str) -> None:
        self.notes.append(text)
        if self._at and self._at in text:
            self._action()


def _plan(*loads_Nm: float, duration_s: float = 0.12, **point: Any) -> Plan:
    document: dict[str, Any] = {
        "title": "test",
        "profile": "zhu2011",
        "case": "only",
        "operating_point": {"settle_s": 0.4, "omega_m_rad_s": 31.42},
        "record": {"duration_s": duration_s, "channels": CHANNELS},
    }
    if len(loads_Nm) > 1:
        document["sweep"] = {"operating_point": {"load_torque_Nm": loads_Nm}}
    elif loads_Nm:
        document["operating_point"]["load_torque_Nm"] = loads_Nm[0]
    return Plan.model_validate(document | ({"operating_point": {"settle_s": 0.4, **point}} if point else {}))


def _run(
    session: Session, plan: Plan, folder: Path, info: RunInfo = INFO, observer: RunObserver | None = None
) -> tuple[Assessment, ...]:
    return run_plan(
        lambda *_: nullcontext(session), plan, folder, info, observer or RunObserver()
    ).assessments


SHORT = _plan(omega_m_rad_s=62.84, load_torque_Nm=0.65, settle_s=0.2, duration_s=0.06)


def _recorded(
    wire: Wire, folder: Path, observer: RunObserver | None = None
) -> tuple[Assessment, Block, Bundle]:
    """A case, the transducer's samples over the time of its capture, and its bundle."""
    wire.session.clock.wait(0.1)  # by then every instrument has sent, so that no run waits for one
    (found,) = _run(wire.session, SHORT, folder, observer=observer)
    bundle = Bundle.open(folder)
    return found, crop_to(bundle.block("transducer"), bundle.block("capture")), bundle


# ---- a transducer on CAN -----------------------------------------------------------------------------------


def test_the_numbers_of_a_transducer_on_can_are_those_of_the_direct_one(
    open_wire: Opener, bench: Callable[[Bench], str], tmp_path: Path
) -> None:
    direct, true, first = _recorded(open_wire(), tmp_path / "direct")
    framed, sent, second = _recorded(open_wire(bench({"transducer": BURST})), tmp_path / "framed")
    assert np.array_equal(first.block("capture").data, second.block("capture").data), "the same machine"
    rows = len(true.data)  # the direct one ends a tick before the capture does
    assert rows == len(sent.data) - 20 == 11980
    assert np.max(np.abs(sent.data[:rows] - true.data)) <= 0.5 * RESOLUTION_NM + 1e-12
    assert np.max(np.abs(sent.ticks()[:rows] * sent.tick_s - true.ticks() * true.tick_s)) < 1e-9
    names = [name for name in direct.found if name.startswith("transducer_torque") and "percent" not in name]
    assert {"transducer_torque_mean", "transducer_torque_ripple_pp", "transducer_torque_ripple_rms"} <= set(
        names
    )
    for name in (*names, "torque_error"):
        assert framed.found[name].value == pytest.approx(direct.found[name].value, abs=RESOLUTION_NM), name
        assert 0.0 < (framed.found[name].basis.alignment_s or 0.0) < 1e-8
        assert direct.found[name].basis.alignment_s is None


@pytest.mark.parametrize("bus", ["drive", "can:virtual:instruments"])
def test_what_is_kept_of_a_transducer_on_can(
    open_wire: Opener, bench: Callable[[Bench], str], tmp_path: Path, bus: str
) -> None:
    """Two samples a frame, in mNm, half a millisecond late, with frames that are none of its own."""
    _, true, _ = _recorded(open_wire(), tmp_path / "direct")
    wire = open_wire(bench({"transducer": {**SLOW, "bus": bus}}))

    def disturb() -> None:
        for options in ({"data": b"\x01"}, {"data": b""}, {"is_remote_frame": True, "dlc": 8}):
            wire.bus.send(can.Message(arbitration_id=802, is_extended_id=False, **options))

    found, sent, bundle = _recorded(wire, tmp_path / "framed", RunObserver("capturing", disturb))
    assert sent.sample_rate_Hz == pytest.approx(2000.0, rel=1e-12)
    at = np.searchsorted(true.ticks() * true.tick_s, sent.ticks() * sent.tick_s - 1e-9)
    inside = at < len(true.data)
    assert inside.sum() >= len(sent.data) - 1 >= 118
    assert np.max(np.abs(sent.data[inside] - true.data[at[inside]])) <= 0.0005 + 1e-12
    kept = bundle.manifest.details["equipment"]["transducer"]
    malformed = 2 if bus == "drive" else 0
    assert kept["frames"]["malformed"] == malformed
    assert (kept["resolution_Nm"], kept["sample_rate_Hz"]) == (pytest.approx(0.001), 2000.0)
    assert kept["alignment"]["standard_s"] == sent.alignment_s == pytest.approx(1e-6 / 3**0.5, rel=0.1)
    assert found.found["transducer_torque_mean"].to_json()["basis"]["alignment_s"] == sent.alignment_s
    told = [event.text for event in bundle.events if "could not be decoded" in event.text]
    assert told == ["torque transducer: 2 frames could not be decoded and were dropped"] * bool(malformed)


def test_a_sample_out_of_range_is_a_gap_and_not_a_number(
    open_wire: Opener, bench: Callable[[Bench], str], tmp_path: Path
) -> None:
    profile = bench({"transducer": SLOW})
    dbc = tmp_path / "bench.dbc"
    dbc.write_text(
        dbc.read_text(encoding="utf-8").replace("[-20000|20000]", "[-20000|655]"), encoding="utf-8"
    )
    wire = open_wire(profile)
    assert wire.session.transducer is not None
    wire.session.clock.wait(0.1)

    # The emulated instrument saturates; one that does not is played by the test.
    frames = DbcMessage(dbc, "Torque", ("torque_0", "torque_1", "count"))
    wire.session.transducer.start(0.1)
    data = bytearray(frames.encode({"torque_0": 1.0, "torque_1": 1.0, "count": 0}))
    data[1:3] = (700).to_bytes(2, "little")
    wire.bus.send(can.Message(arbitration_id=802, data=data, is_extended_id=False))
    wire.session.clock.wait(0.01)
    assert wire.session.transducer.facts()["frames"]["out_of_range"] == 1


def _listener_without_frames(session: Session, profile: str) -> DbcTransducer:
    stated = CanTransducer.model_validate({**SLOW, "dbc": "bench.dbc"})
    message = DbcMessage(Path(profile).parent / "bench.dbc", "Torque", stated.read_signals)
    return DbcTransducer(stated, message, lambda m, rate_Hz: MessageListener(m, rate_Hz, session.clock))


def test_a_silent_transducer_is_found_before_the_drive_is_enabled(
    wire: Wire, bench: Callable[[Bench], str], tmp_path: Path
) -> None:
    session = replace(
        wire.session, transducer=_listener_without_frames(wire.session, bench({"transducer": SLOW}))
    )
    observer = RunObserver()
    with pytest.raises(NoAnswer, match="no frame of 'Torque'"):
        _run(session, _plan(0.65), tmp_path / "run", observer=observer)
    assert "enabling" not in observer.notes
    assert not (tmp_path / "run").exists()
    assert session.drive.state() is State.SWITCH_ON_DISABLED


def test_a_transducer_that_falls_silent_ends_the_run_disabled_and_unloaded(
    open_wire: Opener, bench: Callable[[Bench], str], tmp_path: Path
) -> None:
    wire = open_wire(bench({"transducer": SLOW}))
    session, loads = wire.session, list[float]()
    load = session.load
    assert load is not None
    apply = load.apply

    class Watched:
        def apply(self, torque_Nm: float) -> None:
            loads.append(torque_Nm)
            apply(torque_Nm)

        def hold(self, omega_m_rad_s: float) -> None: ...

    def unplug() -> None:
        session.drive.link.unsubscribe((802,))  # type: ignore[attr-defined]

    with pytest.raises(NoAnswer, match="no frame of 'Torque'"):
        _run(
            replace(session, load=Watched()),
            _plan(0.65),
            tmp_path / "run",
            observer=RunObserver("capturing", unplug),
        )
    assert session.drive.state() is State.SWITCH_ON_DISABLED
    assert loads[-1] == 0.0
    manifest = Bundle.open(tmp_path / "run").manifest
    assert "no frame of 'Torque'" in manifest.details["failure"]
    assert manifest.details["equipment"]["transducer"]["frames"]["received"] > 100


@pytest.mark.parametrize(
    ("table", "link", "said"),
    [
        ({**SLOW, "message": "Stolen", "signals": ["torque"], "counter": ""}, "emulated", "one of node 1"),
        ({**SLOW, "message": "Long", "signals": ["torque"], "counter": ""}, "emulated", "29-bit"),
        (SLOW, "emulated?wire=serial", "the drive is on no CAN bus"),
        ({**SLOW, "signals": ["torque_9"]}, "emulated", "has no signal 'torque_9': did you mean"),
        ({**SLOW, "message": "Heat", "signals": ["speed"], "counter": ""}, "emulated", "is in 'rpm'"),
        (
            {**SLOW, "signals": ["torque_0"], "counter": "torque_1"},
            "emulated",
            "counter 'torque_1' counts from",
        ),
        ({**SLOW, "counter": "torque_1"}, "emulated", "signal 'torque_1' is named twice"),
        ({**SLOW, "rate_Hz": 999.0}, "emulated", "whole parts of it"),
        ({**SLOW, "dbc": "other.dbc"}, "emulated", "cannot read"),
    ],
)
def test_an_instrument_that_cannot_be_is_refused(
    bench: Callable[[Bench], str], table: dict[str, Any], link: str, said: str
) -> None:
    profile = bench({"transducer": table})
    with pytest.raises(ProfileError) as refused, open_session(profile, link):
        pass
    assert said in str(refused.value)
    line = Path(profile).read_text(encoding="utf-8").splitlines().index("[bench.transducer]") + 1
    assert str(refused.value).startswith(f"{profile}, line {line}: [bench.transducer]: ")


def test_an_instrument_on_a_bus_of_its_own_may_have_any_identifier(
    open_wire: Opener, bench: Callable[[Bench], str]
) -> None:
    table = {**SLOW, "message": "Long", "signals": ["torque"], "counter": "", "bus": "can:virtual:own"}
    session = open_wire(bench({"transducer": table}), options="&wire=serial").session
    assert session.transducer is not None
    session.transducer.require_alive()


# ---- supply and temperature --------------------------------------------------------------------------------


def test_the_supply_of_an_emulated_bench_is_set_and_measured(open_wire: Opener) -> None:
    session = open_wire().session
    assert session.supply is not None
    assert session.supply.u_dc_V == 122.5
    session.supply.set_voltage(200.0)
    session.clock.wait(0.01)
    assert session.supply.u_dc_V == 200.0
    assert session.drive.number("u_dc") == pytest.approx(200.0, abs=0.5)  # its converter has 0.49 V a bit
    with pytest.raises(ValueRefused):
        session.supply.set_voltage(-1.0)


def test_readings_of_instruments_on_can(
    open_wire: Opener, bench: Callable[[Bench], str], tmp_path: Path
) -> None:
    profile = bench(
        {
            "supply": {"kind": "can", "message": "Power", "rate_Hz": 50.0, "u_dc": "voltage"},
            "temperature": {
                "kind": "can",
                "message": "Heat",
                "rate_Hz": 10.0,
                "winding": "winding",
                "bus": "can:virtual:lab",
            },
        }
    )
    session = open_wire(profile).session
    assert session.supply is not None
    assert session.thermometer is not None
    assert session.supply.u_dc_V == pytest.approx(122.5)
    assert session.supply.i_dc_A is None
    assert session.thermometer.temperatures() == Temperatures(25.0, None)
    with pytest.raises(ValueRefused, match="only measured here"):
        session.supply.set_voltage(100.0)
    _run(session, _plan(0.65), tmp_path / "run")
    before = Bundle.open(tmp_path / "run").manifest.details["equipment"]["before"]
    assert before == {"u_dc_V": pytest.approx(122.5), "winding_degC": 25.0}


def test_what_the_emulated_bench_does_not_know_it_does_not_tell(bench: Callable[[Bench], str]) -> None:
    supply = {"kind": "can", "message": "Power", "rate_Hz": 50.0, "u_dc": "voltage", "i_dc": "current"}
    with (
        pytest.raises(ProfileError, match="does not know the current"),
        open_session(bench({"supply": supply})),
    ):
        pass


def test_a_message_is_one_instruments_on_an_emulated_bench(bench: Callable[[Bench], str]) -> None:
    supply = {"kind": "can", "message": "Power", "rate_Hz": 50.0, "u_dc": "voltage"}
    heat = {"kind": "can", "message": "Power", "rate_Hz": 50.0, "winding": "percent"}
    profile = bench({"supply": supply, "temperature": heat})
    with pytest.raises(ProfileError, match="is read by two tables"), open_session(profile):
        pass


# ---- what a profile and a link declare ---------------------------------------------------------------------


def test_what_is_left_out_is_emulated_on_an_emulated_bench_only(bench: Callable[[Bench], str]) -> None:
    profile = bench({"transducer": {"kind": "none"}})
    assert equipment_of("zhu2011", "emulated").has_transducer
    assert not equipment_of(profile, "emulated").has_transducer
    assert not equipment_of("zhu2011", "can:virtual:x").has_transducer
    assert equipment_of(bench({"transducer": SLOW}), "can:virtual:x").has_transducer
    assert equipment_of("zhu2011", "can:virtual:x").lines() == {
        "load": "none: by the operator",
        "transducer": "none",
        "supply": "none",
        "temperature": "none",
    }
    with open_session(bench({"transducer": SLOW}), instruments=False) as session:
        assert session.transducer is None
        assert session.load is not None
    with pytest.raises(ProfileError, match="is emulated, and the drive is not"):
        equipment_of(bench({"load": {"kind": "emulated"}}), "can:virtual:x")


# ---- a person ----------------------------------------------------------------------------------------------


class Person:
    """Does what is asked for, and looks at the drive meanwhile."""

    def __init__(self, session: Session) -> None:
        self.asked: list[str] = []
        self.states: list[State] = []
        self._session = session

    def __call__(self, what: str) -> Confirmation:
        self.asked.append(what)
        self.states.append(self._session.drive.state())
        return Confirmation.BY_OPERATOR


def test_a_person_is_asked_before_the_drive_is_enabled(wire: Wire, tmp_path: Path) -> None:
    session, person, observer = replace(wire.session, load=None), Person(wire.session), RunObserver()
    plan = _plan(0.65, 0.0, 0.3, -0.3)
    found = _run(session, plan, tmp_path / "run", replace(INFO, prompt=person), observer)
    assert person.asked == [
        "load the shaft with 0.65 Nm against positive rotation",
        "free the shaft: take off the load, or stop what turns it",
        "load the shaft with 0.3 Nm against positive rotation",
        "load the shaft with 0.3 Nm towards positive rotation",
    ]
    assert set(person.states) == {State.SWITCH_ON_DISABLED}
    told = "to the operator: free the shaft: take off the load, or stop what turns it"
    assert observer.notes.count(told) == 3
    assert found[0].verdict == "fail", "the emulated shaft was not loaded, and that is seen"
    bundles = [Bundle.open(each.bundle) for each in found]
    kept = [each.manifest.details["equipment"].get("by_hand") for each in bundles]
    assert kept[0] == {"what": person.asked[0], "confirmed": "confirmed by the operator"}
    assert kept[1] == {"what": person.asked[1], "confirmed": "confirmed by the operator"}
    first = [event.text for event in bundles[0].events]
    asked = "operator was to load the shaft with 0.65 Nm against positive rotation: confirmed by the operator"
    assert first.index(asked) < first.index("enabling")


def test_a_person_turns_the_shaft(wire: Wire, tmp_path: Path) -> None:
    session, person = replace(wire.session, load=None), Person(wire.session)
    plan = _plan(mode="torque", torque_Nm=0.5, hold_speed_rad_s=-31.42)
    _run(session, plan, tmp_path / "run", replace(INFO, prompt=person))
    assert person.asked == ["turn the shaft at 31.42 rad/s in negative rotation"]
    assert session.drive.state() is State.SWITCH_ON_DISABLED


def test_whatever_ends_a_case_the_person_is_told_to_free_the_shaft(wire: Wire, tmp_path: Path) -> None:
    session, observer = replace(wire.session, load=None), RunObserver()
    plan = _plan(0.65).model_copy(update={"setup": {"i_trip_A": 1e6}})  # refused after the person was asked
    with pytest.raises(BenchError):
        _run(session, plan, tmp_path / "run", replace(INFO, prompt=Person(wire.session)), observer)
    assert "enabling" not in observer.notes
    assert observer.notes[-1].startswith("to the operator: free the shaft")


def test_without_a_prompt_nothing_is_enabled_for_any_case(wire: Wire, tmp_path: Path) -> None:
    observer = RunObserver()
    with pytest.raises(UsageError, match="the operator has to load the shaft with"):
        _run(replace(wire.session, load=None), _plan(0.0, 0.65), tmp_path / "run", observer=observer)
    assert "enabling" not in observer.notes
    assert not (tmp_path / "run").exists()


def test_a_person_who_leaves_ends_the_run(wire: Wire, tmp_path: Path) -> None:
    def leave(what: str) -> Confirmation:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        _run(replace(wire.session, load=None), _plan(0.65), tmp_path / "run", replace(INFO, prompt=leave))
    assert wire.session.drive.state() is State.SWITCH_ON_DISABLED
