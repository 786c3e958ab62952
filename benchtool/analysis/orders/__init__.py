"""What repeats per revolution."""
