"""Spectra of periodic signals: harmonics, groups, noise, the fundamental, unbalance."""
