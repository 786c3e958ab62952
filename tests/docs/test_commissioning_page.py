"""The page of a campaign of commissionings."""

from __future__ import annotations

import json
from pathlib import Path

from docs.generate.commissioning import main

CAMPAIGN = {
    "series": "flaws",
    "seed": 1234567,
    "runs": 3,
    "R_s": "told 3, within tolerance 100 %, largest 0.42 of it",
    "z_rms": 0.91,
    "motors": {"one": {"R_s": 0.42, "J": None}, "two": {"R_s": 0.1}},
    "machine": "x86_64",
}


def test_a_campaign_becomes_tables(tmp_path: Path) -> None:
    campaign, page = tmp_path / "campaign.json", tmp_path / "page.md"
    campaign.write_text(json.dumps(CAMPAIGN), encoding="utf-8")
    assert main([str(campaign), "--page", str(page)]) == 0
    lines = page.read_text(encoding="utf-8").splitlines()
    assert "| R_s | told 3, within tolerance 100 %, largest 0.42 of it |" in lines
    assert "| motors commissioned | 3 |" in lines
    assert "| series of draws | flaws |" in lines
    assert "| seed of the draws | 1234567 |" in lines
    assert "| one | 0.42 | – |" in lines
    assert "| two | 0.10 | – |" in lines
