"""Noise of a spectrum: its floor, what it adds to a line, and how it differs from period to period."""
