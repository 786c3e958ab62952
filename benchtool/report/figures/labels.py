"""Labels of axes: the quantity in words, its symbol, and its unit, from the names that channels, swept keys
and measurements have in tables and files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from benchtool.document import unit_suffix
from benchtool.report.figures.style import literal
from benchtool.tables import KNOWN

_CHANNELS: Final[Mapping[str, tuple[str, str]]] = {
    "torque": ("torque", "T"),
    "torque_reference": ("torque reference", "T^*"),
    "torque_transducer": ("shaft torque", "T_m"),
    "i_a": ("current of phase a", "i_a"),
    "i_b": ("current of phase b", "i_b"),
    "i_c": ("current of phase c", "i_c"),
    "i_d": ("direct-axis current", "i_d"),
    "i_q": ("quadrature-axis current", "i_q"),
    "i_alpha": ("current, alpha", r"i_\alpha"),
    "i_beta": ("current, beta", r"i_\beta"),
    "psi_s": ("stator flux, peak", r"\psi_s"),
    "psi_s_reference": ("stator flux reference, peak", r"\psi_s^*"),
    "psi_alpha": ("stator flux, alpha", r"\psi_\alpha"),
    "psi_beta": ("stator flux, beta", r"\psi_\beta"),
    "theta_m": ("mechanical angle", r"\theta_m"),
    "theta_e": ("electrical angle", r"\theta_e"),
    "omega_m": ("mechanical speed", r"\omega_m"),
    "omega_m_reference": ("mechanical speed reference", r"\omega_m^*"),
    "omega_e": ("electrical speed", r"\omega_e"),
    "u_alpha": ("voltage, alpha", r"u_\alpha"),
    "u_beta": ("voltage, beta", r"u_\beta"),
    "u_dc": ("dc-link voltage", "u_{dc}"),
    "i_dc": ("dc-link current", "i_{dc}"),
}
_KEYS: Final[Mapping[str, tuple[str, str]]] = {
    "load_torque": ("load torque", "T_L"),
    "hold_speed": ("held speed", r"\omega_m"),
    "R_s": ("stator resistance", "R_s"),
    "L_d": ("direct-axis inductance", "L_d"),
    "L_q": ("quadrature-axis inductance", "L_q"),
    "psi_r": ("rotor flux, peak", r"\psi_r"),
    "u_s": ("voltage vector, peak", "u_s"),
    "T_k_ratio": ("share of the control period", "T_k/T_s"),
}
_GREEK: Final = re.compile(r"\b(alpha|beta|theta|lambda|omega|psi)\b")
_UNITS: Final = {
    unit_suffix(unit): unit for unit in (*KNOWN, "%", "degC", "deg", "Nms/rad", "Nm/rad", "rad/s2", "1/s")
}
_SYMBOL: Final = re.compile(r"(?:[A-Za-z]|alpha|beta|theta|lambda|omega|psi)(?:_[a-z0-9]{1,2})+")
_STATED_UNIT: Final = re.compile(r"\s*(?:\[[^\]]*\]|\([^)]*\))$")
_BY_TRANSDUCER: Final = "transducer_"
_ENDINGS: Final = (
    ("_pp", ", peak to peak"),
    ("_rms", ", rms"),
    ("_percent", ", percent"),
)
_INSIDE: Final = {
    "percent of": ", percent of",
    "rms percent": "rms, percent",
    "thd f": "THD-F",
    "thd r": "THD-R",
    "tdd": "TDD",
    "dc": "dc",
}


def with_unit(text: str, unit: str) -> str:
    """Return a label with its unit in parentheses, where there is one."""
    return f"{text} ({unit})" if unit else text


def channel_label(name: str, unit: str) -> str:
    """Return the label of a recorded channel: `torque $T$ (Nm)`; one that is not known by name is told in its
    words."""
    words = _STATED_UNIT.sub("", name) if unit else name  # the head of a table may state its own
    words, symbol = _CHANNELS.get(name, (literal(words.replace("_", " ")), ""))
    return with_unit(_with_symbol(words, symbol), unit)


def swept_label(key: str) -> str:
    """Return the label of a swept key, whose name ends with its unit: `load_torque_Nm`,
    `inverter.dead_time_s`."""
    place, _, last = key.rpartition(".")
    name, unit = _split(last)
    words, symbol = _KEYS.get(name) or _CHANNELS.get(name) or ("", name)
    if not words and _SYMBOL.fullmatch(name):
        words, symbol = "", _as_symbol(name)
    elif not words:
        words, symbol = name.replace("_", " "), ""
    told = _with_symbol(words, symbol).strip()
    return with_unit(f"{place.replace('.', ' ')} {told}".strip(), unit)


def measurement_label(name: str, unit: str) -> str:
    """Return the label of a measurement: `torque ripple, peak to peak (Nm)`."""
    text = name.removeprefix(_BY_TRANSDUCER)
    of_shaft = text != name
    for ending, said in _ENDINGS:
        if text.endswith(ending):
            text = text.removesuffix(ending) + said
    text = text.replace("_", " ")
    for short, said in _INSIDE.items():
        text = re.sub(rf"\s?\b{short}\b", said if said.startswith(",") else f" {said}", text)
    text = text.strip()
    return with_unit(f"{text}, by the transducer" if of_shaft else text, unit)


def _split(key: str) -> tuple[str, str]:
    """Return the name and unit of a key; the longest unit that it ends with."""
    for ending in sorted(_UNITS, key=len, reverse=True):
        if ending and key.endswith(f"_{ending}"):
            return key.removesuffix(f"_{ending}"), _UNITS[ending]
    return key, ""


def _as_symbol(name: str) -> str:
    head, *below = name.split("_")
    head = _GREEK.sub(lambda found: f"\\{found[0]}", head)
    return f"{head}_{{{','.join(below)}}}"


def _with_symbol(words: str, symbol: str) -> str:
    return f"{words} ${symbol}$" if symbol else words
