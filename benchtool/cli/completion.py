"""`benchtool completion install | show`: tab completion in a shell.

A shell hands the line over in the environment and reads one proposal a line, with a tab before its help: the
protocol that typer has for fish, for all shells. Only the module of the verb on the line is loaded.
"""

from __future__ import annotations

import os
import subprocess
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final

import typer

from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.cli.verbs import PLAIN
from benchtool.errors import EnvironmentFailure, UsageError
from benchtool.recording import write_whole, writing

_ASK: Final = "_BENCHTOOL_COMPLETE=complete_fish _TYPER_COMPLETE_FISH_ACTION=get-args _TYPER_COMPLETE_ARGS"
_BASH: Final = f"""\
# Tab completion of benchtool for bash.
_benchtool_completion() {{
    local line="${{COMP_LINE:0:COMP_POINT}}"
    local word="${{line##*[[:space:]]}}" reply proposals
    local broken="${{word%"${{word##*[:=]}}"}}" # readline completes what is behind its last : or =
    COMPREPLY=()
    proposals="$({PLAIN}=1 {_ASK}="$line" "$1" 2>/dev/null)" || return 0
    while IFS= read -r reply; do
        reply="${{reply%%$'\\t'*}}"
        [[ -n $reply && $reply == "$word"* ]] && COMPREPLY+=("${{reply#"$broken"}}")
    done <<<"$proposals"
    [[ ${{#COMPREPLY[@]}} -eq 1 && ${{COMPREPLY[0]}} == *[=:.,] ]] && compopt -o nospace
    return 0
}}
complete -o default -F _benchtool_completion benchtool
"""
_ZSH: Final = f"""\
# Tab completion of benchtool for zsh.
_benchtool_completion() {{
    local line="${{(j: :)words[1,CURRENT]}}" reply
    local -a proposals
    for reply in "${{(@f)$({PLAIN}=1 {_ASK}="$line" "$words[1]" 2>/dev/null)}}"; do
        [[ -n $reply ]] && proposals+=("${{reply%%$'\\t'*}}")
    done
    if (( $#proposals )); then compadd -S '' -- $proposals; else _files; fi
}}
(( $+functions[compdef] )) || {{ autoload -Uz compinit && compinit; }}
compdef _benchtool_completion benchtool
"""
_FISH: Final = f"""\
# Tab completion of benchtool for fish.
complete --command benchtool --arguments "(env {_ASK}=(commandline -cp) benchtool)"
"""
_POWERSHELL: Final = """\
# Tab completion of benchtool for PowerShell.
Register-ArgumentCompleter -Native -CommandName benchtool -ScriptBlock {
    param($word, $line, $position)
    $text = $line.ToString()
    if ($position -gt $text.Length) { $text += ' ' }
    $Env:_BENCHTOOL_COMPLETE = 'complete_fish'
    $Env:_TYPER_COMPLETE_FISH_ACTION = 'get-args'
    $Env:_TYPER_COMPLETE_ARGS = $text
    try {
        benchtool 2>$null | Where-Object { $_ } | ForEach-Object {
            $value, $help = $_ -split "`t", 2
            [System.Management.Automation.CompletionResult]::new(
                $value, $value, 'ParameterValue', $(if ($help) { $help } else { $value }))
        }
    } finally {
        $Env:_BENCHTOOL_COMPLETE = $Env:_TYPER_COMPLETE_FISH_ACTION = $Env:_TYPER_COMPLETE_ARGS = $null
    }
}
"""


class Shell(StrEnum):
    """The shells that are served."""

    BASH = "bash"
    ZSH = "zsh"
    FISH = "fish"
    POWERSHELL = "powershell"
    PWSH = "pwsh"


SCRIPTS: Final = {
    Shell.BASH: _BASH,
    Shell.ZSH: _ZSH,
    Shell.FISH: _FISH,
    Shell.POWERSHELL: _POWERSHELL,
    Shell.PWSH: _POWERSHELL,
}

Named = Annotated[
    Shell | None,
    typer.Argument(metavar="[SHELL]", help="bash, zsh, fish, powershell or pwsh."),
]


def install(shell: Named = None, as_json: options.Json = False) -> int:
    """Install tab completion for this user: a script, and a line in the startup file that reads it."""
    output = Output(as_json=as_json)
    chosen = shell or _own_shell()
    script, startup = _script_path(chosen), _startup_path(chosen)
    _write(script, SCRIPTS[chosen])
    if startup is not None:
        line = f"{'.' if chosen in (Shell.POWERSHELL, Shell.PWSH) else 'source'} '{script}'"
        _add_line(startup, line)
    output.line(f"completion for {chosen} is in {script}{f', read by {startup}' if startup else ''}")
    output.note("it works in the next shell that is opened")
    output.document(
        {"shell": str(chosen), "script": str(script), "startup": None if startup is None else str(startup)}
    )
    return 0


def show(shell: Named = None) -> int:
    """Print the script of a shell, to be installed by hand."""
    sys.stdout.write(SCRIPTS[shell or _own_shell()])
    return 0


def _own_shell() -> Shell:
    """Return the user's shell, as the environment tells it.

    Raises:
        UsageError: it tells none that is served.
    """
    name = Path(os.environ.get("SHELL", "")).name or ("powershell" if sys.platform == "win32" else "")
    if name in list(Shell):
        return Shell(name)
    seen = f"SHELL names '{name}'" if name else "SHELL names no shell"
    raise UsageError(f"{seen}: name one of {', '.join(Shell)}, as in 'benchtool completion install bash'")


def _script_path(shell: Shell) -> Path:
    if shell is Shell.FISH:
        return _folder("XDG_CONFIG_HOME", ".config") / "fish" / "completions" / "benchtool.fish"
    ending = "ps1" if shell in (Shell.POWERSHELL, Shell.PWSH) else str(shell)
    return _folder("XDG_DATA_HOME", ".local/share") / "benchtool" / f"completion.{ending}"


def _startup_path(shell: Shell) -> Path | None:
    """Return the file that the shell reads when it starts; None where it finds the script itself."""
    match shell:
        case Shell.BASH:
            return Path.home() / ".bashrc"
        case Shell.ZSH:
            return Path(os.environ.get("ZDOTDIR") or Path.home()) / ".zshrc"
        case Shell.FISH:
            return None
    try:
        told = subprocess.run(
            [shell, "-NoProfile", "-NonInteractive", "-Command", "$PROFILE"],
            capture_output=True,
            text=True,
            check=True,
        )
    except (OSError, subprocess.CalledProcessError) as reason:
        raise EnvironmentFailure(
            f"{shell} does not tell where its profile is: {reason}; add the script to it by hand, "
            f"'benchtool completion show {shell}' prints it"
        ) from None
    return Path(told.stdout.strip())


def _folder(variable: str, default: str) -> Path:
    return Path(os.environ.get(variable) or Path.home() / default)


def _add_line(startup: Path, line: str) -> None:
    """Have a startup file contain a line; it is added once."""
    content = startup.read_text(encoding="utf-8") if startup.is_file() else ""
    if line in content.splitlines():
        return
    ended = "" if not content or content.endswith("\n") else "\n"
    _write(startup, f"{content}{ended}{line}\n")


def _write(file: Path, text: str) -> None:
    with writing(file):
        file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, text.encode("utf-8"))
