from .period_marks import (
    PeriodMarks as PeriodMarks,
    marks_of_rotor as marks_of_rotor,
    marks_of_tone as marks_of_tone,
)
