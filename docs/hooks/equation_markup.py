"""Equations as docstrings write them, `g = p_i / (p_i + p_j)`, turned into LaTeX.

A docstring shows an equation as plain text, so that it reads in a terminal; the site shows the same
text typeset. Text that is not in this notation raises `NotationError`, and is shown as it is.
"""

import re

SYMBOLS = {
    **{name: rf"\{name}" for name in ("alpha", "beta", "gamma", "theta", "phi", "psi", "zeta",
       "rho", "mu", "sigma", "pi", "Phi", "sin", "cos", "exp", "ln", "max", "min", "det")},
    **{name: rf"\Delta {what}" for name, what in (("drho", r"\rho"), ("dtheta", r"\theta"),
       ("dU", "U"), ("dd", "d"), ("dx", "x"), ("dy", "y"), ("dt", "t"))},
    "sum": r"\sum", "+-": r"\pm", "<=": r"\le", ">=": r"\ge",
}  # fmt: skip
"""Names and operators that are not written as they stand."""

APPLIED = {"sin", "cos", "exp", "ln", "max", "min", "det", "sqrt", "atan2", "clip", "diag"}
"""Functions: what follows in brackets is their argument."""

RELATIONS = {"=", "+", "-", "+-", "<=", ">=", "+="}
TOKEN = re.compile(
    r"\s*(?P<token>\d+(?:\.\d+)?|[A-Za-z][A-Za-z0-9]*|\+-|\+=|<=|>=|[-+=/^_|()\[\],']|@\d+@)\s*"
)
MATRIX = re.compile(r"\[([^\[\]]*[;&][^\[\]]*)\]")


class NotationError(ValueError):
    """A text is not in the notation of the equations."""


def to_latex(text: str) -> str:
    r"""Write an equation as LaTeX.

    >>> to_latex("g_i = p_i / (p_i + p_j)")
    'g_{i} = \\frac{p_{i}}{p_{i} + p_{j}}'
    >>> to_latex("A = [1 0; 0 -r sin(d)]")
    'A = \\begin{matrix} 1 & 0 \\\\ 0 & -r \\, \\sin (d) \\end{matrix}'
    """
    matrices: list[str] = []

    def set_aside(match: re.Match[str]) -> str:
        rows = [" & ".join(map(to_latex, _entries(row))) for row in match[1].split(";")]
        body = r" \\ ".join(rows)
        matrices.append(rf"\begin{{matrix}} {body} \end{{matrix}}")
        return f"@{len(matrices) - 1}@"

    return _Parser(MATRIX.sub(set_aside, text.strip()), matrices).whole()


def equations(block: str) -> list[str]:
    r"""The equations of a block of lines; a matrix or a fraction may run over several.

    >>> equations("x = a\n    / b\ny = c,  z = [1  0\n                      0  1]")
    ['x = a / b', 'y = c', 'z = [1 & 0; 0 & 1]']
    """
    found: list[str] = []
    for line in map(str.strip, block.splitlines()):
        if found and found[-1].count("[") > found[-1].count("]"):
            found[-1] += "; " + _columns(line)
        elif found and line.startswith("/"):
            found[-1] += f" {line}"
        else:
            *whole, last = re.split(r",\s\s+|\s{3,}(?=\[)", line)
            if last.count("[") > last.count("]"):
                head, _, row = last.partition("[")
                last = f"{head}[{_columns(row)}"
            found += [*whole, last]
    return found


def _columns(row: str) -> str:
    """A row of a matrix whose columns stand apart by two spaces or more."""
    return re.sub(r"\s{2,}(?!\])", " & ", row.strip())


def _entries(row: str) -> list[str]:
    """The entries of a row, told apart by `&` or by single spaces."""
    if "&" in row:
        return [each.strip() for each in row.split("&") if each.strip()]
    found: list[str] = []
    for word in row.split():
        is_applied = word.partition("(")[0] in APPLIED
        if is_applied and found and re.fullmatch(r"-?[a-z]+", found[-1]):
            found[-1] += f" {word}"
        else:
            found.append(word)
    return found


class _Parser:
    """Recursive descent over the tokens of one equation."""

    def __init__(self, text: str, matrices: list[str]) -> None:
        """Take apart a text, in which `@0@` stands for the first matrix."""
        self._text, self._matrices = text, matrices
        self._tokens: list[str] = []
        if text.startswith("["):
            raise NotationError(text)
        position = 0
        while position < len(text):
            match = TOKEN.match(text, position)
            if match is None:
                raise NotationError(text)
            self._tokens.append(match["token"])
            position = match.end()
        self._at, self._is_in_bars = 0, False

    def whole(self) -> str:
        """The LaTeX of all tokens."""
        found = self._list()
        if self._at < len(self._tokens):
            raise NotationError(self._text)
        return found

    @property
    def _next(self) -> str:
        return self._tokens[self._at] if self._at < len(self._tokens) else ""

    def _take(self, wanted: str = "") -> str:
        token = self._next
        if not token or (wanted and token != wanted):
            raise NotationError(self._text)
        self._at += 1
        return token

    def _list(self) -> str:
        found = [self._sum()]
        while self._next == ",":
            self._take()
            found.append(self._sum())
        return r",\ ".join(found)

    def _sum(self) -> str:
        found = self._take() if self._next == "-" else ""
        found += self._fraction()
        while self._next in RELATIONS:
            operator = self._take()
            if operator == "+=":
                found, operator = rf"{found} \leftarrow {found}", "+"
            found += f" {SYMBOLS.get(operator, operator)} "
            found += self._take() if self._next == "-" else ""
            found += self._fraction()
        return found

    def _fraction(self) -> str:
        above = self._product()
        while self._next == "/":
            self._take()
            above = rf"\frac{{{_bare(above)}}}{{{_bare(self._factor())}}}"
            if self._starts_factor():
                above += rf" \, {self._product()}"
        return above

    def _product(self) -> str:
        found = self._factor()
        while self._starts_factor():
            factor = self._factor()
            gap = r"\ " if r"\mathrm" in found + factor else r"\,"
            found += f" {gap} {factor}"
        return found

    def _starts_factor(self) -> bool:
        token = self._next
        opens = token in {"(", "["} or (token == "|" and not self._is_in_bars)
        return opens or bool(re.match(r"[A-Za-z0-9@]", token))

    def _factor(self) -> str:
        found = self._atom()
        while self._next in {"_", "^", "'"}:
            mark = self._take()
            if mark == "'":
                found += r"^{\mathsf T}"
            else:
                sign = self._take() if self._next == "-" else ""
                found += f"{mark}{{{sign}{_script(self._take())}}}"
        return found

    def _atom(self) -> str:
        token = self._take()
        if token == "(":
            return self._enclosed("(", ")")
        if token == "[":
            return self._enclosed("[", "]")
        if token == "|":
            self._is_in_bars = True
            inner = self._list()
            self._is_in_bars = False
            self._take("|")
            return rf"\left| {inner} \right|"
        if token.startswith("@"):
            return self._matrices[int(token.strip("@"))]
        if token == "sqrt":
            self._take("(")
            return rf"\sqrt{{{_bare(self._enclosed('(', ')'))}}}"
        if not re.match(r"[A-Za-z0-9]", token):
            raise NotationError(self._text)
        if token in APPLIED and self._next == "(":
            self._take()
            return f"{_symbol(token)} {self._enclosed('(', ')')}"
        return _symbol(token)

    def _enclosed(self, opening: str, closing: str) -> str:
        in_bars, self._is_in_bars = self._is_in_bars, False
        inner = self._list()
        self._is_in_bars = in_bars
        self._take(closing)
        return f"{opening}{inner}{closing}"


def _symbol(name: str) -> str:
    """A name as it is written: a symbol, a letter, a number, or a word in upright letters."""
    if name in SYMBOLS:
        return SYMBOLS[name]
    return name if len(name) == 1 or name[0].isdigit() else rf"\mathrm{{{name}}}"


def _script(name: str) -> str:
    """An index or exponent: indices of robots stand as letters, words upright."""
    return name if len(name) <= 2 else _symbol(name)


def _bare(text: str) -> str:
    """A text without the brackets that enclose all of it, which a fraction makes needless."""
    if not (text.startswith("(") and text.endswith(")")) or r",\ " in text:
        return text
    depth = 0
    for k, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if depth == 0 and k < len(text) - 1:
            return text
    return text[1:-1]
