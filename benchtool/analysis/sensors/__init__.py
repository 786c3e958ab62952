"""Stated sensors and clocks: what they add to an uncertainty, and corrections for their bandwidth."""
