from .bode import (
    FREQUENCY_RESPONSE as FREQUENCY_RESPONSE,
    Bode as Bode,
)
