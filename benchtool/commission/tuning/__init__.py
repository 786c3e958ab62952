"""Loops tuned from the identified plant: what they are designed to be, and what a Bode plot shows of them."""
