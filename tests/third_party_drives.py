"""Third-party EDS files: standard objects, other names, no units, an old encoding."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

from benchtool.shipped import shipped

HEAD = "[DeviceInfo]\r\nVendorName=Müller Größenantriebe\r\nProductName=Servo µ\r\n"

# section: name, type, access, default
_OBJECTS = {
    "1000": ("Gerätetyp", 7, "ro", "0x20192"),
    "1001": ("Error register", 5, "ro", ""),
    "1010sub0": ("Largest sub-index", 5, "const", "1"),
    "1010sub1": ("Save all", 7, "rw", "0x1"),
    "1016sub0": ("Number of Entries", 5, "ro", "2"),
    "1016sub1": ("Consumer Heartbeat Time", 7, "rww", "0x0"),
    "1016sub2": ("Consumer Heartbeat Time_2", 7, "rw", "0"),
    "1017": ("Producer Heartbeat Time", 6, "rw", "0"),
    "6007": ("Abort connection option code", 3, "rw", "1"),
    "6040": ("Controlword 1", 6, "rww", "0"),
    "6041": ("Statusword 1", 6, "ro", ""),
    "6060": ("Modes of Operation 1", 2, "rww", "0x00"),
    "6061": ("Modes of Operation Display 1", 2, "ro", ""),
    "606C": ("Velocity actual value", 4, "ro", ""),
    "6071": ("Target Torque 1", 3, "rww", ""),
    "6076": ("Motor rated torque", 7, "rw", ""),
    "6077": ("Torque actual value", 3, "ro", ""),
    "607A": ("Target Position", 4, "rww", ""),
    "60FF": ("Target Velocity", 4, "rww", ""),
    "6502": ("Supported drive modes", 7, "ro", ""),
}


def third_party_eds(
    *, without: Collection[str] = (), changed: Mapping[str, Mapping[str, str]] | None = None
) -> bytes:
    """An EDS in Windows-1252 with 0x1016 as an ARRAY whose own section has neither type nor access.

    Args:
        without: sections to leave out: "6071", "1016sub2".
        changed: keys of sections that are otherwise than above.
    """
    text = HEAD
    for index in dict.fromkeys(section[:4] for section in _OBJECTS if "sub" in section):
        if any(section.startswith(f"{index}sub") and section not in without for section in _OBJECTS):
            text += f"[{index}]\r\nParameterName=Feld {index}\r\nObjectType=0x8\r\nSubNumber=3\r\n"
    for section, (name, type_, access, default) in _OBJECTS.items():
        if section in without:
            continue
        keys = {"ParameterName": name, "ObjectType": "0x7", "DataType": f"0x{type_:04X}"}
        keys |= {"AccessType": access, "DefaultValue": default, "PDOMapping": "1"}
        keys |= (changed or {}).get(section, {})
        text += f"[{section}]\r\n" + "".join(f"{key}={value}\r\n" for key, value in keys.items())
    return text.encode("cp1252")


def stripped_eds(*, without: Collection[str] = ()) -> bytes:
    """Return the EDS of the reference drive without benchtool's own objects.

    No units, factors, roles or enumerations, every object under another name.
    """
    text = (shipped("firmware_protocol") / "drive.eds").read_text(encoding="utf-8")
    kept = [HEAD.replace("\r\n", "\n") + "VendorNumber=0x00000B7C\nProductNumber=0x00002011\n"]
    for section in re.split(r"\n(?=\[)", text):
        header = re.match(r"\[([0-9A-F]{4})(sub[0-9a-f]+)?\]", section)
        if header is None or 0x2000 <= int(header[1], 16) < 0x6000:
            continue
        if header[1] in without or header[1] + (header[2] or "") in without:
            continue
        kept.append(
            re.sub(r"ParameterName=.*", f"ParameterName=Größe {header[1]} {header[2] or ''}", section)
        )
    return "\n".join(kept).encode("cp1252")
