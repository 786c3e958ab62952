"""The JSON documents that commands print with `--json`, as models: a test holds real output against them.

The description of a key is the string literal below it. A key that may be left out has None as its default.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, RootModel

from docs.generate.json_acceptance import Accepted, TriedSuite
from docs.generate.json_commissioning import Commissioned, PlannedCommissioning
from docs.generate.json_gauge import GaugeStudied
from docs.generate.json_parameters import (
    DerivedParameters,
    Differences,
    DryRun,
    ListedPlans,
    ListedProfiles,
    Loaded,
    NewPlan,
    NewProfile,
    ParameterFile,
    Parameters,
    Restored,
    Stored,
    Values,
    WrittenValues,
)
from docs.generate.json_results import (
    Case,
    Document,
    Measurement,
    Plans,
    RepeatedDocument,
    Run,
    VerdictWord,
    Verified,
)
from docs.generate.json_tables import AnalyzedTable
from docs.generate.json_twin import Twins


class Kinds(Document):
    """`analyze --list`."""

    analyses: dict[str, dict[str, Any]]
    """What each kind of analysis needs, measures and draws, by name."""


class CertificateDocument(Document):
    """How good the data of a recording are."""

    complete: bool
    """Whether nothing is missing."""
    measurements: dict[str, Measurement]
    """Counters and times by name."""


class Recorded(Document):
    """`record`."""

    bundle: str
    """Folder of the recording."""
    ended_by: str
    """What ended it, such as `duration`."""
    lasted_s: float
    """Drive time that it has."""
    certificate: CertificateDocument
    """Quality of its data."""


class Pacing(Document):
    """How evenly setpoints came."""

    sent: int
    """Setpoints sent."""
    period_s: float
    """Period asked for."""
    period_mean_s: float
    """Mean period."""
    period_rms_s: float
    """Deviation, rms."""
    period_max_s: float
    """Longest period."""
    late: int
    """Periods that were too long."""


class Supervision(Document):
    """Of a drive whose profile has `allow_unsupervised`."""

    armed: bool
    """Whether the drive watches this host."""
    reason: str
    """Why it does not."""


class Jogged(Document):
    """`jog`."""

    omega_m_rad_s: float | None
    """Mechanical speed at the end."""
    torque_Nm: float | None
    """Torque at the end."""
    pacing: Pacing
    """How evenly setpoints came."""
    clock: Literal["virtual", "real"]
    """The clock of the bench."""
    supervision: Supervision | None = None
    """Link supervision, where the profile may leave it out."""


class CapabilityDocument(Document):
    """Whether a drive can do something."""

    available: bool
    """Whether it can."""
    by: list[str]
    """Objects that it does it by."""
    missing: list[str]
    """Objects that are missing."""


class DriveInfo(Document):
    """`info`."""

    link: str
    """Address of the drive."""
    node_id: int
    """Its node id."""
    vendor_id: int | None
    """Vendor (0x1018:1)."""
    product_code: int | None
    """Product (0x1018:2)."""
    revision_number: int | None
    """Revision (0x1018:3)."""
    serial_number: int | None
    """Serial number (0x1018:4)."""
    device_name: str | None
    """Name (0x1008)."""
    hardware_version: str | None
    """Hardware version (0x1009)."""
    firmware_version: str | None
    """Firmware version (0x100A)."""
    dictionary_hash: int | None
    """Hash of the object dictionary; null for a drive without one."""
    objects: int
    """Objects of the dictionary."""
    state: str | None
    """CiA 402 state in words."""
    equipment: dict[str, str]
    """Load machine, transducer, supply and temperature of the bench."""
    warnings: list[str]
    """What is odd about the EDS."""
    capabilities: dict[str, CapabilityDocument]
    """What the drive can do."""


class FileInfo(Document):
    """`info --eds FILE`."""

    eds: str
    """The file."""
    vendor_name: str | None
    """Vendor."""
    vendor_id: int | None
    """Its number."""
    product_name: str | None
    """Product."""
    product_code: int | None
    """Its number."""
    revision: int | None
    """Revision."""
    dictionary_hash: int | None
    """Hash of the object dictionary."""
    objects: int
    """Objects of the dictionary."""
    warnings: list[str]
    """What is odd about the EDS."""
    capabilities: dict[str, CapabilityDocument]
    """What a drive with it can do."""


class Found(Document):
    """A drive that answered; null for what it does not tell."""

    link: str
    """Its address, for `--link`."""
    node_id: int
    """Node id."""
    vendor_id: int | None
    """Vendor."""
    product_code: int | None
    """Product."""
    serial_number: int | None
    """Serial number."""
    device_name: str | None
    """Name."""
    firmware_version: str | None
    """Firmware version."""
    nmt_state: str | None
    """NMT state."""
    answers: int
    """How often it answered one request; more than once if two nodes have one id."""


class Silent(Document):
    """A place where no drive was found."""

    place: str
    """The place."""
    reason: str
    """Why."""


class Scanned(Document):
    """`scan`."""

    drives: list[Found]
    """Drives that answered."""
    silent: list[Silent]
    """Places without one."""
    duplicates: list[str]
    """What is there twice and should not be."""


class Reset(Document):
    """`reset`."""

    before: str
    """State before."""
    error_code: str | None
    """Error code (0x603F) before, hexadecimal."""
    after: str
    """State afterwards."""


class Check(Document):
    """One check of `doctor`."""

    ok: bool
    """Whether it passed."""
    seen: str
    """What was seen, or what to do."""


class Checks(RootModel[dict[str, Check]]):
    """`doctor`: checks by name."""


class ReportedCase(Document):
    """A case of a report."""

    verdict: VerdictWord
    """Its verdict."""
    bundle: str
    """Its folder."""


class Reported(Document):
    """`report`."""

    report: str
    """The HTML page."""
    pdf: str | None
    """The PDF, with `--pdf`."""
    verdict: VerdictWord
    """The worst verdict."""
    cases: dict[str, ReportedCase]
    """Cases by name."""
    pictures: list[str] | None = None
    """Pictures written, with `--png`."""


class Delta(Document):
    """A difference of a measurement between two runs."""

    unit: str
    """Unit."""
    reference: float | None
    """Value of the first run."""
    value: float | None
    """Value of this one."""
    absolute: float | None
    """The difference."""
    percent: float | None
    """The difference in percent of the first; null where that is zero within its U."""
    standard_uncertainty: float | None
    """Standard uncertainty u of the difference."""
    experimental_uncertainty: float | None
    """Experimental standard uncertainty s of it, without what few observations add to u."""
    dof: float | None
    """Its degrees of freedom."""
    student_factor: float | None
    """Student's factor t of these: U = t s; null where U is half of a derived interval."""
    k: float | None
    """Its coverage factor U / u."""
    expanded_uncertainty: float | None
    """Its expanded uncertainty U."""
    exceeds_uncertainty: bool | None
    """Whether the difference exceeds that."""
    judgement: str | None
    """`better` or `worse` by a limit."""
    above: float | None = None
    """What the difference is more than, where the first run only tells what its value is less than."""
    below: float | None = None
    """What the difference is less than, where this one only tells what its value is less than."""
    reason: str | None = None
    """Why the values are not compared: one is undefined, or they are not of one quantity."""
    uncertainty_reason: str | None = None
    """Why the difference has no uncertainty."""
    percent_reason: str | None = None
    """Why it is not told in percent."""


class Chance(Document):
    """How many differences exceed their uncertainty, and how many would by chance."""

    decided: int
    """Differences that have an uncertainty."""
    exceeding: int
    """Those that exceed it."""
    expected_by_chance: float
    """Those that would if the runs were alike."""


class Deltas(Document):
    """The differences of one case."""

    against: str
    """Case that it is compared with."""
    differences: Chance
    """How many there are."""
    measurements: dict[str, Delta]
    """Differences by measurement."""


class Compared(Document):
    """`compare`."""

    cases: dict[str, Case]
    """Cases by run and name."""
    deltas: dict[str, Deltas]
    """Differences by case."""
    circumstances: dict[str, dict[str, Any]]
    """What else differs between the runs, by case: operating point, parameters, limits."""
    without_counterpart: list[str]
    """Cases that one run alone has."""
    repeated: dict[str, dict[str, RepeatedDocument]] | None = None
    """Measurements over the repetitions, by run and case, and name."""
    repeated_deltas: dict[str, Deltas] | None = None
    """Differences of the means over the repetitions, by case."""
    report: str | None = None
    """The HTML page, with `--html`."""
    pdf: str | None = None
    """The PDF, with `--pdf`."""


class Exported(Document):
    """`export`."""

    file: str
    """The file."""
    format: Literal["csv", "mat", "mdf4"]
    """Its format."""
    stream: str
    """The stream."""
    rows: int
    """Its rows."""
    missing_rows: int
    """Rows that are missing."""
    channels: dict[str, str]
    """Units by channel."""


class LiveEnd(Document):
    """`live` of a drive, at its end."""

    rows: int
    """Rows received."""
    rows_lost: int
    """Rows lost on the link."""
    rows_not_shown: dict[str, int]
    """Rows that a viewer was too slow for, by viewer."""
    pictures: list[str] | None = None
    """Pictures written, with `--png`."""


class ShownRun(Document):
    """A run that was shown."""

    bundle: str
    """Its folder."""
    rows_not_shown: dict[str, int]
    """Rows that a viewer was too slow for, by viewer."""


class LiveRun(Document):
    """`live RUN`."""

    shown: list[ShownRun]
    """The runs shown."""
    pictures: list[str] | None = None
    """Pictures written, with `--png`."""


class Completion(Document):
    """`completion install`."""

    shell: str
    """The shell."""
    script: str
    """The script that was written."""
    startup: str | None
    """The startup file that reads it, where one is needed."""


class ServedWire(Document):
    """A wire of an emulated drive."""

    wire: str
    """What it is."""
    place: str
    """Where it is."""
    link: str
    """Its address, for `--link`."""


class Emulated(Document):
    """`emulate`, one line as soon as the drive can be reached."""

    profile: str
    """Profile of the drive."""
    node_id: int
    """Its node id."""
    wires: list[ServedWire]
    """Its wires."""


DOCUMENTS: dict[str, type[BaseModel]] = {
    "demo": Run,
    "run": Run,
    "run of a folder": Plans,
    "run --dry-run": DryRun,
    "plans": ListedPlans,
    "profiles": ListedProfiles,
    "plan new": NewPlan,
    "profile new": NewProfile,
    "analyze": Run,
    "analyze of a recording": Run,
    "analyze --csv": AnalyzedTable,
    "analyze --list": Kinds,
    "compare": Compared,
    "report": Reported,
    "record": Recorded,
    "export": Exported,
    "commission": Commissioned,
    "commission --dry-run": PlannedCommissioning,
    "jog": Jogged,
    "live": LiveEnd,
    "live of a run": LiveRun,
    "twin": Twins,
    "verify": Verified,
    "gauge": GaugeStudied,
    "acceptance": Accepted,
    "acceptance --mutants": TriedSuite,
    "info": DriveInfo,
    "info --eds": FileInfo,
    "scan": Scanned,
    "reset": Reset,
    "emulate": Emulated,
    "completion install": Completion,
    "doctor": Checks,
    "params list": Parameters,
    "params get": Values,
    "params set": WrittenValues,
    "params derive": DerivedParameters,
    "params dump": ParameterFile,
    "params diff": Differences,
    "params load": Loaded,
    "params save": Stored,
    "params restore": Restored,
}
"""What each command prints with `--json`, by the command."""
