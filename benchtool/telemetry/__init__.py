"""The telemetry stream on the host: received, decoded, checked and passed to sinks."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
