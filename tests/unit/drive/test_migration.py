"""Files of earlier dictionaries: renamed, rescaled and dropped by stated rules, and by nothing else."""

from __future__ import annotations

import pytest

from benchtool.drive.parameters.migration import Migration, Migrations, shipped_migrations
from benchtool.errors import ParameterFileError

# An invented past: resistance once in mohm, then called R; a filter that went away.
FIRST = Migration(from_hash=1, to_hash=2, rename={"R_mohm": "R_ohm"}, scale={"R_ohm": 0.001})
SECOND = Migration(from_hash=2, to_hash=3, rename={"R_ohm": "R_s_ohm"}, drop=("filter_Hz",))


def test_a_rule_renames_scales_and_drops() -> None:
    assert FIRST.apply({"R_mohm": 123, "law": "tpc"}) == {"R_ohm": 0.123, "law": "tpc"}
    assert SECOND.apply({"R_ohm": 0.5, "filter_Hz": 9.0, "u_s_V": 1.0}) == {"R_s_ohm": 0.5, "u_s_V": 1.0}


def test_a_rule_for_a_key_that_is_not_there_changes_nothing() -> None:
    assert FIRST.apply({"law": "tpc"}) == {"law": "tpc"}


def test_a_parameter_given_by_both_names_is_refused() -> None:
    with pytest.raises(ParameterFileError, match="'R_mohm' and 'R_ohm' are the same parameter"):
        FIRST.apply({"R_mohm": 123, "R_ohm": 0.2})


def test_a_text_cannot_be_scaled() -> None:
    with pytest.raises(ParameterFileError, match="'R_ohm' is 'low', a number is expected"):
        FIRST.apply({"R_mohm": "low"})


def test_rules_chain_and_the_shortest_chain_is_taken() -> None:
    shortcut = Migration(from_hash=1, to_hash=3)
    back = Migration(from_hash=2, to_hash=1)
    assert Migrations(migration=(back, FIRST, SECOND)).path(1, 3) == (FIRST, SECOND)
    assert Migrations(migration=(FIRST, SECOND, shortcut)).path(1, 3) == (shortcut,)
    assert Migrations(migration=(back, FIRST)).path(1, 3) is None
    assert Migrations().path(7, 7) == ()


def test_the_shipped_rules_can_be_read() -> None:
    assert all(rule.from_hash != rule.to_hash for rule in shipped_migrations().migration)
