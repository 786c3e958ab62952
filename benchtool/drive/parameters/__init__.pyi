from .file import (
    describe as describe,
    read_parameter_file as read_parameter_file,
    render as render,
    write_parameter_file as write_parameter_file,
)
from .migration import shipped_migrations as shipped_migrations
from .overview import (
    Parameter as Parameter,
    overview as overview,
)
from .settings import (
    Difference as Difference,
    aligned as aligned,
    as_held as as_held,
    compare as compare,
    settings as settings,
)
from .storage import (
    reset as reset,
    restore_defaults as restore_defaults,
    store as store,
)
from .transaction import (
    default_of as default_of,
    held as held,
    parameter as parameter,
    parameters as parameters,
    readable as readable,
    require_disabled as require_disabled,
    snapshot as snapshot,
    temporary as temporary,
    write_all as write_all,
)
