"""Cases of a plan in processes of their own: emulated benches share nothing, a sweep may use every core."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from benchtool.bench.session import Session, open_session
from benchtool.errors import BenchError
from benchtool.plan.cases import Case, cases
from benchtool.plan.model import Plan
from benchtool.recording import Bundle
from benchtool.report.assembly.figures import draw_cases
from benchtool.results.assessment import RunResult, assess_bundle
from benchtool.results.repetitions import over_repetitions
from benchtool.run.conduct import Progress
from benchtool.run.resumption import Origin, case_folder, require_same_origin
from benchtool.run.runner import RunInfo, run_cases


@dataclass(frozen=True)
class _Task:
    """What a process needs to run one case."""

    plan: Plan
    case: Case
    profile_name: str
    folder: Path
    info: RunInfo
    resume: bool


class _Silent:
    """Nobody watches a process; its parent tells of the cases that are done."""

    def begin(self, case: str, number: int, count: int) -> None:
        """Nothing."""

    def note(self, text: str) -> None:
        """Nothing."""


def run_in_processes(
    plan: Plan,
    profile_name: str,
    folder: Path,
    info: RunInfo,
    progress: Progress,
    *,
    jobs: int,
    resume: bool = False,
) -> RunResult:
    """Run every case of `plan` on an emulated bench of its own, `jobs` at a time.

    The recordings are those that one process after the other would make.

    Raises:
        BenchError: of the first case that failed; the others are brought to their end.
    """
    todo = cases(plan)
    if resume:
        require_same_origin(folder, Origin(plan, info.link, info.seed, info.profile_toml))
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(max_workers=min(jobs, len(todo)), mp_context=context) as pool:
        tasks = [pool.submit(_run, _Task(plan, case, profile_name, folder, info, resume)) for case in todo]
        for number, done in enumerate(as_completed(tasks), start=1):
            progress.begin(done.result(), number, len(todo))
            progress.note("done")
    results = [assess_bundle(Bundle.open(case_folder(plan, case, folder))) for case in todo]
    draw_cases(plan, results, folder)
    measured = {each.case: each.measurements for each in results}
    return RunResult(tuple(results), over_repetitions(plan, measured))


def _run(task: _Task) -> str:
    def opener(case: Case, seed: int) -> AbstractContextManager[Session]:
        return open_session(task.profile_name, seed=seed, alter=case.emulator)

    try:
        run_cases(opener, task.plan, [task.case], task.folder, task.info, _Silent(), resume=task.resume)
    except BenchError as error:
        error.add_note(f"in case {task.case.name}")
        raise
    return task.case.name
