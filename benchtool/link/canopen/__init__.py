"""The host end of a CANopen link: buses, the SDO client, and the link itself."""
