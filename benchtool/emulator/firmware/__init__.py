"""The drive's firmware: dictionary, CiA 402 states, faults, link supervision; independent of frames."""
