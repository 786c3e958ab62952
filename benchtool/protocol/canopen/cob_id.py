"""CAN identifiers of CANopen (CiA 301, 7.3.3, the predefined connection set) and the bits of a COB-ID object.

Identifiers of one node are a base plus its node id, 1 to 127.
"""

from __future__ import annotations

NMT = 0x000
"""Node control, sent by the master to all."""

EMCY = 0x080
SDO_RESPONSE = 0x580
"""Server to client."""

SDO_REQUEST = 0x600
"""Client to server."""

HEARTBEAT = 0x700

RPDO = (0x200, 0x300)
TPDO = (0x180, 0x280, 0x380, 0x480, 0x1C0, 0x2C0, 0x3C0, 0x4C0)
"""The first four TPDOs are of the predefined connection set, which has no more; the others are free while
every node id on the bus is below 64."""

LAST_NODE_OF_EIGHT_TPDOS = 63

FIRST_OF_PDO, LAST_OF_PDO = TPDO[0] + 1, SDO_RESPONSE - 1
"""Identifiers that a PDO may have; below are NMT, SYNC and EMCY, above SDO and heartbeat."""

NODES = range(1, 128)
HOST_NODE = 127
"""The node id under which a host of this project sends heartbeats."""

INVALID = 1 << 31
"""Bit of a COB-ID object: the PDO is not in use."""

CAN_ID = 0x7FF
"""Bits of a COB-ID object that are the 11-bit identifier."""
