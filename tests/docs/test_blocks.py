"""Every block of the documentation does what it says: it is run, or parsed where it needs hardware."""

from __future__ import annotations

import ast
import linecache
import re
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from tests.docs import documents, shell
from tests.docs.blocks import NOT_RUN, ROOT, Block, blocks_of, commands_in_text, has_blocks, pages

READ_BY_A_PERSON = frozenset({"", "text", "mermaid", "{include}", "{toctree}", "{automodule}", "{eval-rst}"})
DEMO = (("demo",), ("run", "zhu2011/ripple"), ("run", "zhu2011/ripple", "--json"))
"""What gives the demo's bundle; `analyze` prints the document of a run again."""
COMPILED_ELSEWHERE = frozenset({"c"})  # tests/device/test_porting_page.py


@dataclass
class Reader:
    """Someone who tries a page from its beginning, in a folder of its own.

    `RUN` on a page is a bundle of the demo, and `benchtool demo` itself is not run again for each page.
    """

    demo: Path
    demo_printed: str
    names: dict[str, Any] = field(default_factory=dict)
    printed: str = ""

    def try_block(self, block: Block) -> None:
        """Run or parse one block, in the current folder."""
        assert block.tags <= NOT_RUN, (
            f"{block}: unknown words {sorted(block.tags - NOT_RUN)} behind the fence"
        )
        if block.file:
            Path(block.file).parent.mkdir(parents=True, exist_ok=True)
            Path(block.file).write_text(block.text, encoding="utf-8")
        match block.language:
            case "sh":
                self._try_shell(block)
            case "python":
                self._try_python(block)
            case "toml":
                documents.require_toml(block.text)
                if documents.is_plan(block.text):
                    require_accepted(block.text, block.file or "as_printed.toml")
            case "yaml":
                for text in documents.commands_of_yaml(block.text):
                    _parse(text)
            case "json" if self.printed:
                documents.require_json(block.text, self.printed)
            case "text" if self.printed:
                documents.require_output(block.text, self.printed)
            case other:
                assert other in READ_BY_A_PERSON | COMPILED_ELSEWHERE, f"{block}: no way to try '{other}'"
        if block.language != "sh":
            self.printed = ""

    def _try_shell(self, block: Block) -> None:
        self.printed = ""
        if not block.runs:
            _parse(block.text)
            return
        for command in shell.commands(block.text):
            if command.words[1:] in (*DEMO, *((*words, "--out", command.words[-1]) for words in DEMO)):
                shell.require_parsed(command.words[1:])
                folder = Path(command.words[-1] if "--out" in command.words else "runs/demo")
                shutil.copytree(self.demo, folder)
                again = shell.Command(("benchtool", "analyze", str(folder), "--json"), 0)
                self.printed += shell.run(again) if "--json" in command.words else self.demo_printed
            elif command.is_benchtool:
                self.printed += shell.run(command)
            else:
                shell.require_known(command)

    def _try_python(self, block: Block) -> None:
        tree = ast.parse(block.text, filename=str(block))
        if not block.runs or block.file:
            return
        linecache.cache[str(block)] = (len(block.text), None, block.text.splitlines(True), str(block))
        exec(compile(tree, str(block), "exec"), self.names)


def require_accepted(plan: str, file: str) -> None:
    """Check that `run` takes a plan: its names, units and values by profile, drive and catalogue."""
    Path(file).write_text(plan, encoding="utf-8")
    shell.run(shell.Command(("benchtool", "run", file, "--dry-run"), 0))


def _parse(text: str) -> None:
    for command in shell.commands(text):
        if command.is_benchtool:
            shell.require_parsed(command.words[1:])
        else:
            shell.require_known(command)


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The demo's bundle and what the demo printed; it is run once for all pages."""
    bundle = tmp_path_factory.mktemp("demo") / "RUN"
    printed = shell.run(shell.Command(("benchtool", "demo", "--out", str(bundle)), 0))
    return bundle, printed


def test_a_plan_whose_names_are_wrong_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    plan = (ROOT / "docs" / "generate" / "examples" / "plan_torque.toml").read_text(encoding="utf-8")
    require_accepted(plan, "plan.toml")
    with pytest.raises(AssertionError, match="step_rise_time"):
        require_accepted(plan.replace("\nrise_time", "\nstep_rise_time"), "plan.toml")


def test_commands_that_the_text_names_exist() -> None:
    named = {(page, text) for page in pages() for text in commands_in_text(page)}
    assert len(named) > 20
    for page, text in sorted(named):
        try:
            shell.require_options(tuple(text.split()[1:]))
        except AssertionError as failure:
            failure.add_note(f"in {page.relative_to(ROOT)}")
            raise


@pytest.mark.parametrize(
    "page",
    [page for page in pages() if has_blocks(page)],
    ids=lambda page: page.relative_to(ROOT).as_posix(),
)
def test_the_blocks_of(
    page: Path, demo: tuple[Path, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    reader = Reader(*demo)
    if re.search(r"\bRUN\b", page.read_text(encoding="utf-8")):
        shutil.copytree(reader.demo, "RUN")
    for block in blocks_of(page):
        try:
            reader.try_block(block)
        except Exception as failure:
            failure.add_note(f"in the {block.language} block at {block}")
            raise
