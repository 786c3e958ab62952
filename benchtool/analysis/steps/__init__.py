"""Steps: times, excursions and plateaus of an answer, in noise."""
