from .checkpoints import (
    Checkpoints as Checkpoints,
    HashedFile as HashedFile,
)
from .events import (
    Event as Event,
    EventFile as EventFile,
    Level as Level,
)
from .export import (
    Format as Format,
    export as export,
)
from .failures import (
    reading as reading,
    writing as writing,
)
from .files import (
    replacing as replacing,
    require_empty as require_empty,
    require_file as require_file,
    require_free as require_free,
    require_own as require_own,
    write_whole as write_whole,
)
from .integrity import (
    COMMISSIONING as COMMISSIONING,
    HASHES as HASHES,
    SESSION as SESSION,
    Integrity as Integrity,
    bundles_in as bundles_in,
    enlist as enlist,
    require_listed as require_listed,
    require_unchanged as require_unchanged,
    verify as verify,
)
from .manifest import (
    MANIFEST as MANIFEST,
    Conditions as Conditions,
    Manifest as Manifest,
    StreamInfo as StreamInfo,
    read_manifest as read_manifest,
    software_versions as software_versions,
)
from .reader import Bundle as Bundle
from .seal import (
    hash_of as hash_of,
    read_sealed_json as read_sealed_json,
    write_json as write_json,
)
from .writer import BundleWriter as BundleWriter
