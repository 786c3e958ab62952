"""The fenced blocks of the documentation: where each stands, its language and its tags.

The words behind the language of a fence say how a block is tried:

    ```sh hardware       a drive, an adapter or an operating system that the suite has not: parsed, not run
    ```sh interactive    waits for a person, a viewer or Ctrl-C: parsed, not run
    ```toml file=a.toml  written to that file of the page's folder before the next block
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from markdown_it import MarkdownIt

ROOT: Final = Path(__file__).parents[2]
NOT_RUN: Final = frozenset({"hardware", "interactive"})


@dataclass(frozen=True)
class Block:
    """One fenced block; `line` is that of its fence, counted from 1."""

    page: Path
    line: int
    language: str
    tags: frozenset[str]
    file: str
    text: str

    def __str__(self) -> str:
        return f"{self.page.relative_to(ROOT).as_posix()}:{self.line}"

    @property
    def runs(self) -> bool:
        """Whether the suite has what the block needs."""
        return not self.tags & NOT_RUN


def pages() -> list[Path]:
    """README, the pages beside it and all of docs, without what is built."""
    beside = (ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"))
    below = (path for path in (ROOT / "docs").rglob("*.md") if "_build" not in path.parts)
    protocol = (ROOT / "firmware_protocol").glob("*.md")
    return [*beside, *sorted(below), *sorted(protocol)]


def commands_in_text(page: Path) -> list[str]:
    """The commands of benchtool that a page names between single backticks."""
    tokens = MarkdownIt("commonmark").enable("table").parse(page.read_text(encoding="utf-8"))
    spans = (each for token in tokens for each in token.children or () if each.type == "code_inline")
    return [each.content for each in spans if each.content.startswith("benchtool ")]


def has_blocks(page: Path) -> bool:
    """Whether a page may have any, without the parser: every worker of the tests asks that of every page."""
    return "```" in page.read_text(encoding="utf-8")


@cache
def blocks_of(page: Path) -> tuple[Block, ...]:
    """The blocks of a page in their order."""
    found = []
    for token in MarkdownIt("commonmark").parse(page.read_text(encoding="utf-8")):
        if token.type == "fence" and token.map is not None:
            language, *words = token.info.split() or [""]
            file = next((word.removeprefix("file=") for word in words if word.startswith("file=")), "")
            tags = frozenset(word for word in words if not word.startswith("file="))
            found.append(Block(page, token.map[0] + 1, language, tags, file, token.content))
    return tuple(found)
