"""Meaning of bytes: objects, dictionary, CiA 402 states, telemetry records. Without I/O and time."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
