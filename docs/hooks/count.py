"""Count the source, and write the tables into docs/architecture.md: `make counts`."""

import ast
import re
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "architecture.md"
FOLDERS = "swarm_forage_env", "baselines", "training", "tests", "examples", "docs/hooks"
MARKED = re.compile(r"(?<=<!-- counts -->\n).*(?=<!-- end of counts -->)", re.DOTALL)
KERNELS = {"kernel", "inlined", "entry_point"}
"""Decorators of compiled functions."""

Table = list[tuple[str, ...]]


def functions(trees: Sequence[ast.Module]) -> Iterator[tuple[int, ast.FunctionDef]]:
    """Every function but commands, whose arguments are options; after its number of arguments."""
    for tree in trees:
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and not is_command(node):
                every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
                yield sum(each.arg not in ("self", "cls") for each in every), node


def is_command(node: ast.FunctionDef) -> bool:
    """A command of the command line: typer reads its arguments."""
    arguments = ast.unparse(node.args)
    return "Option(" in arguments or "Argument(" in arguments


def of_folder(folder: str) -> tuple[str, ...]:
    """The row of a folder."""
    texts = [path.read_text("utf-8") for path in sorted((ROOT / folder).rglob("*.py"))]
    whole = "".join(texts)
    lengths = [n for n, _ in functions([ast.parse(text) for text in texts])]
    numbers = (
        len(texts),
        whole.count("\n"),
        len(re.findall(r"\bAny\b", whole)),
        whole.count("noqa: ANN401"),
        len(re.findall(r"\b(?:getattr|hasattr)\(", whole)),
        sum(n > 6 for n in lengths),
        sum(n > 8 for n in lengths),
    )
    return f"`{folder}`", *(f"{number:,}" for number in numbers)


def of_interfaces() -> Table:
    """The rows of what a task fills, and of the longest list of arguments of a kernel."""
    package = sorted((ROOT / "swarm_forage_env").rglob("*.py"))
    (task,) = (
        node
        for node in ast.parse((ROOT / "swarm_forage_env/task.py").read_text("utf-8")).body
        if isinstance(node, ast.ClassDef) and node.name == "Task"
    )
    fields = [each for each in task.body if isinstance(each, ast.AnnAssign)]
    compiled = [
        (n, node.name)
        for n, node in functions([ast.parse(path.read_text("utf-8")) for path in package])
        if KERNELS & {ast.unparse(each) for each in node.decorator_list}
    ]
    n, name = max(compiled)
    return [
        ("fields of `Task`", str(len(fields))),
        ("of these, required", str(sum(each.value is None for each in fields))),
        ("compiled functions of the world", str(len(compiled))),
        (f"most arguments of one, `{name}`", str(n)),
    ]


def tables() -> str:
    """All tables in Markdown, with the commit that they were counted at."""
    git = ["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(git, capture_output=True, text=True, check=False).stdout.strip()
    heads = "folder", "files", "lines", "`Any`", "ANN401", "`getattr`", "> 6 arguments", "> 8"
    blocks = [(heads, *map(of_folder, FOLDERS)), (("", "number"), *of_interfaces())]
    parts = [f"By `make counts`, on top of commit {commit or 'unknown'}:"]
    for head, *rows in blocks:
        lines = [head, ["---"] * len(head), *rows]
        parts.append("\n".join(f"| {' | '.join(line)} |" for line in lines))
    return "\n" + "\n\n".join(parts) + "\n\n"


def counted(page: str) -> str:
    """A page with new tables between its markers."""
    return MARKED.sub(lambda _: tables(), page)


if __name__ == "__main__":
    PAGE.write_text(counted(PAGE.read_text("utf-8")), encoding="utf-8")
