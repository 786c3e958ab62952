"""Torque: its mean, its ripple, and how far a prediction by the machine model is from it."""
