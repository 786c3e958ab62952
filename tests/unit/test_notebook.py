"""Tables for notebooks."""

from __future__ import annotations

from xml.etree import ElementTree

from hypothesis import given, strategies as st

from benchtool.notebook import table_html

texts = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=20)


@given(texts, st.lists(st.tuples(texts, texts), max_size=4), texts)
def test_whatever_is_in_it_is_text(title: str, rows: list[tuple[str, str]], footer: str) -> None:
    page = ElementTree.fromstring(f"<div>{table_html((title, '>b'), rows, title, footer)}</div>")
    cells = [cell.text or "" for cell in page.iter("td")]
    assert cells == [cell for row in rows for cell in row]
    assert [cell.get("style", "") for cell in page.iter("th")][1].count("right") == 1
