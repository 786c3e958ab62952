"""Signals at equal steps of their phase, over whole periods, and the spectrum of these."""
