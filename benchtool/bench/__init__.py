"""The composition root: profiles and addresses become sessions, the emulated drive a device of its own."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
