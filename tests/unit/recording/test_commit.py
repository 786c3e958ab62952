"""The commit of a checkout is read from git's own files."""

from __future__ import annotations

from pathlib import Path

from benchtool.recording.manifest import checkout_commit

COMMIT = "0123456789abcdef0123456789abcdef01234567"


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def test_a_branch_a_packed_branch_and_a_detached_head(tmp_path: Path) -> None:
    git = tmp_path / ".git"
    write(git / "HEAD", f"{COMMIT}\n")
    assert checkout_commit(tmp_path) == COMMIT
    write(git / "HEAD", "ref: refs/heads/main\n")
    assert checkout_commit(tmp_path) is None
    write(git / "packed-refs", f"# pack-refs\n{'9' * 40} refs/heads/other\n{COMMIT} refs/heads/main\n")
    assert checkout_commit(tmp_path) == COMMIT
    write(git / "refs" / "heads" / "main", "f" * 40)
    assert checkout_commit(tmp_path) == "f" * 40


def test_a_worktree(tmp_path: Path) -> None:
    write(tmp_path / "tree" / ".git", f"gitdir: {tmp_path / 'main' / 'worktrees' / 'tree'}\n")
    write(tmp_path / "main" / "worktrees" / "tree" / "HEAD", "ref: refs/heads/side\n")
    write(tmp_path / "main" / "worktrees" / "tree" / "commondir", "../..\n")
    write(tmp_path / "main" / "refs" / "heads" / "side", COMMIT)
    assert checkout_commit(tmp_path / "tree") == COMMIT


def test_what_is_no_checkout_has_none(tmp_path: Path) -> None:
    assert checkout_commit(tmp_path) is None
