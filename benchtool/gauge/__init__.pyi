from .inference import Inferred as Inferred
from .readings import (
    Readings as Readings,
    read_readings as read_readings,
)
from .study import (
    Component as Component,
    GaugeStudy as GaugeStudy,
    Source as Source,
    study as study,
)
