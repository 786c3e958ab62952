"""`benchtool acceptance`: the shipped suite, and the suite tried on mutants."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from benchtool.acceptance import Trial, conduct_campaign, run_suite
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import UsageError
from benchtool.profile import load_profile
from benchtool.recording import write_whole
from benchtool.results import SessionRecord

_CLEAN = 200
_EXIT = {0: 0, 1: 1, 2: 130, 3: 3, 4: 2, 5: 2}
"""Exit codes of this command by those of pytest."""


def acceptance(
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    out: Annotated[
        Path | None, typer.Option(help="Folder of the session.", show_default="runs/<time>-acceptance")
    ] = None,
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the verdicts as JUnit XML, for a CI server.")
    ] = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Write the report as PDF, too.")] = False,
    only: Annotated[
        str,
        typer.Option("--only", metavar="EXPR", help="Tests to run, as pytest's -k: 'torque and not step'."),
    ] = "",
    waivers: Annotated[
        Path | None, typer.Option(metavar="FILE", help="TOML file of tests that may fail, with who consents.")
    ] = None,
    operator: options.Operator = "",
    serial_number: options.SerialNumber = "",
    temperature: options.Temperature = None,
    instrument: options.InstrumentsBeside = None,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    jobs: Annotated[int, typer.Option(min=1, help="Emulated benches at a time.")] = 1,
    mutants: Annotated[
        bool,
        typer.Option("--mutants", help="Try the suite itself, on drives with a defect and on sound ones."),
    ] = False,
    clean: Annotated[int, typer.Option(min=0, help="Runs of sound drives with --mutants.")] = _CLEAN,
    mutant: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="One mutant instead of all; once for each.")
    ] = None,
    score: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the score of --mutants as JSON.")
    ] = None,
    as_json: options.Json = False,
) -> int:
    """Run the acceptance suite on a drive, and write one report of the session."""
    output = Output(as_json=as_json)
    load_profile(profile)
    if mutants:
        return _campaign(profile, clean, jobs, mutant or [], seed, score, output)
    if mutant or score is not None:
        raise UsageError("--mutant and --score are of --mutants: give that, or leave them out")
    options.require_temperature(temperature)
    words = ["--bench", profile, "--link", link, "--bench-seed", str(seed)]
    words += ["--bench-out", str(out)] if out is not None else []
    words += ["--junitxml", str(junit)] if junit is not None else []
    words += ["--bench-pdf"] if pdf else []
    words += ["-k", only] if only else []
    words += ["--bench-waivers", str(waivers)] if waivers is not None else []
    words += ["--bench-operator", operator] if operator else []
    words += ["--bench-serial-number", serial_number] if serial_number else []
    words += ["--bench-temperature", str(temperature)] if temperature is not None else []
    words += [word for each in instrument or () for word in ("--bench-instrument", each)]
    words += ["--bench-real-time"] if real_time else []
    words += ["-n", str(jobs)] if jobs > 1 else []
    code, record = run_suite(words, quiet=as_json)
    if record is not None:
        output.document(_document(record))
    return _EXIT.get(code, 3)


def _document(record: SessionRecord) -> dict[str, Any]:
    """Return the JSON document of a session."""
    return {
        "verdict": str(record.verdict),
        "profile": record.profile_name,
        "link": record.link,
        "counts": {str(outcome): count for outcome, count in record.counts.items()},
        "requirements": {name: str(outcome) for name, outcome in record.requirements.items()},
        "tests": {
            each.name: {
                "outcome": str(each.outcome),
                "reason": each.reason,
                "limits": {
                    one.name: {
                        "value": one.value,
                        **({} if one.below is None else {"below": one.below}),
                        "unit": one.unit,
                        **one.held.to_json(),
                        "verdict": one.verdict,
                    }
                    for one in each.judged
                },
            }
            for each in record.tests
        },
    }


def _campaign(
    profile: str, clean: int, jobs: int, chosen: list[str], seed: int, score: Path | None, output: Output
) -> int:
    """Try the suite, and print its score."""

    def tell(trial: Trial, number: int, count: int) -> None:
        what = trial.mutant or f"sound drive, seed {trial.seed}"
        found = trial.found[0][0] if trial.found else "no test failed" if trial.ran else "no test ran"
        output.note(f"{number} of {count}: {what}: {found}")

    campaign = conduct_campaign([profile], clean=clean, jobs=jobs, tell=tell, chosen=chosen, seed=seed)
    found = campaign.score(options.wall_time().isoformat(timespec="seconds"))
    rows = [
        (each.mutant, "found" if each.failed else "missed", each.found[0][0] if each.found else "")
        for each in campaign.mutants
    ]
    output.table("mutants", ("mutant", "outcome", "by"), rows)
    for each in campaign.false_failures:
        output.line(
            f"a sound drive failed, seed {each.seed}: {each.found[0][0] if each.found else ''}", style="red"
        )
    output.line(
        f"{found.caught} of {found.mutants} mutants found, {found.false_failures} of {found.clean_runs} runs "
        f"of a sound drive failed"
    )
    if score is not None:
        write_whole(score, (found.model_dump_json(indent=2) + "\n").encode("utf-8"))
    holds = found.caught >= 0.95 * found.mutants and not found.false_failures
    output.verdict("pass" if holds else "fail")
    output.document(
        {
            "verdict": "pass" if holds else "fail",
            "score": found.model_dump(mode="json"),
            "mutants": {
                each.mutant: {"found": each.failed, "by": [name for name, _ in each.found]}
                for each in campaign.mutants
            },
            "false_failures": {str(each.seed): dict(each.found) for each in campaign.false_failures},
        }
    )
    return 0 if holds else 1
