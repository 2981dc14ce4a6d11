"""_core.pyi says what the extension has: names by stubtest, signatures by the docstrings."""

from __future__ import annotations

import ast
import inspect
import operator
import re
from collections.abc import Iterator
from typing import Any

import pytest

import asap
from asap import _core
from house import ROOT

STUB = ast.parse((ROOT / "python" / "asap" / "_core.pyi").read_text())

# (kind, name, default as source text or None)
Signature = list[tuple[str, str, "str | None"]]
ANY: Signature = [("any", "*args, **kwargs", None)]


def test_lazy_modules_are_imported_and_getattr_hidden_for_the_type_checker() -> None:
    """A type checker would take any name for one of a module that has a __getattr__."""
    tree = ast.parse((ROOT / "python" / "asap" / "__init__.py").read_text())
    (guard,) = [node for node in tree.body if isinstance(node, ast.If)]
    assert ast.unparse(guard.test) == "TYPE_CHECKING"
    imported = {
        alias.name: node.module
        for node in guard.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    modules = dict.fromkeys(asap._MODULES, "asap")
    assert imported == modules | {name: f"asap.{home}" for name, home in asap._NAMES.items()}
    (hidden,) = guard.orelse
    assert isinstance(hidden, ast.FunctionDef) and hidden.name == "__getattr__"
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert "__getattr__" not in functions
    with pytest.raises(AttributeError, match="'simulat'"):
        asap.simulat  # noqa: B018


def signature(function: ast.FunctionDef) -> Signature:
    """Names, kinds and defaults of the arguments, without self. C++ alone says numbers."""
    arguments = function.args
    if arguments.vararg:
        return ANY
    positional = [*arguments.posonlyargs, *arguments.args]
    missing: list[ast.expr | None] = [None] * (len(positional) - len(arguments.defaults))
    pairs = [
        *zip(positional, [*missing, *arguments.defaults], strict=True),
        *zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True),
    ]
    return [
        (
            "keyword" if argument in arguments.kwonlyargs else "positional",
            argument.arg,
            None if default is None else re.sub(r"-?\d.*", "...", ast.unparse(default)),
        )
        for argument, default in pairs
        if argument.arg != "self"
    ]


def signatures_of_stub(owner: ast.ClassDef | ast.Module) -> dict[str, list[Signature]]:
    """By name; more than one for an overloaded function. Not for operators and properties."""
    found: dict[str, list[Signature]] = {}
    for node in owner.body:
        if isinstance(node, ast.FunctionDef) and not is_operator_or_property(node):
            found.setdefault(node.name, []).append(signature(node))
    return found


def is_operator_or_property(function: ast.FunctionDef) -> bool:
    if function.name.startswith("__") and function.name != "__init__":
        return True
    return any(ast.unparse(decorator) == "property" for decorator in function.decorator_list)


def without_defaults(arguments: Signature) -> list[tuple[str, str]]:
    return [(kind, name) for kind, name, _ in arguments]


def look_up(path: str) -> Any:
    return operator.attrgetter(path)(_core)


def signatures_at_runtime(path: str, thing: Any) -> list[Signature]:
    """A constructor's own; else pybind11's, one line of the docstring or a line per overload."""
    owner, _, name = path.rpartition(".")
    if thing.__text_signature__ is not None:
        return [signature(parsed(f"{name}{inspect.signature(look_up(owner))} -> None"))]
    first, *rest = thing.__doc__.splitlines()
    if rest and rest[0] == "Overloaded function.":
        lines = [match[1] for line in rest if (match := re.match(rf"\d+\. ({name}\(.*)", line))]
    else:
        lines = [first]
    return [signature(parsed(line)) for line in lines]


def parsed(line: str) -> ast.FunctionDef:
    (function,) = ast.parse(f"def {line}: ...").body
    assert isinstance(function, ast.FunctionDef)
    return function


def callables_of_stub() -> Iterator[tuple[str, list[Signature]]]:
    for name, signatures in signatures_of_stub(STUB).items():
        yield name, signatures
    classes = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
    for node in classes.values():
        if not node.name.startswith("_"):  # a private base stands in the stub alone
            bases = [classes[base] for base in map(ast.unparse, node.bases) if base in classes]
            for owner in (*bases, node):
                for name, signatures in signatures_of_stub(owner).items():
                    yield f"{node.name}.{name}", signatures


CALLABLES = dict(callables_of_stub())


@pytest.mark.parametrize("path", [path for path, found in CALLABLES.items() if ANY not in found])
def test_signature(path: str) -> None:
    thing = look_up(path)
    documented, stubbed = signatures_at_runtime(path, thing), CALLABLES[path]
    if len(documented) == 1:  # overloads in the stub tell types apart, not arguments
        assert [without_defaults(one) for one in stubbed[1:]] == [
            without_defaults(documented[0]) for _ in stubbed[1:]
        ]
        stubbed = stubbed[:1]
    assert documented == stubbed
