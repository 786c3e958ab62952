"""Run bundles: a directory that holds what a run was, what it recorded and what came out.

manifest.json         what, when, with which profile, parameters, versions; how it ended; hashes of the files
data/NAME.arrows      a stream while it is recorded: every acknowledged batch survives the process
data/NAME.parquet     the same stream once the run is finished; columns carry units, metadata the time base
data/events.jsonl     what happened: steps, states, emergencies, each with its tick
data/checkpoints.log  while it is recorded: how far each file is acknowledged, with the hash of that part
data/frames.log       every frame, as `candump -L` writes them, where that was asked for
measurements.json     results with unit and definition
certificate.json      how good the data are: rows, gaps, jitter, saturation, clipping, link counters
plots/*.png           figures
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
