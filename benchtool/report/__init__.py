"""Figures, pages and the digits of numbers, from blocks and analysis results."""
