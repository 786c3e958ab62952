"""The live view in Rerun: a drive while it runs, and recorded runs in the same panels."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
