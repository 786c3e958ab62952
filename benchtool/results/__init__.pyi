from .agreement import (
    Disagreement as Disagreement,
)
from .assessment import (
    Assessment as Assessment,
)
from .block_result import (
    EVERYTHING as EVERYTHING,
    analyses_of as analyses_of,
    analyze as analyze,
)
from .calibration import (
    Calibration as Calibration,
    Overdue as Overdue,
    overdue_text as overdue_text,
    stated_overdue as stated_overdue,
)
from .case_assessment import (
    assess as assess,
    assess_bundle as assess_bundle,
)
from .comparison import (
    Chance as Chance,
    Comparison as Comparison,
    MeasuredCase as MeasuredCase,
    RepeatedCase as RepeatedCase,
    SideBySide as SideBySide,
    compare_cases as compare_cases,
    compare_repeated as compare_repeated,
)
from .delta import (
    Delta as Delta,
    deltas as deltas,
)
from .differences import (
    Differences as Differences,
    Kind as Kind,
    valued as valued,
)
from .incomplete import (
    cut_short as cut_short,
    incomplete as incomplete,
)
from .judged_repetitions import (
    JudgedTogether as JudgedTogether,
)
from .recorded import (
    Recorded as Recorded,
)
from .recordings import (
    Selection as Selection,
    assess_recording as assess_recording,
)
from .repetitions import (
    Repeated as Repeated,
    judged_together as judged_together,
    over_repetitions as over_repetitions,
)
from .run_result import (
    RunResult as RunResult,
)
from .runs import (
    RecordedCase as RecordedCase,
    RecordedRun as RecordedRun,
    complete_cases as complete_cases,
    complete_of as complete_of,
    incomplete_runs as incomplete_runs,
    is_planned as is_planned,
    recorded_bundles as recorded_bundles,
    recorded_runs as recorded_runs,
    repeated_cases as repeated_cases,
)
from .sessions import (
    Attachment as Attachment,
    Judged as Judged,
    Outcome as Outcome,
    SessionRecord as SessionRecord,
    SuiteScore as SuiteScore,
    TestRecord as TestRecord,
    Waiver as Waiver,
    differing_verdicts as differing_verdicts,
    earlier_sessions as earlier_sessions,
    read_session as read_session,
    values_of as values_of,
    write_session as write_session,
)
from .tables import (
    TABLE as TABLE,
    assess_table as assess_table,
    is_table as is_table,
    stored_remarks as stored_remarks,
)
from .twin import (
    Signal as Signal,
    Twin as Twin,
    twins as twins,
)
from .verification import (
    Verification as Verification,
    verify_run as verify_run,
)
from .waived import (
    WaivedLimit as WaivedLimit,
    waived_limits as waived_limits,
)
