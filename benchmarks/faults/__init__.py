"""What becomes of a running drive and of its host when something fails, fault by fault, on both wires."""
