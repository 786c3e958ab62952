"""What CANopen adds to a dictionary (CiA 301): network management, process data, emergencies, abort codes."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
