"""The table of faults."""

from __future__ import annotations

from typing import Final

from benchtool.emulator.faults.declaration import Kind, Outcome, Parameter, Place

_WAYS = ("both", "to_drive", "to_host")
_PHASES = ("a", "b", "c")


def _share(default: float) -> Parameter:
    return Parameter("share", default, "", "of the frames, drawn with the seed of the bench", 0.0, 1.0)


def _duration(default: float = 0.0) -> Parameter:
    return Parameter("duration_s", default, "s", "how long it lasts; 0: until it is ended", 0.0, 1e6)


_WAY = Parameter("way", "both", "", "direction of the frames", choices=_WAYS)
_PHASE = Parameter("phase", "a", "", "motor phase", choices=_PHASES)

_STOP, _ENDED, _ON = Outcome.STOPS, Outcome.ENDED, Outcome.GOES_ON
_LOSS = "the drive reports 0x8130 heartbeat or life guarding lost"
_SILENT = "nothing was heard of the drive"
_RESTARTED = "the drive restarted"

_KINDS = (
    # ---- wires ---------------------------------------------------------------------------------------------
    Kind(
        *("frames_lost", Place.WIRE, "Frames do not arrive.", _ON),
        "the stream's account: records missing; reads asked again (retries)",
        (_share(0.05), _WAY, _duration()),
    ),
    Kind(
        *("frames_late", Place.WIRE, "Frames arrive later, in their order.", _ON),
        "latency and jitter of the stream's account",
        (
            Parameter("delay_s", 0.005, "s", "by which they are late", 0.0, 10.0),
            _share(1.0),
            _WAY,
            _duration(),
        ),
    ),
    Kind(
        *("frames_duplicated", Place.WIRE, "Frames arrive twice.", _ON),
        "repeated records and stale answers are counted; no command acts twice",
        (_share(0.3), _WAY, _duration()),
    ),
    Kind(
        *("frames_reordered", Place.WIRE, "A frame is overtaken by the next one.", _ON),
        "records out of order are counted as missing, never put in the wrong place",
        (
            _share(0.1),
            Parameter("hold_s", 0.02, "s", "the longest that a frame waits to be overtaken", 0.0, 10.0),
            _WAY,
            _duration(),
        ),
    ),
    Kind(
        *("frames_corrupted", Place.WIRE, "A bit flips; on CAN the controller drops such a frame.", _ON),
        "frames dropped by their check sum, counted by host and drive",
        (_share(0.05), _WAY, _duration()),
    ),
    Kind(
        *("cable_pulled", Place.WIRE, "Nothing arrives either way.", _STOP),
        f"{_SILENT}; after reconnection: {_LOSS}",
        (_duration(),),
    ),
    Kind(
        *("bus_off", Place.WIRE, "The drive's CAN controller leaves the bus.", _STOP),
        f"{_SILENT}; when it is back: 0x8140 recovered from bus off",
        (_duration(),),
        can_only=True,
    ),
    Kind(
        *("duplicate_node", Place.WIRE, "A second node with the drive's number is switched on.", _ENDED),
        "the drive restarted, or another node with its number was switched on; nodes answer as node N",
        (_duration(),),
        can_only=True,
    ),
    Kind(
        *("babbling_node", Place.WIRE, "A node floods the bus with frames of high priority.", _STOP),
        f"{_SILENT}, or {_LOSS}",
        (
            Parameter("rate_Hz", 2000.0, "Hz", "frames per second of it", 1.0, 1e5),
            Parameter("can_id", 5.0, "", "their identifier", 0.0, 2047.0),
            Parameter("share", 1.0, "", "of the others' frames that find no room", 0.0, 1.0),
            _duration(),
        ),
        can_only=True,
    ),
    # ---- host ----------------------------------------------------------------------------------------------
    Kind(
        *("host_frozen", Place.HOST, "What the host sends waits, and arrives all at once.", _STOP),
        _LOSS,
        (_duration(0.5),),
    ),
    Kind(
        *("host_killed", Place.HOST, "Nothing comes from the host any more.", _STOP),
        _LOSS,
        (_duration(),),
    ),
    # ---- drive ---------------------------------------------------------------------------------------------
    Kind(
        *("drive_reset", Place.DRIVE, "The drive restarts, as after a dip of its supply.", _STOP),
        _RESTARTED,
    ),
    Kind(
        "drive_hung",
        Place.DRIVE,
        "Communication and supervision hang, control runs on with its last command.",
        _STOP,
        f"{_SILENT}, or {_RESTARTED} and 0x6010 software reset by the watchdog",
        (
            Parameter(
                "watchdog_s", 0.05, "s", "after which its watchdog resets it; 0: it has none", 0.0, 60.0
            ),
        ),
    ),
    Kind(
        *("other_firmware", Place.DRIVE, "The drive restarts with a firmware of another dictionary.", _STOP),
        f"{_RESTARTED}; then: the dictionary of the drive is another one",
    ),
    Kind(
        *("wrong_parameter", Place.DRIVE, "A parameter of the drive changes by itself.", _ON),
        "not noticed while it runs; the next run names parameter, both values and the profile",
        (
            Parameter("name", "psi_r", "", "of the dictionary"),
            Parameter("times", 1.5, "", "factor on its value", -1e6, 1e6),
        ),
    ),
    # ---- plant ---------------------------------------------------------------------------------------------
    Kind(
        *("encoder_loss", Place.PLANT, "The encoder's cable is off: counts end.", _STOP),
        "the drive reports 0x7305 encoder 1 failed",
        (_duration(),),
    ),
    Kind(
        *("encoder_offset", Place.PLANT, "The encoder's disc turns on its shaft.", _ENDED),
        "torque_Nm or omega_m_rad_s of the profile's [limits], or 0x2310 overcurrent",
        (Parameter("angle_rad", 0.39, "rad", "mechanical angle that it turns by", -6.3, 6.3),),
    ),
    Kind(
        *("encoder_slip", Place.PLANT, "The encoder's disc slips on its shaft.", _ENDED),
        "torque_Nm or omega_m_rad_s of the profile's [limits], or 0x2310 overcurrent",
        (
            Parameter("share", 0.02, "", "of the shaft's angle by which the disc stays behind", 0.0, 1.0),
            _duration(),
        ),
    ),
    Kind(
        *("phase_open", Place.PLANT, "The cable of a phase is off.", _ENDED),
        "current_unbalance_percent of the profile's [limits]",
        (
            _PHASE,
            Parameter("R_ohm", 1000.0, "ohm", "of the open end", 1.0, 1e5),
            _duration(),
        ),
        compiles=True,
    ),
    Kind(
        *("phases_swapped", Place.PLANT, "The cables of phases b and c are swapped.", _ENDED),
        "a limit of the profile ([limits]), 0x8400 speed outside its limits or 0x2310 overcurrent",
    ),
    Kind(
        *("current_gain", Place.PLANT, "A current sensor's gain is wrong.", _ENDED),
        "current_sum_A of the profile's [limits]",
        (_PHASE, Parameter("gain", 0.5, "", "of what it ought to read", -10.0, 10.0), _duration()),
    ),
    Kind(
        *("current_offset", Place.PLANT, "A current sensor's offset jumps.", _ENDED),
        "current_sum_A of the profile's [limits]",
        (_PHASE, Parameter("offset_A", 2.0, "A", "that is added", -1e3, 1e3), _duration()),
    ),
    Kind(
        *("current_stuck", Place.PLANT, "A current sensor reads one value.", _ENDED),
        "current_sum_A of the profile's [limits], or 0x2310 overcurrent",
        (_PHASE, Parameter("value_A", 0.0, "A", "that it reads", -1e3, 1e3), _duration()),
    ),
    Kind(
        *("dc_link_sag", Place.PLANT, "The supply's voltage falls.", _STOP),
        "the drive reports 0x3220 dc link undervoltage",
        (
            Parameter("of_level", 0.8, "", "voltage, of the level u_dc_min", 0.01, 1.0),
            _duration(),
        ),
    ),
    Kind(
        *("dc_link_overvoltage", Place.PLANT, "The supply's voltage rises.", _STOP),
        "the drive reports 0x3210 dc link overvoltage",
        (
            Parameter("of_level", 1.1, "", "voltage, of the level u_dc_max", 1.0, 10.0),
            _duration(),
        ),
    ),
    Kind(
        *("overcurrent", Place.PLANT, "Turns of the winding are shorted: its inductance falls.", _STOP),
        "the drive reports 0x2310 continuous overcurrent at the output",
        (
            Parameter("of_inductance", 0.02, "", "what is left of the inductance", 0.001, 1.0),
            _duration(),
        ),
    ),
    Kind(
        *("overspeed", Place.PLANT, "The load machine drives the shaft.", _STOP),
        "the drive reports 0x8400 speed outside its limits, or 0x2310 overcurrent",
        (
            Parameter("of_level", 1.2, "", "speed, of the level omega_m_trip", -2.0, 2.0),
            _duration(0.05),
        ),
    ),
    Kind(
        *("overtemperature", Place.PLANT, "The thermal switch in the winding opens.", _STOP),
        "the drive reports 0x4310 drive temperature too high",
        (_duration(1.0),),
    ),
)

FAULTS: Final = {kind.name: kind for kind in _KINDS}
"""Every fault by its name."""
