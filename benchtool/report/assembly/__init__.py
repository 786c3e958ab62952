"""Reports assembled from results: one case, a plan, a comparison, a table of another tool."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
