from .flux_balance import (
    FluxBalance as FluxBalance,
    flux_balance as flux_balance,
)
