"""The index of the decisions by subject: the sections below, with the titles that the pages have.

A new decision is one number more in `SECTIONS`, at the place where a reader of its section should meet it.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

FOLDER: Final = Path(__file__).parents[1] / "decisions"
_TITLE: Final = re.compile(r"# (\d{4}) (\S.*)")
_SUPERSEDED: Final = re.compile(r"^Superseded by (\d{4})\b", re.MULTILINE)

_HEAD: Final = """\
# Decisions

Where something is a design choice, a page says what the context was, what was chosen, and what follows. The
pages are listed by subject, and within a section in an order for reading. A page describes the project as it
was when the page was written; what holds today is in the explanations, the reference and the code. This index
is generated from `docs/generate/decisions.py`.
"""

_TOCTREE: Final = """\
```{toctree}
:hidden:
:glob:
*
```
"""


@dataclass(frozen=True)
class Section:
    """Decisions on one subject: the numbers of their pages in reading order, each of four digits."""

    title: str
    sentence: str
    listed: str

    @property
    def numbers(self) -> list[str]:
        """The numbers, one by one."""
        return self.listed.split()


SECTIONS: Final = (
    Section(
        "Wires and protocols",
        "What is sent between host and drive over CAN and serial lines, and how the host finds its way in "
        "the object dictionary of a drive (`benchtool.link`, `benchtool.protocol`).",
        """
        0053 0054 0055 0010 0006 0002 0007 0023 0032
        0001 0024 0049 0050 0052
        """,
    ),
    Section(
        "Firmware of the drive",
        "What a drive does behind its wires, emulated (`benchtool.emulator.firmware`) and in the C library "
        "alike: states, test signals, stored parameters, time.",
        """
        0011 0005 0003 0013 0025 0026 0022 0008 0116 0166 0117
        """,
    ),
    Section(
        "Emulated machine, inverter and sensors",
        "The equations of the plant and how they are integrated over a control period "
        "(`benchtool.emulator.machine`).",
        """
        0095 0103 0156 0105 0106 0096 0107 0108 0109
        0094 0101 0102 0104 0165
        0113 0157 0162 0198
        """,
    ),
    Section(
        "Control laws and the paper",
        "Torque predictive control after Zhu, Xiao and Li, the laws beside it "
        "(`benchtool.emulator.control`), and how the claims of the paper are judged.",
        """
        0021 0376 0015 0016 0019
        """,
    ),
    Section(
        "Safety",
        "What stops the motor when host, cable, drive or operator fail, and what keeps a drive from being "
        "enabled.",
        """
        0004 0051 0151 0134 0144 0143
        0028 0020 0149 0150
        """,
    ),
    Section(
        "Profiles and equipment of the bench",
        "How a motor, its drive and the instruments around them are described (`benchtool.profile`).",
        """
        0086 0085 0110 0112 0059 0060 0061
        """,
    ),
    Section(
        "Commissioning: steps, loops and what is stored",
        "In which order a motor is identified, how its control loops are tuned and checked, and when the "
        "drive keeps what was found (`benchtool.commission`).",
        """
        0118 0152 0136 0135 0171 0178 0138 0177 0197
        0137 0176 0183 0194 0196 0399
        """,
    ),
    Section(
        "Commissioning: parameters of the motor, and the twin",
        "How resistance, inductances, encoder, rotor flux, inertia and saturation are estimated, one after "
        "the other, and how a recorded run tells which parameter is wrong.",
        """
        0119 0170 0190 0193
        0132 0175
        0133 0169 0173 0191 0174
        0153 0172 0184
        0154 0185
        0120 0121 0122 0455 0466 0506 0507
        """,
    ),
    Section(
        "Plans, runs and recordings",
        "What a plan asks for, what a run does, and how a recording is kept (`benchtool.plan`, "
        "`benchtool.run`, `benchtool.recording`).",
        """
         0009 0027 0517 0087 0111 0155 0131 0521 0403
         0030 0349 0031 0080 0145 0078
        """,
    ),
    Section(
        "Tables of other tools",
        "How CSV files of oscilloscopes, loggers and other programs are read: columns, units, time, missing "
        "and repeated rows (`benchtool.tables`).",
        """
        0041 0357 0300 0214 0374 0393 0213 0338 0457
        0068 0368 0257 0235 0337 0356 0515 0217 0520
        """,
    ),
    Section(
        "Results, limits and comparison",
        "How a number is judged by its limit, what repetitions tell together, and when two runs differ "
        "(`benchtool.results`).",
        """
        0038 0511 0058 0328 0369 0354 0524 0525 0513 0287 0400 0039 0401 0066 0329
        """,
    ),
    Section(
        "Acceptance, faults and gauge studies",
        "Tests by which a drive is accepted, the defects on which these tests are tried, and studies of "
        "repeatability (`benchtool.acceptance`, `benchtool.gauge`).",
        """
        0139 0140 0142 0141 0123 0514
        """,
    ),
    Section(
        "Reports, live view, command line and Python",
        "What a person sees and types.",
        """
        0089 0090 0014 0091 0088 0073 0074 0075 0516 0518
        """,
    ),
    Section(
        "Uncertainty: terms, and how coverage is measured",
        "What a stated uncertainty is, and the random records by which it is checked (`python -m "
        "benchmarks.coverage`).",
        """
        0012 0034 0045 0234 0512 0352 0433 0292 0406
        0036 0043 0067 0126 0161 0467 0480 0541 0164 0275 0332
        """,
    ),
    Section(
        "Sensors in the uncertainty",
        "Gain, offset, bandwidth, resolution, calibration and sample times of the instruments, in every "
        "number that they touch (`benchtool.analysis.sensors`).",
        """
        0062 0269 0063 0064 0216 0402 0435 0253 0419 0268 0254 0069 0079 0394 0485 0522 0534 0536 0538
        """,
    ),
    Section(
        "Quantisation: steps of converters and encoders",
        "What quantisation does to a number, and how its step is found (`benchtool.analysis.quantisation`).",
        """
        0046 0076 0222 0279 0282 0291 0249 0378 0239 0371 0465
        0345 0342 0331 0181 0339 0365 0377 0409 0475 0427 0468 0505
        """,
    ),
    Section(
        "Mean and rms: noise slower than the record",
        "The uncertainty of a mean or rms whose values are correlated or wander, by their density at the "
        "lowest frequencies (`benchtool.analysis.statistics`).",
        """
        0077 0124 0434 0146 0163 0247 0311 0439 0508 0422 0436 0493 0494
        """,
    ),
    Section(
        "Mean and rms: periods, lines and courses",
        "The uncertainty of a mean or rms over periods that are not whole, or whose values cycle or drift "
        "(`benchtool.analysis.statistics`, `benchtool.analysis.torque`).",
        """
        0218 0397 0408 0443 0230 0290 0445 0474 0500 0476 0547 0495 0358 0430 0453
        """,
    ),
    Section(
        "Torque ripple: extremes and percentiles",
        "How much peak-to-peak values and percentiles of a ripple scatter (`benchtool.analysis.torque`).",
        """
        0125 0231 0283 0285 0367 0313 0323 0361 0362 0286
        0232 0248 0350 0360 0312 0351
        """,
    ),
    Section(
        "Spectra: the phase that is followed",
        "Over which course of the phase a spectrum is taken (`benchtool.analysis.phase`).",
        """
        0035 0180 0186 0221 0236 0320 0304 0340 0189 0413 0417 0241 0301 0370 0477 0509
        """,
    ),
    Section(
        "Spectra: the fundamental frequency",
        "What the phase of a signal and an angle say of the frequency, from the first row to the last "
        "(`benchtool.analysis.phase`).",
        """
        0206 0245 0549 0415 0416 0353 0375 0431 0503 0438 0418 0428 0442 0310 0539
        """,
    ),
    Section(
        "Spectra: harmonics and what is beside them",
        "The uncertainty of harmonics by what is around the lines, and sinusoids that are taken out "
        "(`benchtool.analysis.spectra`).",
        """
        0147 0159 0548 0188 0446 0273 0318 0272 0276 0550 0486 0411 0412 0464 0469 0528 0530 0440 0441 0421
        0542 0327
        """,
    ),
    Section(
        "Spectra: distortion, groups and noise",
        "The uncertainty of THD, of groups and of the noise floor "
        "(`benchtool.analysis.spectra`, `benchtool.analysis.noise`).",
        """
        0044 0158 0278 0414 0526 0447 0527 0429 0396 0449 0478 0319 0202 0233 0244 0504
        """,
    ),
    Section(
        "Spectra: lines without an angle",
        "The largest lines of a torque or current: whether they are one line, steady, and above the noise "
        "(`benchtool.analysis.lines`).",
        """
        0220 0226 0277 0303 0379 0385 0395 0404 0454 0483
        """,
    ),
    Section(
        "Orders, and errors of a measured angle",
        "Orders against the rotor angle, and how an error of the angle is told from a motion of the rotor "
        "(`benchtool.analysis.orders`, `benchtool.analysis.lines.course`).",
        """
        0215 0322 0384 0398 0386 0256 0317 0321 0456 0326 0487 0496
        0497
        0238 0344 0348 0405 0410 0359 0324 0343 0347 0448 0491 0452
        """,
    ),
    Section(
        "Flux path and unbalance",
        "Centre, radius and orders of the stator flux, and symmetrical components of the currents "
        "(`benchtool.analysis.flux`, `benchtool.analysis.spectra.unbalance`).",
        """
        0219 0289 0314 0363 0407 0529 0432
        0042 0293 0302 0316 0341 0492 0498
        """,
    ),
    Section(
        "Step response: levels, rest and drifts",
        "When a level is known well enough that a step has numbers, and from when on a signal is at rest "
        "(`benchtool.analysis.steps`).",
        """
        0098 0308 0298 0225 0250 0390 0392 0212 0420 0533 0501 0502
        0274 0309 0381 0499 0484 0523 0488 0437
        """,
    ),
    Section(
        "Step response: samples that have arrived",
        "Plateau and tracking error, which are those of the samples (`benchtool.analysis.steps`).",
        """
        0210 0280 0540 0551 0334 0366 0364 0451 0471 0535 0537
        """,
    ),
    Section(
        "Step response: smooth curve and times",
        "The curve through noisy samples, and latency, rise, reach and settling time on it "
        "(`benchtool.analysis.steps`).",
        """
        0047 0179 0242 0195 0470 0472 0473 0490 0546 0307 0426 0461
        0148 0201 0299 0252 0281 0423 0223 0305 0288 0297 0383 0336
        """,
    ),
    Section(
        "Step response: overshoot, undershoot and peak time",
        "The extremes of an answer: corners, tops between rows, and what noise adds to the greatest value "
        "(`benchtool.analysis.steps`).",
        """
        0200 0284 0391 0424 0463 0489 0459 0224 0380 0211 0251 0382 0306 0258 0333 0387
        """,
    ),
    Section(
        "Frequency response: the estimate and its errors",
        "Gain and phase of a loop or plant, from periods and without them, and what noise, drifts and steps "
        "of converters do to them (`benchtool.analysis.responses`).",
        """
        0048 0207 0227 0458 0295 0388 0389 0373 0372 0325 0425 0296
        """,
    ),
    Section(
        "Frequency response: bandwidth, resonance, margins and gain at rest",
        "The numbers that are read off a response (`benchtool.analysis.responses`).",
        """
        0160 0187 0228 0243 0335 0450
        0208 0229 0271 0444 0460
        0209 0270 0294 0315 0346 0355 0462 0479 0481
        """,
    ),
    Section(
        "Packages, names and declarations",
        "How the code is divided, how an analysis is declared, and how things are named.",
        """
        0065 0482 0092 0330 0056 0057 0029 0070 0071
        """,
    ),
    Section(
        "Documentation, tests and compatibility",
        "How pages are made and checked, how tests are tried, and what a version promises.",
        """
        0081 0082 0083 0084 0033 0130 0205 0519 0531
        """,
    ),
    Section(
        "Speed of commands and of the compiled kernel",
        "What a command loads, and how the emulated machine is compiled, kept and called "
        "(`benchtool.emulator`).",
        """
        0115 0510 0097 0182 0192
        0093 0114 0127 0203 0204 0168 0199
        """,
    ),
)


def page(folder: Path = FOLDER, sections: Sequence[Section] = SECTIONS) -> str:
    """Return the index of the decisions of a folder.

    Raises:
        ValueError: a first line is not `# NNNN Title`, or a decision is not in exactly one section.
    """
    pages = {path.name: path.read_text(encoding="utf-8") for path in sorted(folder.glob("[0-9]*.md"))}
    entries = _entries(pages)
    _require_one_section_each(entries, sections)
    links = "\n".join(f"- [{each.title}](#{_anchor(each.title)})" for each in sections)
    parts = (_HEAD, f"{links}\n", *(_of_section(each, entries) for each in sections), _TOCTREE)
    return "\n".join(parts)


def _entries(pages: Mapping[str, str]) -> dict[str, str]:
    """Return the line of the index for each page, by its number."""
    entries: dict[str, str] = {}
    for name, text in pages.items():
        heading = text.partition("\n")[0]
        found = _TITLE.fullmatch(heading)
        if found is None or not name.startswith(f"{found[1]}-"):
            raise ValueError(f"docs/decisions/{name} begins with {heading!r}, expected '# {name[:4]} Title'")
        number, title = found.groups()
        if number in entries:
            raise ValueError(f"two pages of docs/decisions have the number {number}: {name} needs another")
        later = _SUPERSEDED.search(text)
        entries[number] = f"- [{number}]({name}) {title}{f' (superseded by {later[1]})' if later else ''}"
    return entries


def _require_one_section_each(entries: Mapping[str, str], sections: Sequence[Section]) -> None:
    listed = Counter(number for section in sections for number in section.numbers)
    faults = {
        "in no section": sorted(entries.keys() - listed.keys()),
        "without a page": sorted(listed.keys() - entries.keys()),
        "listed more than once": sorted(number for number, times in listed.items() if times > 1),
    }
    told = [f"{fault}: {', '.join(numbers)}" for fault, numbers in faults.items() if numbers]
    if told:
        raise ValueError(
            f"decisions {'; '.join(told)}. Each number of docs/decisions stands in exactly one section of "
            "SECTIONS in docs/generate/decisions.py: write it into that of its subject, or take it out, "
            "then run python -m docs.generate"
        )


def _anchor(title: str) -> str:
    """Return the anchor that a forge and the builder give a heading."""
    return re.sub(r"[^\w\- ]", "", title).lower().replace(" ", "-")


def _of_section(section: Section, entries: Mapping[str, str]) -> str:
    lines = "\n".join(entries[number] for number in section.numbers)
    return f"## {section.title}\n\n{section.sentence}\n\n{lines}\n"
