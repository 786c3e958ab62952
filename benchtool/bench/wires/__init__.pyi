from . import registry as registry
from .address import (
    Address as Address,
    did_you_mean as did_you_mean,
)
from .failures import naming_wires as naming_wires
from .wire import FarEnd as FarEnd, Offered as Offered, Opening as Opening, Wire as Wire
