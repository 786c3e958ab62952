"""The true machine: motor, shaft, power stage, sensors. Compiled; control never sees it."""
