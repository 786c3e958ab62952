"""The serial protocol as pure functions: frames, messages, batches of telemetry. No I/O, no time."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
