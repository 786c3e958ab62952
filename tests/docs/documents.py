"""TOML, JSON and YAML blocks held against the models that read them, and printed output against its page."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any, Final

import yaml
from pydantic import TypeAdapter, ValidationError

from benchtool.plan.model import Plan
from benchtool.profile import Profile

ELSEWHERE: Final = frozenset({"project", "benchtool", "dependency-groups", "waiver"})
"""Tables of other documents than plans and profiles: pyproject.toml, parameter files, waivers."""

_NUMBER: Final = re.compile(r"(?<![A-Za-z_])[-+−]?\d[\d.,:eE+−-]*(?:\s*×\s*10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?|(?<=\s)–(?=\s)")
_RULES: Final = re.compile(r"[━┃│╇┼─]+")


def require_toml(text: str) -> None:
    """Check a block as a plan, a profile, or tables of one of them.

    Raises:
        ValidationError: a key or a value does not fit the model.
        ValueError: it is not TOML.
    """
    content = tomllib.loads(text)
    if is_plan(text):
        Plan.model_validate(content)
    elif {"motor", "drive"} <= content.keys():
        Profile.model_validate(content)
    else:
        for key, value in content.items():
            if key not in ELSEWHERE:
                _require_table(key, value)


def is_plan(text: str) -> bool:
    """Return whether a block is a whole plan."""
    return {"operating_point", "record", "profile"} <= tomllib.loads(text).keys()


def _require_table(key: str, value: Any) -> None:
    """Check one key of a plan or a profile; a table may be shown in part."""
    annotations = [
        model.model_fields[key].annotation for model in (Profile, Plan) if key in model.model_fields
    ]
    assert annotations, f"neither plan nor profile has a key '{key}'"
    if key in ("limits", "case_limits"):  # their keys may end in a unit, which the plan takes off
        point = {"omega_m_rad_s": 1.0}
        record = {"duration_s": 1.0, "channels": ["torque"]}
        whole = {"title": "", "profile": "", "operating_point": point, "record": record, key: value}
        Plan.model_validate(whole)
        return
    refusals = [_refusal(annotation, value) for annotation in annotations]
    if all(refusals) and refusals[0] is not None:
        raise refusals[0]


def _refusal(annotation: Any, value: Any) -> ValidationError | None:
    """What a type has against a value that may be shown in part."""
    try:
        TypeAdapter(annotation).validate_python(value)
    except ValidationError as failed:
        if any(each["type"] != "missing" for each in failed.errors()):
            return failed
    return None


def commands_of_yaml(text: str) -> Iterator[str]:
    """The shell text of a CI definition: what stands under `run`, `script` and `before_script`."""
    yield from _scripts(yaml.safe_load(text))


def _scripts(node: Any) -> Iterator[str]:
    if isinstance(node, Mapping):
        for key, value in node.items():
            if key in ("run", "script", "before_script"):
                yield from [value] if isinstance(value, str) else value
            else:
                yield from _scripts(value)
    elif isinstance(node, list):
        for each in node:
            yield from _scripts(each)


def require_output(shown: str, printed: str) -> None:
    """Check that the lines of a page were printed in their order, with any numbers; `...` is any lines."""
    lines = iter(_masked(line) for line in printed.splitlines())
    seen: list[str] = []
    for line in shown.splitlines():
        wanted = _masked(line)
        if not wanted or wanted == "...":
            continue
        for each in lines:
            seen.append(each)
            if each == wanted:
                break
        else:
            raise AssertionError(f"not printed: {line!r}, which masked is {wanted!r}, among\n{printed}")


def require_json(shown: str, printed: str) -> None:
    """Check that a JSON document has the keys of the page, with values of the same type."""
    start = printed.index("{")
    _require_part(json.loads(shown), json.JSONDecoder().raw_decode(printed[start:])[0], "")


def _require_part(shown: Any, printed: Any, place: str) -> None:
    if isinstance(shown, dict):
        assert isinstance(printed, dict), place
        for key, value in shown.items():
            assert key in printed, f"no {place}.{key}: {', '.join(printed)}"
            _require_part(value, printed[key], f"{place}.{key}")
    elif isinstance(shown, list) and shown:
        assert isinstance(printed, list), place
        assert printed, place
        _require_part(shown[0], printed[0], f"{place}[0]")
    elif isinstance(shown, int | float) and not isinstance(shown, bool):
        assert isinstance(printed, int | float), place
    else:
        assert isinstance(printed, type(shown)), place


def _masked(line: str) -> str:
    """A line without what differs from run to run: numbers, rules of tables and the width of columns."""
    return " ".join(_NUMBER.sub("#", _RULES.sub(" ", line)).split())
