"""The wires to a drive: each declared once, found by the scheme of its address.

A declaration imports nothing that is heavy until it is used: the command line reads the spellings of all.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
