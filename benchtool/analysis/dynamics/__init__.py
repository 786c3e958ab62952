"""Steps and frequency responses."""
