"""The page and the PDF: all content there and harmless, nothing from outside, the same bytes each time."""

from __future__ import annotations

import itertools
import math
import re
from html.parser import HTMLParser

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from reportlab import rl_config
from reportlab.pdfbase.ttfonts import TTFont

from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.analysis.numbers import stated
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined
from benchtool.plan import JudgedLimit, Limit
from benchtool.report.content import (
    Cell,
    Facts,
    Grid,
    Item,
    Picture,
    Report,
    Section,
    Text,
    Verdict,
    anchor,
    contents,
    describe_figure,
)
from benchtool.report.figures.style import BLUE, dress, new_figure
from benchtool.report.html import html_page
from benchtool.report.images import MOST_SVG_BYTES, data_uri
from benchtool.report.pdf.document import pdf_document
from benchtool.report.results import (
    basis_text,
    budgets_section,
    limits_section,
    measurements_section,
    tables_section,
)

HOSTILE = '<script>alert("x")</script> & "quoted" \'title\''
VOID = {"meta", "img", "link", "br"}


class Reader(HTMLParser):
    """Reads a page: elements, ids, texts; fails where elements are not closed in order."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text += data

    def attributes(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.seen if name == tag]


def figure(title: str, samples: int = 50) -> Figure:
    drawn = new_figure(2.0, title, "")
    axes = drawn.subplots()
    axes.plot(np.random.default_rng(0).random(samples), color=BLUE)
    dress(axes, "time (s)", "torque (Nm)")
    return drawn


def report(title: str = "A test", samples: int = 50) -> Report:
    shown = figure(title, samples)
    rows = [(str(number), str(number**2)) for number in range(25)]
    items: tuple[Item, ...] = (
        Verdict("fail", "✗ Fail", title),
        Facts((("profile", title),)),
        Section("First", (Text(title, "warning"), Text("benchtool analyze RUN", "code")), listed=True),
        Section(
            "Second",
            (
                Grid.of(("order", ">amplitude (A)"), rows, title, shown=10),
                Grid.of(("name", "verdict"), [(Cell(title, notes=(title,)), Cell("marginal", "marginal"))]),
                Picture(shown, title, describe_figure(shown)),
            ),
            listed=True,
        ),
    )
    return Report(title, "µ Ω ψ ± ≤", "2026-11-21T12:00:00+01:00", items)


def test_the_page_needs_nothing_from_outside_and_runs_nothing() -> None:
    page = html_page(report(HOSTILE))
    reader = Reader(page)
    assert not {"script", "link", "iframe", "object", "embed"} & {tag for tag, _ in reader.seen}
    for _, attributes in reader.seen:
        assert not any(name.startswith("on") for name in attributes)
        for name in ("src", "href"):
            assert (attributes.get(name) or "#").startswith(("#", "data:image/"))
    assert "url(" not in page
    assert "@import" not in page
    assert reader.text.count(HOSTILE) == 9  # shown as text, wherever it stands


def test_the_page_is_accessible() -> None:
    reader = Reader(html_page(report()))
    assert reader.attributes("html") == [{"lang": "en"}]
    assert all(each["alt"] == "A test. torque (Nm) against time (s)." for each in reader.attributes("img"))
    assert all(each.get("scope") in ("row", "col") for each in reader.attributes("th"))
    levels = [int(tag[1]) for tag, _ in reader.seen if re.fullmatch(r"h[1-6]", tag)]
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in itertools.pairwise(levels))
    ids = [attributes["id"] for _, attributes in reader.seen if "id" in attributes]
    assert len(ids) == len(set(ids))
    assert {each["href"] for each in reader.attributes("a")} == {f"#{each}" for each in ids}
    assert "✗ Fail" in reader.text
    assert "▲\N{NO-BREAK SPACE}marginal" in reader.text  # in words and as a symbol, not by colour alone


def test_long_tables_fold_away_with_their_headings_and_lose_no_row() -> None:
    reader = Reader(html_page(report()))
    tables = [tag for tag, _ in reader.seen if tag == "table"]
    assert len(tables) == 4  # facts, the table in two parts, the short table
    assert "the other 15 rows of 25" in reader.text
    for number in range(25):
        assert f"{number}{number**2}" in reader.text.replace("\n", "")


def test_the_same_report_gives_the_same_bytes() -> None:
    assert html_page(report()) == html_page(report())
    assert pdf_document(report()) == pdf_document(report())
    assert pdf_document(report()) != pdf_document(report("Another"))


def test_a_dense_figure_is_an_image_of_dots_and_others_are_drawn() -> None:
    assert data_uri(figure("thin")).startswith("data:image/svg+xml;base64,")
    dense = figure("dense", 200_000)
    with mpl.rc_context({"path.simplify": False}):
        dense.axes[0].lines[0].get_path().should_simplify = False
        address = data_uri(dense)
    assert address.startswith("data:image/png;base64,")
    assert len(data_uri(figure("thin"))) < 2 * MOST_SVG_BYTES


def test_the_pdf_has_its_fonts_its_pages_their_numbers_and_the_run_s_date() -> None:
    document = pdf_document(report(HOSTILE))
    assert document.startswith(b"%PDF-")
    assert document.count(b"/FontFile2") >= 2
    assert b"20261121120000+01'00'" in document
    assert b"/Outlines" in document
    assert b"(First)" in document
    assert _pages(document) == 2  # the second listed section begins a page


def test_what_the_pdf_has_compressed_is_written_as_it_is() -> None:
    """As text it would be a quarter larger; what others write with the same library stays as they have it."""
    before = rl_config.useA85
    document = pdf_document(report())
    assert b"FlateDecode" in document
    assert b"ASCII85Decode" not in document
    assert rl_config.useA85 == before


@pytest.mark.parametrize(("short", "pages"), [(False, 3), (True, 1)])
def test_short_sections_follow_on_the_page(short: bool, pages: int) -> None:
    sections = tuple(Section(name, (Text("a line"),), listed=True, short=short) for name in "ABC")
    assert _pages(pdf_document(Report("title", "subtitle", "2026-11-21T12:00:00+01:00", sections))) == pages


def _pages(document: bytes) -> int:
    return document.count(b"/Type /Page\n")


@pytest.mark.parametrize("name", ["DejaVuSans", "DejaVuSans-Bold"])
def test_the_pdf_s_fonts_have_every_letter_that_reports_use(name: str) -> None:
    font = TTFont(name, f"{mpl.get_data_path()}/fonts/ttf/{name}.ttf")
    wanted = "µΩψωαβθ±≤≥×−–…·✓✗▲⁻⁰¹²³⁴⁵⁶⁷⁸⁹°√\N{NO-BREAK SPACE}"
    assert [each for each in wanted if ord(each) not in font.face.charToGlyph] == []


def test_anchors_are_those_of_the_listed_sections() -> None:
    items = (Section("Case A/é <b>", (Section("Inner", (), listed=True),), listed=True), Section("Not", ()))
    assert contents(items) == (("Case A/é <b>", "s-case-a-e-b"), ("Inner", "s-inner"))
    assert anchor("law=1.5") == "s-law=1.5"


BASIS = Basis(5200, 1e4, 0.52, 5000.0, "rectangular over 5 periods", 50, "the fundamental", 0)


def test_a_basis_in_words() -> None:
    assert basis_text(BASIS) == (
        "Basis: 5200 samples at 10000 Hz over 0.52 s; components up to 5000 Hz; window: rectangular over 5 "
        "periods; harmonics up to 50; relative to the fundamental; no gaps."
    )
    assert basis_text(Basis(duration_s=2.0, gaps=3)) == "Basis: 2 s; 3 gaps."
    assert basis_text(Basis()) == ""


def test_measurements_come_with_uncertainty_definition_basis_and_published_figure() -> None:
    measured = Measurement(
        "current_thd_f", 1.838, "%", "harmonics over it", BASIS, Uncertainty(0.0123, "noise floor")
    )
    other = Measurement.undefined("plain", "A", "a mean", "no channel")
    bounds = JudgedLimit.of("current_thd_f", Limit(max=2.0, margin=0.5), measured)
    section = measurements_section("M", [measured, other], {"current_thd_f": bounds}, {"current_thd_f": 1.5})
    (grid,) = section.items
    assert isinstance(grid, Grid)
    headings = [column.heading for column in grid.columns]
    assert headings == [
        "measurement",
        "value ± U (95 %)",
        "unit",
        "published",
        "limit",
        "verdict",
    ]
    name, *cells = grid.rows[0]
    assert [cell.text for cell in cells] == ["1.838 ± 0.024", "%", "1.5", "≤\N{NO-BREAK SPACE}2", "marginal"]
    assert cells[-1].mark == "marginal"
    assert name.notes[0] == "Harmonics over it."
    assert name.notes[1] == basis_text(BASIS)
    assert name.notes[2] == "U = 0.024 % covers 95 %, k = 1.96, u = 0.012 %: noise floor."
    assert [cell.text for cell in grid.rows[1][1:]] == ["–", "A", "", "", ""]
    assert "Undefined here: no channel." in grid.rows[1][0].notes


def test_the_appendix_has_k_degrees_of_freedom_and_the_budget_of_each_uncertainty() -> None:
    scatter = Contribution("scatter", "A", 0.3 * math.sqrt(2.0), 4.0, of_student=True)
    lines = scatter, Contribution("gain of torque", "B", 0.4)
    known = Measurement("torque_mean", 1.0, "Nm", "a mean", uncertainty=combined(lines, "scatter and gain"))
    section = budgets_section([known, Measurement("plain", 1.0, "A", "a mean")])
    assert section is not None
    grid, *notes = section.items
    assert isinstance(grid, Grid)
    # s = 0.5 with 4 (0.5 / 0.3)^4 = 30.9 degrees of freedom, of which Student's t is 2.04: U = t s
    # u = 0.58, as of four degrees of freedom Student's distribution is sqrt(4 / 2) as wide as 0.3
    whole = ["0.50", "0.58", "Nm", "30.9", "2.04", "1.75"]
    assert [[cell.text for cell in row] for row in grid.rows] == [
        ["torque_mean", "combined", "scatter and gain", *whole],
        ["", "type A", "scatter", "0.30", "0.42", "Nm", "4", "", ""],
        ["", "type B", "gain of torque", "0.40", "0.40", "Nm", "\N{INFINITY}", "", ""],
    ]
    headings = [column.heading for column in grid.columns]
    assert headings[3:] == ["s", "u", "unit", "degrees of freedom", "t", "k"]
    assert any(isinstance(note, Text) and note.text.startswith("U = t s") for note in notes)
    assert budgets_section([Measurement("plain", 1.0, "A", "a mean")]) is None


@pytest.mark.parametrize(
    ("limit", "value", "left"),
    [
        (Limit(max=0.06), 0.05, "0.01 (17 %)"),
        (Limit(min=1.0, max=4.0), 1.5, "0.5 (50 %)"),
        (Limit(max=2.0), 2.5, "−0.5 (−25 %)"),
        (Limit(max=0.0), 0.0, "0"),
        (Limit(min=1.0), 2.0, "1 (100 %)"),
        (Limit(max=1e-6), 0.65, "−0.65"),
        (Limit(max=9500.0), 30900.0, "−21400 (−230 %)"),
    ],
)
def test_the_margin_left_is_to_the_nearer_bound(limit: Limit, value: float, left: str) -> None:
    grid, *_ = limits_section([JudgedLimit.of("x", limit, Measurement("x", value, "Nm", ""))]).items
    assert isinstance(grid, Grid)
    assert grid.rows[0][5].text == left


def test_a_limit_on_what_was_not_measured_says_so() -> None:
    grid, *_ = limits_section([JudgedLimit.of("x", Limit(max=1.0), None)]).items
    assert isinstance(grid, Grid)
    assert [cell.text for cell in grid.rows[0]] == [
        "x",
        "not measured",
        "",
        "≤\N{NO-BREAK SPACE}1",
        "simple acceptance",
        "–",
        "–",
        "fail",
    ]


def test_a_limit_without_a_probability_of_conformance_says_why() -> None:
    held = JudgedLimit.of("x", Limit(max=1.0), Measurement("x", 0.5, "Nm", ""))
    *_, note = limits_section([held]).items
    assert isinstance(note, Text)
    assert note.text == "No P of x: its uncertainty is not known."


def test_any_table_is_shown() -> None:
    table = Table(
        "orders", "amplitude by order", (("order", ""), ("amplitude", "A")), ((1.0, 0.5), (2.0, float("nan")))
    )
    section = tables_section([table])
    assert section is not None
    (inner,) = section.items
    assert isinstance(inner, Section)
    definition, grid = inner.items
    assert definition == Text("Amplitude by order.", "note")
    assert isinstance(grid, Grid)
    assert [column.heading for column in grid.columns] == ["order", "amplitude (A)"]
    assert [[cell.text for cell in row] for row in grid.rows] == [["1", "0.5000"], ["2", "–"]]
    assert tables_section([]) is None
    assert stated(0.5, None) == "0.5000"
