"""Cases of a plan in parallel processes, each with its own emulated bench."""

from __future__ import annotations

import gc
import multiprocessing
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from benchtool.bench import Session, open_session
from benchtool.errors import BenchError
from benchtool.plan import Case, Plan, cases
from benchtool.results import Assessment, RunResult, over_repetitions
from benchtool.run.case import Progress
from benchtool.run.resumption import Provenance, require_same_provenance
from benchtool.run.runner import RunInfo, run_cases
from benchtool.run.worker_process import begin_worker


@dataclass(frozen=True)
class _Task:
    """Task of a process: one case."""

    plan: Plan
    case: Case
    profile_name: str
    folder: Path
    info: RunInfo
    resume: bool


class _Silent:
    """Ignores progress in a worker process; the parent reports finished cases."""

    def begin(self, case: str, number: int, count: int) -> None:
        """Does nothing."""

    def note(self, text: str) -> None:
        """Does nothing."""


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

    The recordings are the same as those of a sequential run.

    Raises:
        BenchError: of the first case that failed; the others are completed.
    """
    todo = cases(plan)
    if resume:
        require_same_provenance(folder, Provenance(plan, info.link, info.seed, info.profile_toml))
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        min(jobs, len(todo)), context, initializer=begin_worker, initargs=gc.get_threshold()
    ) as pool:
        tasks = [pool.submit(_run, _Task(plan, case, profile_name, folder, info, resume)) for case in todo]
        try:
            for number, done in enumerate(as_completed(tasks), start=1):
                progress.begin(done.result().case, number, len(todo))
                progress.note("done")
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)  # cases that wait are not begun any more
            raise
    results = [task.result() for task in tasks]
    measured = {each.case: each.measurements for each in results}
    return RunResult(tuple(results), over_repetitions(plan, measured))


def _run(task: _Task) -> Assessment:
    """Run one case; its assessment crosses to the parent, two megabytes of it, because to make it again costs
    a third of what the case did."""

    def opener(case: Case, seed: int) -> AbstractContextManager[Session]:
        return open_session(task.profile_name, seed=seed, alter=case.emulator)

    try:
        (assessment,) = run_cases(
            opener, task.plan, [task.case], task.folder, task.info, _Silent(), resume=task.resume
        )
    except BenchError as error:
        error.add_note(f"in case {task.case.name}")
        raise
    return assessment
