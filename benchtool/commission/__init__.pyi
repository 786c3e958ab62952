from .document import document as document
from .execution import (
    STEPS as STEPS,
    commission as commission,
    planned as planned,
    stated_parameters as stated_parameters,
    steps_for as steps_for,
)
from .kept import (
    DOCUMENT as DOCUMENT,
    KeptCommissioning as KeptCommissioning,
    read_commissioning as read_commissioning,
)
from .known import Known as Known
from .planned_energy import (
    PlannedEnergy as PlannedEnergy,
    planned_energy as planned_energy,
)
from .profile_file import commissioned_profile as commissioned_profile
from .recorder import (
    StepRecorder as StepRecorder,
    step_bundles as step_bundles,
)
from .results import (
    Commissioning as Commissioning,
    StepResult as StepResult,
    StepVerdict as StepVerdict,
)
from .steps.step import Step as Step
