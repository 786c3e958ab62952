"""Test plans: what to set, where to run, what to record, what to measure and which limits to hold."""
