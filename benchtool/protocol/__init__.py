"""What bytes mean: objects, dictionary, CiA 402 states, telemetry records. No I/O, no time."""
