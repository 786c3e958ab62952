"""The Python API: what `import benchtool` gives, a face over the same functions that the command line calls.

Nothing that is heavy is imported until it is used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
