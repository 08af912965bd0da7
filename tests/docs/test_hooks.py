"""What the site is built by: links to sources, words of the glossary, the check of the result."""

import re
from pathlib import Path

import check_site
import count
import equation_markup
import pytest
import source_pages
import typography

ROOT = Path(__file__).resolve().parents[2]


def test_a_link_out_of_the_documentation_leads_to_a_page_that_shows_the_file():
    text = "[a](../pyproject.toml), [b](../CHANGELOG.md#x), [c](ladder.md), [d](../none.py)"
    page = "docs/environment.md"
    assert source_pages.rewritten(text, page, page) == (
        "[a](source/pyproject.toml.md), [b](changelog.md#x), [c](ladder.md), [d](../none.py)"
    )
    assert list(source_pages.linked_files(text, page)) == ["pyproject.toml"]


def test_links_of_a_page_from_the_root_are_led_into_the_documentation():
    text = "[a](docs/ladder.md#near), [b](README.md), [c](https://example.org/x.py)"
    assert source_pages.rewritten(text, "CONTRIBUTING.md", "docs/contributing.md") == (
        "[a](ladder.md#near), [b](index.md), [c](https://example.org/x.py)"
    )


def test_a_word_is_linked_once_and_never_in_code_or_headings():
    words = {"nest": "nest", "prey area": "prey"}
    page = "<h1>The nest</h1><p><code>nest</code> nests, the prey area; nest</p>"
    assert typography.link_terms(page, words, "g.html") == (
        '<h1>The nest</h1><p><code>nest</code> <a class="term" href="g.html#nest">nests</a>,'
        ' the <a class="term" href="g.html#prey">prey area</a>; nest</p>'
    )


def test_every_heading_of_the_glossary_is_a_word_with_an_anchor():
    text = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
    headings = re.findall(r"^### ", text, re.MULTILINE)
    assert len(set(typography.terms(text).values())) == len(headings) > 20


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("x += drho cos(theta + dtheta / 2)",
         r"x \leftarrow x + \Delta \rho \, \cos (\theta + \frac{\Delta \theta}{2})"),
        ("|a| / |b|", r"\frac{\left| a \right|}{\left| b \right|}"),
        ("P = (sum_j w_j I_j)^-1", r"P = (\sum_{j} \, w_{j} \, I_{j})^{-1}"),
        ("K = (P - C) C'", r"K = (P - C) \, C^{\mathsf T}"),
        ("F = [1 0 u; 0 1 v]", r"F = \begin{matrix} 1 & 0 & u \\ 0 & 1 & v \end{matrix}"),
        ("a - t / (1 - t)", r"a - \frac{t}{1 - t}"),
        ("(a - t, b) / 2", r"\frac{(a - t,\ b)}{2}"),
    ],
)  # fmt: skip
def test_an_equation_is_typeset(text, latex):
    assert equation_markup.to_latex(text) == latex


@pytest.mark.parametrize("text", ["s = P_i+ (P_i-)^-1", "a = (b", "a ~ b", "a /", "[1/s times]"])
def test_text_that_is_no_equation_is_refused(text):
    with pytest.raises(equation_markup.NotationError):
        equation_markup.to_latex(text)


@pytest.fixture
def site(tmp_path):
    """A site of two pages without a fault."""
    (tmp_path / "a.css").write_text("p { color: red; }")
    (tmp_path / "one.html").write_text('<link rel="stylesheet" href="a.css"><h1 id="x">One</h1>')
    (tmp_path / "two.html").write_text(
        '<a href="one.html#x">1</a><a href="https://example.org">far</a>'
    )
    return tmp_path


def test_a_whole_site_has_no_faults(site):
    assert not list(check_site.faults(site))


@pytest.mark.parametrize(
    ("text", "file", "fault"),
    [
        ('<a href="three.html">3</a>', "two.html", "dead link three.html"),
        ('<a href="one.html#y">1</a>', "two.html", "dead anchor one.html#y"),
        ('<script src="https://a.org/x.js"></script>', "two.html", "fetches https://a.org/x.js"),
        ('<link rel="preconnect" href="//fonts.example">', "two.html", "fetches //fonts.example"),
        ('<img src="gone.png">', "two.html", "dead link gone.png"),
        ("@import url(https://example.org/font.css);", "a.css", "fetches from elsewhere"),
    ],
)
def test_a_fault_of_a_site_is_found(site, text, file, fault):
    (site / file).write_text(text)
    assert list(check_site.faults(site)) == [f"{file}: {fault}"]


@pytest.mark.parametrize(
    ("html", "shown"),
    [
        ("<td>166 (162 to 169)</td>", "<td>166 (162~to~169)</td>"),
        ("<p>313 MB, 95 % of 0.1 s at 2 o'clock</p>", "<p>313~MB, 95~% of 0.1~s at 2 o'clock</p>"),
        ("<p>p &lt; 0.0001; from 3 to nine</p>", "<p>p~&lt;~0.0001; from 3 to nine</p>"),
        ("<p>1 to 2<br>3 m</p>", "<p>1~to~2<br>3~m</p>"),
        ("<pre><code>a 3 s --b</code></pre>", "<pre><code>a 3 s --b</code></pre>"),
        (
            "<code>evaluate es1 --seed 3</code>",
            '<code>evaluate es1 <span class="whole">--seed</span> 3</code>',
        ),
        ("<code>learned-both</code>", '<code><span class="whole">learned-both</span></code>'),
    ],
)
def test_numbers_units_and_short_names_are_not_broken(html, shown):
    assert typography.set_lines(html).replace(typography.SPACE, "~") == shown


def test_a_mention_of_a_decision_is_a_link_to_it(tmp_path):
    (tmp_path / "0012-on-the-path.md").touch()
    (tmp_path / "README.md").touch()
    page = '<p>decision 0012, decision 9999, <a href="x">decision 0012</a></p>'
    assert typography.link_decisions(page, tmp_path, "papers/a.html") == (
        '<p><a href="../decisions/0012-on-the-path.html">decision 0012</a>, decision 9999,'
        ' <a href="x">decision 0012</a></p>'
    )
    own = "<p>Decision 0012</p>"
    assert typography.link_decisions(own, tmp_path, "decisions/0012-on-the-path.html") == own


def test_the_counts_of_the_architecture_are_written_by_one_command():
    page = count.PAGE.read_text(encoding="utf-8")
    was, made = count.MARKED.findall(page), count.MARKED.findall(count.counted(page))
    assert len(was) == len(made) == 1
    assert was[0].count("\n|") == made[0].count("\n|")  # the numbers change with every commit
