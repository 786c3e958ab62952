from .arrow import (
    TimeBase as TimeBase,
    batch_of as batch_of,
    block_of as block_of,
    gaps_from_text as gaps_from_text,
    gaps_to_text as gaps_to_text,
    number_array as number_array,
    recorded_fields as recorded_fields,
    schema_of as schema_of,
    times_s as times_s,
    with_time as with_time,
)
from .block import (
    Block as Block,
    Channel as Channel,
    Gap as Gap,
    as_samples as as_samples,
    read_only as read_only,
    require_rate as require_rate,
)
