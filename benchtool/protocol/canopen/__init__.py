"""What CANopen adds to a dictionary (CiA 301): network management, process data, emergencies, abort codes."""
