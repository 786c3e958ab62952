from .dictionary import Dictionary as Dictionary
from .keys import (
    setting_of as setting_of,
    toml_key as toml_key,
    variable_of as variable_of,
)
from .objects import (
    DataType as DataType,
    Entry as Entry,
    Number as Number,
    ObjectTable as ObjectTable,
    load_table as load_table,
)
from .profiled import profiled_dictionary as profiled_dictionary
from .quantity import (
    parse_quantity as parse_quantity,
    parse_value as parse_value,
    plain as plain,
    shown as shown,
    spellings as spellings,
)
from .relations import (
    Relation as Relation,
    first_breach as first_breach,
    relations as relations,
)
from .roles import Role as Role
from .sensed import (
    TRANSDUCER as TRANSDUCER,
    sensed_units as sensed_units,
    sensed_units_of as sensed_units_of,
)
from .variable import (
    Value as Value,
    Variable as Variable,
)
