"""The wires of the emulated drive: each server carries one firmware over one kind of link."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
