"""What recorded cases come to: measurements, verdicts, repetitions together, and how runs differ."""
