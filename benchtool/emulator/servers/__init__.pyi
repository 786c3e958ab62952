from .drive_node import OnGone as OnGone
from .slcan import SlcanAdapter as SlcanAdapter
