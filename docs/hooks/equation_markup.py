"""Equations as docstrings write them, `g = p_i / (p_i + p_j)`, turned into LaTeX.

A docstring shows an equation as plain text, so that it reads in a terminal; the site shows the same
text typeset. Text that is not in this notation raises `NotationError`, and is shown as it is.
"""

import ast
import json
import re
from collections.abc import Sequence

SYMBOLS = {
    **{name: rf"\{name}" for name in ("alpha", "beta", "gamma", "theta", "phi", "psi", "zeta",
       "rho", "mu", "sigma", "pi", "Phi", "sin", "cos", "exp", "ln", "max", "min", "det")},
    **{name: rf"\Delta {what}" for name, what in (("drho", r"\rho"), ("dtheta", r"\theta"),
       ("dU", "U"), ("dd", "d"), ("dx", "x"), ("dy", "y"), ("dt", "t"))},
    "sum": r"\sum",
}  # fmt: skip
"""Names that are not written as they stand."""

APPLIED = {"sin", "cos", "exp", "ln", "max", "min", "det", "sqrt", "atan2", "clip", "diag"}
"""Functions: what follows in brackets is their argument."""
TOKEN = re.compile(
    r'"[^"]*"|\d+(?:\.\d+)?|[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*|\+-|[+<>]=|[-+=/^|()\[\],\']'
)
MATRIX = re.compile(r"\[([^\[\]]*[;&][^\[\]]*)\]")

IN_PYTHON = {
    "(": "group(", "[": "square(", "]": ")", "^": "**", "=": "==", "+=": " in ",
    "'": r"**'\\mathsf T'",
}  # fmt: skip
OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Eq: "=", ast.LtE: r"\le", ast.GtE: r"\ge"}
BRACKETS = {
    "group": ("(", ")"),
    "square": ("[", "]"),
    "bars": (r"\left| ", r" \right|"),
    "_sqrt": (r"\sqrt{", "}"),
}


class NotationError(ValueError):
    """A text is not in the notation of the equations."""


def to_latex(text: str) -> str:
    r"""Write an equation as LaTeX.

    >>> to_latex("g_i = p_i / (p_i + p_j)")
    'g_{i} = \\frac{p_{i}}{p_{i} + p_{j}}'
    >>> to_latex("A = [1 0; 0 -r sin(d)]")
    'A = \\begin{matrix} 1 & 0 \\\\ 0 & -r \\, \\sin (d) \\end{matrix}'
    """

    def set_aside(match: re.Match[str]) -> str:
        rows = [" & ".join(map(to_latex, _entries(row))) for row in match[1].split(";")]
        body = r" \\ ".join(rows)
        return json.dumps(rf"\begin{{matrix}} {body} \end{{matrix}}")

    whole = MATRIX.sub(set_aside, text.strip())
    if whole.startswith("[") or TOKEN.sub("", whole).strip():
        raise NotationError(text)
    try:
        return _latex(ast.parse(_in_python(whole), mode="eval").body)
    except (SyntaxError, KeyError):
        raise NotationError(text) from None


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


def _in_python(text: str) -> str:
    """The same as an expression of Python: products told, names after `_`, brackets as calls."""
    found, before, opened = "", "", [""]
    for token in TOKEN.findall(text):
        closes = token in (")", "]") or token == "|" == opened[-1]
        is_call = token == "(" and before in APPLIED
        is_product = re.match(r'["\w(\[|]', token) and re.match(r'["\w)\]\'}]', before)
        if is_product and not closes and not is_call:
            found += "*"
        if closes:
            opened.pop()
        elif token in ("(", "[", "|"):
            opened.append(token)
        if token == "|":
            found += ")" if closes else "bars("
            before = "}" if closes else "{"
        else:
            word = f"_{token}" if token[0].isalpha() else IN_PYTHON.get(token, token)
            found += token if is_call else word
            before = token
    return found


def _latex(node: ast.expr) -> str:
    """An expression as LaTeX; KeyError for one that the notation lacks."""
    match node:
        case ast.Constant():
            return str(node.value)
        case ast.Name():
            first, *scripts = node.id.removeprefix("_").split("_")
            short = (each if len(each) <= 2 else _symbol(each) for each in scripts)
            return _symbol(first) + "".join(f"_{{{each}}}" for each in short)
        case ast.Call(func=ast.Name(id=name)):
            opening, closing = BRACKETS.get(name, (f"{_symbol(name[1:])} (", ")"))
            return f"{opening}{_listed(node.args)}{closing}"
        case ast.Tuple():
            return _listed(node.elts)
        case ast.UnaryOp(op=ast.USub()):
            return f"-{_latex(node.operand)}"
        case ast.Compare():
            return _compared(node)
        case ast.BinOp():
            return _binary(node)
    raise KeyError(node)


def _compared(node: ast.Compare) -> str:
    found = _latex(node.left)
    for operator, right in zip(node.ops, node.comparators, strict=True):
        is_step = isinstance(operator, ast.In)
        sign = rf"\leftarrow {found} +" if is_step else OPERATORS[type(operator)]
        found += f" {sign} {_latex(right)}"
    return found


def _binary(node: ast.BinOp) -> str:
    left, right = _latex(node.left), _latex(node.right)
    match node.op:
        case ast.Pow():
            return f"{left}^{{{right}}}"
        case ast.Mult():
            is_fraction = isinstance(node.left, ast.BinOp) and isinstance(node.left.op, ast.Div)
            gap = r"\ " if r"\mathrm" in left + right and not is_fraction else r"\,"
            return f"{left} {gap} {right}"
        case ast.Div():
            above, below = (_latex(_bare(each)) for each in (node.left, node.right))
            sign = "-" if above.startswith("-") else ""
            return rf"{sign}\frac{{{above.removeprefix('-')}}}{{{below}}}"
        case ast.Add() if right.startswith("-"):
            return rf"{left} \pm {right.removeprefix('-')}"
    return f"{left} {OPERATORS[type(node.op)]} {right}"


def _listed(nodes: Sequence[ast.expr]) -> str:
    return r",\ ".join(map(_latex, nodes))


def _bare(node: ast.expr) -> ast.expr:
    """What brackets enclose, which a fraction makes needless."""
    is_group = isinstance(node, ast.Call) and ast.unparse(node.func) == "group"
    return node.args[0] if is_group and len(node.args) == 1 else node


def _symbol(name: str) -> str:
    """A name as it is written: a symbol, a letter, a number, or a word in upright letters."""
    if name in SYMBOLS:
        return SYMBOLS[name]
    return name if len(name) == 1 or name[0].isdigit() else rf"\mathrm{{{name}}}"
