"""Byte ports that other programs open: pseudo-terminals and TCP."""
