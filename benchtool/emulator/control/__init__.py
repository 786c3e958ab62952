"""The drive's control: what runs in every tick on measurements and estimated parameters alone."""
