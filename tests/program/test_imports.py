"""The rooms of the tree and what each may import. Reads every import, also those in functions and for types only."""

from __future__ import annotations

import ast
import re
import sys
import tokenize
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "samp_blender"

# Which room may import which others; docs/architecture.md repeats this table. Every room may import itself and
# "program", the modules directly in samp_addon/ (motion, skeleton, frames, ...), which import no room.
ARROWS = {
    "operators": {"ui", "batch", "blender", "pipeline"},
    "ui": {"batch", "blender", "pipeline", "methods"},
    "batch": {"blender", "pipeline", "methods", "refine", "body"},
    "blender": {"pipeline", "methods", "edits", "rigs", "refine", "evaluation", "scene", "body"},
    "pipeline": {"methods", "edits", "refine", "evaluation", "scene", "body"},
    "methods": {"refine", "scene", "body", "models"},
    "edits": {"refine", "scene", "body"},
    "rigs": {"refine", "scene", "body"},
    "refine": {"evaluation", "scene", "body"},
    "evaluation": {"scene", "body"},
    "scene": {"body"},
    "training": {
        "batch", "blender", "pipeline", "methods", "rigs", "refine", "evaluation", "scene", "body", "models",
    },
    "body": set(),
    "models": set(),
    "program": set(),
}  # fmt: skip
TOOLS = ("release", "demo", "benchmarks")  # programs that may import every room; no room imports them

BLENDER = {"bpy", "bmesh", "mathutils", "gpu", "gpu_extras", "bl_ui", "bl_math", "bpy_extras", "addon_utils"}
MAY_IMPORT_BLENDER = {"blender", "ui", "operators", "training", *TOOLS}
# Rooms that are loaded at registration or by the batch before its arguments are checked.
NO_TORCH_AT_IMPORT = {"program", "operators", "ui", "blender", "batch", "pipeline"}
MODELS_MAY_IMPORT = {"torch", "numpy", "safetensors"}


@dataclass(frozen=True)
class Import:
    """One import. source, target: modules of this tree with dots, or the target's name outside of it.

    top: whether it runs when the source is imported.
    """

    source: str
    target: str
    line: int
    top: bool

    def __str__(self) -> str:
        return f"{self.source}:{self.line} imports {self.target}"


def modules(root: Path) -> dict[str, Path]:
    """Module name -> file, of all rooms and tools."""
    folders = ("samp_addon", "operators", "models", "training", "batch", *TOOLS)
    files = [path for folder in folders for path in sorted((root / folder).rglob("*.py"))]
    named = {".".join(path.relative_to(root).with_suffix("").parts): path for path in files}
    return {name.removesuffix(".__init__"): path for name, path in named.items()}


def _nodes(node: ast.AST, top: bool = True) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    """All import statements below a node, and whether each runs at import."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child, top
        else:
            yield from _nodes(child, top and not _is_late(child))


def _is_late(node: ast.AST) -> bool:
    """Whether what a node holds does not run at import: a function's body, or what only type checkers read."""
    if isinstance(node, ast.If):
        return "TYPE_CHECKING" in ast.unparse(node.test)
    return isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)


def imports(known: dict[str, Path]) -> list[Import]:
    """Every import of every module; of ``from . import a, b`` one for each name that is a module."""
    return [found for name, path in known.items() for found in _imports(name, path, known)]


def _imports(name: str, path: Path, known: dict[str, Path]) -> Iterator[Import]:
    with tokenize.open(path) as file:
        tree = ast.parse(file.read(), str(path))
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    for node, top in _nodes(tree):
        if isinstance(node, ast.Import):
            targets = [alias.name for alias in node.names]
        else:
            base = package[: len(package) - node.level + 1] if node.level else []
            base = [*base, *(node.module.split(".") if node.module else [])]
            targets = [".".join([*base, alias.name]) for alias in node.names]
        for target in targets:
            yield Import(name, _module(target, known), node.lineno, top)


def _module(target: str, known: dict[str, Path]) -> str:
    """The module that a dotted name is, or is in; the first part of it where it is none of this tree."""
    parts = target.removeprefix(f"{PACKAGE}.").split(".")
    for end in range(len(parts), 0, -1):
        if ".".join(parts[:end]) in known:
            return ".".join(parts[:end])
    return parts[0]


def room(module: str) -> str:
    """The room of a module."""
    parts = module.split(".")
    if parts[0] != "samp_addon":
        return parts[0]
    return parts[1] if len(parts) > 1 and (ROOT / "samp_addon" / parts[1]).is_dir() else "program"


def circles(found: list[Import]) -> list[list[str]]:
    """Strongly connected groups of two or more modules, and modules that import themselves (Tarjan 1972)."""
    graph = defaultdict(set)
    for each in found:
        graph[each.source].add(each.target)
    order, low, stack, result = {}, {}, [], []

    def visit(module: str) -> None:
        order[module] = low[module] = len(order)
        stack.append(module)
        for target in sorted(graph.get(module, ())):
            if target not in order:
                visit(target)
                low[module] = min(low[module], low[target])
            elif target in stack:
                low[module] = min(low[module], order[target])
        if low[module] == order[module]:
            at = stack.index(module)
            group, stack[at:] = stack[at:], []
            if len(group) > 1 or module in graph.get(module, ()):
                result.append(sorted(group))

    for module in sorted(graph):
        if module not in order:
            visit(module)
    return result


KNOWN = modules(ROOT)
FOUND = imports(KNOWN)


def test_every_room_has_its_arrows():
    """A new folder of samp_addon has to be entered in the table."""
    assert {room(module) for module in KNOWN} == {*ARROWS, *TOOLS}


def test_the_documentation_repeats_the_table():
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    rows = re.findall(r"^(\w+) +-> ([\w, ]+)$", text, re.MULTILINE)
    assert {name: set(others.split(", ")) for name, others in rows} == {
        name: others for name, others in ARROWS.items() if others
    }


def test_no_circle_between_modules():
    assert circles([each for each in FOUND if each.target in KNOWN]) == []


@pytest.mark.parametrize("name", ARROWS)
def test_rooms_import_only_what_the_table_allows(name):
    allowed = {name, *ARROWS[name]} | ({"program"} if name != "models" else set())
    wrong = [each for each in FOUND if room(each.source) == name and each.target in KNOWN]
    assert [str(each) for each in wrong if room(each.target) not in allowed] == []


def test_the_table_has_no_circle():
    arrows = [Import(one, other, 0, True) for one, others in ARROWS.items() for other in others]
    assert circles(arrows) == []


def test_only_some_rooms_import_blender():
    wrong = [each for each in FOUND if each.target in BLENDER or each.target.startswith("bl_")]
    assert [str(each) for each in wrong if room(each.source) not in MAY_IMPORT_BLENDER] == []


def test_torch_is_not_loaded_at_registration():
    """Not at import of the rooms that Blender loads first, nor of a method's package."""
    wrong = [each for each in FOUND if each.top and each.target == "torch"]
    early = [
        each
        for each in wrong
        if room(each.source) in NO_TORCH_AT_IMPORT
        or (room(each.source) == "methods" and KNOWN[each.source].name == "__init__.py")
    ]
    assert [str(each) for each in early] == []


def test_models_import_torch_and_numpy_only():
    allowed = {*MODELS_MAY_IMPORT, *sys.stdlib_module_names}
    wrong = [each for each in FOUND if room(each.source) == "models" and each.target not in KNOWN]
    assert [str(each) for each in wrong if each.target not in allowed] == []


@pytest.mark.parametrize(
    ("files", "expected"),
    [
        ({"a": "from . import b", "b": "import os"}, []),
        ({"a": "from . import b", "b": "from . import a"}, [["samp_addon.a", "samp_addon.b"]]),
        ({"a": "from .b import x", "b": "def f():\n    from . import a"}, [["samp_addon.a", "samp_addon.b"]]),
        (
            {"a": "from ..samp_addon import b", "b": "if TYPE_CHECKING:\n    from .a import T"},
            [["samp_addon.a", "samp_addon.b"]],
        ),
        ({"a": f"import {PACKAGE}.samp_addon.a"}, [["samp_addon.a"]]),
    ],
)
def test_circles_are_found_wherever_the_import_stands(tmp_path, files, expected):
    (tmp_path / "samp_addon").mkdir()
    for name, text in files.items():
        (tmp_path / "samp_addon" / f"{name}.py").write_text(text)
    assert circles(imports(modules(tmp_path))) == expected
