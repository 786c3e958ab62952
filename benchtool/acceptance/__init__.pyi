from .measuring import Measure as Measure
from .notes import Attach as Attach
