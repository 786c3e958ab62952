"""The object dictionary of a drive: its variables, roles, units and spellings."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
