"""Figures of results and recordings, as matplotlib figures without pyplot."""
