"""The firmware's side of the protocol: the table of objects and what is generated from it."""
