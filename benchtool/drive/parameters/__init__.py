"""Parameters of a drive: as a file, moved between dictionaries, written all or none, kept over a reset."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
