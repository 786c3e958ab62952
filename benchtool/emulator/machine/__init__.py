"""The machine as it really is: motor, shaft, power stage, sensors. Compiled; control never sees it."""
