"""What the texts of the project say about the schemes, written from the schemes themselves.

`python tests/python/scheme_texts.py` writes it after a scheme has changed or come: their classes in
the stub, their names in the package, their rows on their page. A row that is there keeps its words.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path

from asap import _core
from house import ROOT

STUB = ROOT / "python" / "asap" / "_core.pyi"
PACKAGE = ROOT / "python" / "asap" / "__init__.py"
PAGE = ROOT / "notebooks" / "schemes.md"

Kind = type[_core.Scheme]

# How pybind11 writes a type, and how the stub does.
TYPES = {
    r"self: [\w.]+": "self",
    r"typing\.SupportsFloat \| typing\.SupportsIndex": "float",
    r"asap\._core\.": "",
}


def typed(signature: str | None) -> str:
    line = (signature or "").splitlines()[0]
    for pattern, name in TYPES.items():
        line = re.sub(pattern, name, line)
    return line


def argument_of(argument: inspect.Parameter) -> str:
    value = argument.default
    kind = "float | None" if value is None else type(value).__name__
    return f"{argument.name}: {kind} = {value!r}".replace("'", '"')


def stub_of(kind: Kind) -> str:
    if kind in _core.SCHEMES:
        named = [*map(argument_of, inspect.signature(kind).parameters.values())]
        arguments = ["self", "*", *named] if named else ["self"]
        line = f"    def __init__({', '.join(arguments)}) -> None: ..."
    else:
        line = f"    def {typed(kind.__init__.__doc__)}: ..."
    if len(line) > 100:
        listed = "".join(f"        {argument},\n" for argument in arguments)
        line = f"    def __init__(\n{listed}    ) -> None: ..."
    lines = [f"class {kind.__name__}(Scheme):", line]
    for name, item in vars(kind).items():
        if isinstance(item, property) and name != "parameters":
            result = typed(item.fget.__doc__).partition(" -> ")[2]
            lines += ["    @property", f"    def {name}(self) -> {result}: ..."]
    return "\n".join(lines) + "\n\n"


def with_classes(stub: str) -> str:
    """The schemes of the user stand in one run of classes, the rivals in the next."""
    rivals = [kind for kind in _core.Scheme.__subclasses__() if kind not in _core.SCHEMES]
    runs = iter([_core.SCHEMES, [kind for kind in rivals if kind.__module__ == _core.__name__]])
    return re.sub(
        r"(?:^class \w+\(Scheme\):\n(?:^    .*\n)+\n)+",
        lambda _: "".join(map(stub_of, next(runs))),
        stub,
        flags=re.M,
    )


def with_names(package: str) -> str:
    """Imported and exported, in the order of the linter."""
    for opening, closing, form in (
        ("from asap._core import (\n", ")\n", "    {},\n"),
        ("__all__ = [\n", "]\n", '    "{}",\n'),
    ):
        before, _, rest = package.partition(opening)
        inside, _, after = rest.partition(f"\n{closing}")
        names = {*re.findall(r"\w+", inside), *(kind.__name__ for kind in _core.SCHEMES)}
        ordered = sorted(names, key=lambda name: (not name.isupper(), name))
        package = before + opening + "".join(map(form.format, ordered)) + closing + after
    return package


def with_rows(page: str) -> str:
    """A row that stands there keeps its place and its words, and its parameters if none changed."""
    (table,) = re.findall(r"(?:^\| `\w+` \|.*\n)+", page, re.M)
    rows = {row.split("`")[1]: row for row in table.splitlines()}
    kinds = {kind.__name__: kind for kind in _core.SCHEMES}
    names = [name for name in (*rows, *kinds) if name in kinds]
    written = [row_of(kinds[name], rows.get(name)) for name in dict.fromkeys(names)]
    return page.replace(table, "".join(f"{row}\n" for row in written))


def row_of(kind: Kind, row: str | None) -> str:
    if row is None:
        summary = str(kind.__doc__).splitlines()[0].rstrip(".")
        row = f"| `{kind.__name__}` | {summary[0].lower()}{summary[1:]} | | |"
    words, last = row.rsplit("|", 2)[:2]
    names = [f"`{name}`" for name in kind().parameters]
    if set(re.findall(r"`\w+`", last)) != set(names):
        last = f" {', '.join(names)} "
    return f"{words}|{last}|"


def texts() -> dict[Path, str]:
    """Every file that speaks of the schemes, as it should be."""
    return {
        STUB: with_classes(STUB.read_text()),
        PACKAGE: with_names(PACKAGE.read_text()),
        PAGE: with_rows(PAGE.read_text()),
    }


if __name__ == "__main__":
    for path, text in texts().items():
        path.write_text(text)
