"""Pure functions from captures to estimates, one file for each; nothing here knows a drive."""
