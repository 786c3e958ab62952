"""The path of the stator flux in the plane."""
