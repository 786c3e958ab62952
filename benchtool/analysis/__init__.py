"""Pure functions from samples to numbers that carry their definition.

A `Block` can be made of plain arrays: `benchtool.block.Block.from_arrays`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
