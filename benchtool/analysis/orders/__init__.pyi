from .angle import (
    across_gaps as across_gaps,
    angle_coverage as angle_coverage,
    revolution_rows as revolution_rows,
    unwrapped_angle as unwrapped_angle,
)
from .held_angle import held_angle as held_angle
from .order_spectrum import (
    OrderSpectrum as OrderSpectrum,
    fitted_orders as fitted_orders,
    orders_at_speed as orders_at_speed,
)
from .orders import (
    SPEED_ORDERS as SPEED_ORDERS,
    TORQUE_ORDERS as TORQUE_ORDERS,
    Orders as Orders,
    describe_orders as describe_orders,
    order_analysis as order_analysis,
)
from .orders_of_machine import (
    machine_orders as machine_orders,
    order_meaning as order_meaning,
)
