"""The steps of a commissioning, one file for each."""
