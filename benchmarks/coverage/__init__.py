"""Whether stated uncertainties hold, over families of signals whose truth is known by construction."""
