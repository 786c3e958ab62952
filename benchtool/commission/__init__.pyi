from .document import document as document
from .execution import (
    STEPS as STEPS,
    Commissioning as Commissioning,
    StepResult as StepResult,
    StepVerdict as StepVerdict,
    commission as commission,
    planned as planned,
    steps_for as steps_for,
)
from .known import Known as Known
from .steps.step import Step as Step
