"""The wires to a drive: each declared once, found by the scheme of its address.

A declaration imports nothing that is heavy until it is used: the command line reads the spellings of all.
"""
