"""Operators do not replace private methods of their bases by accident: a window found a tool that never ended."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "operators"
CLASSES = {
    node.name: node
    for path in sorted(FOLDER.glob("*.py"))
    for node in ast.parse(path.read_text()).body
    if isinstance(node, ast.ClassDef)
}


def private(name: str) -> set[str]:
    """Return the private methods of a class."""
    defined = {node.name for node in CLASSES[name].body if isinstance(node, ast.FunctionDef)}
    return {method for method in defined if method.startswith("_") and not method.startswith("__")}


def bases(name: str) -> set[str]:
    """Return the bases of a class that are defined beside it, and theirs."""
    own = {base.id for base in CLASSES[name].bases if isinstance(base, ast.Name)} & set(CLASSES)
    return own.union(*(bases(base) for base in own))


def test_there_are_operators_with_bases():
    assert "ThreadOperator" in bases("SAMP_OT_place") and private("ThreadOperator")


@pytest.mark.parametrize("name", CLASSES)
def test_private_methods_are_not_replaced(name):
    replaced = {base: private(name) & private(base) for base in bases(name)}
    assert not any(replaced.values()), replaced
