"""Running a plan on a session: every case is run, recorded and assessed in turn."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
