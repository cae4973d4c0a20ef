"""A digest of all code that a stage reaches, so that a changed formula recomputes what depends on it.

Prefect's own TASK_SOURCE sees the text of the task function alone: it misses every function below it
and fires on a changed comment. Here the syntax trees count, without comments and docstrings: of the
task function, of what it names in its own module, and of every module of ours that these import,
however deep. Libraries whose version can change a number count by their version.
"""

import ast
import hashlib
import importlib.util
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final, ParamSpec, TypeVar

from tasks.code_memory import OURS, remembered, sources_read

P = ParamSpec("P")
R = TypeVar("R")

NUMERIC_LIBRARIES: Final = {
    "numpy": ("numpy",),
    "scipy": ("scipy",),
    "skimage": ("scikit-image",),
    "open3d": ("open3d-cpu", "open3d"),
    "laspy": ("laspy", "lazrs"),
    "numba": ("numba", "llvmlite"),
    "pyarrow": (),
}

_PARSING: Final = threading.Lock()

MOST_TRIES: Final = 5
"""To parse one source."""


@lru_cache(maxsize=128)
def code_version(function: Callable[..., object]) -> str:
    """Digest (hex) of the code that ``function`` reaches.

    Names that the function uses are followed: those of its own module as definitions, those that it
    imports as whole modules with everything that these import.
    """
    return remembered(function, lambda: _version_of(function))


def _version_of(function: Callable[..., object]) -> str:
    sources_read()
    home = _parsed(function.__module__)
    reached = _definitions_from(home, function.__name__)
    digest = hashlib.sha256()
    for name in sorted(reached.definitions):
        digest.update(ast.dump(reached.definitions[name]).encode())
    modules = sorted(_closure(tuple(sorted(reached.modules))))
    for module in modules:
        digest.update(f"{module}\n{_content_of(module)}\n".encode())
    libraries = set(reached.libraries).union(*(_imports_of(m).libraries for m in modules))
    for library in sorted(libraries & NUMERIC_LIBRARIES.keys()):
        digest.update("\n".join(_versions(library)).encode())
    return digest.hexdigest()


class _Reached:
    """What a function names: definitions of its own module, modules of ours, other libraries."""

    def __init__(self) -> None:
        self.definitions: dict[str, ast.AST] = {}
        self.modules: set[str] = set()
        self.libraries: set[str] = set()


def _definitions_from(home: ast.Module, start: str) -> _Reached:
    own = dict(_top_level(home))
    bindings = dict(_bindings(home))
    reached, waiting = _Reached(), [start]
    while waiting:
        name = waiting.pop()
        if name in own and name not in reached.definitions:
            reached.definitions[name] = own[name]
            waiting += [node.id for node in ast.walk(own[name]) if isinstance(node, ast.Name)]
            inner = _imports(own[name], "")
            reached.modules |= inner.modules
            reached.libraries |= inner.libraries
        for module in bindings.get(name, ()):
            (reached.modules if module.split(".")[0] in OURS else reached.libraries).add(module)
    return reached


def _top_level(tree: ast.Module) -> Iterator[tuple[str, ast.AST]]:
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            # a decorator says how a function is run, not what it computes
            node.decorator_list = []
            yield node.name, node
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for target in targets:
                if isinstance(target, ast.Name):
                    yield target.id, node


def _bindings(tree: ast.Module) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Name that an import binds, and the modules that stand behind it."""
    for node in tree.body:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield (alias.asname or alias.name).split(".")[0], (alias.name,)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                yield alias.asname or alias.name, _behind(node.module, alias.name)


def _behind(module: str, name: str) -> tuple[str, ...]:
    deeper = f"{module}.{name}"
    return (module, deeper) if _path_of(deeper) else (module,)


@lru_cache(maxsize=256)
def _closure(modules: tuple[str, ...]) -> frozenset[str]:
    """Find every module of ours that ``modules`` import, directly or not, themselves included."""
    found: set[str] = set()
    waiting = list(modules)
    while waiting:
        module = waiting.pop()
        if module in found or _path_of(module) is None:
            continue
        found.add(module)
        waiting += _imports_of(module).modules
        waiting += [module.rpartition(".")[0]] if "." in module else []
    return frozenset(found)


@lru_cache(maxsize=1024)
def _imports_of(module: str) -> _Reached:
    """What a whole module imports; not to be changed."""
    return _imports(_parsed(module), module)


@lru_cache(maxsize=1024)
def _content_of(module: str) -> str:
    """Digest (hex) of the syntax tree of a whole module."""
    return hashlib.sha256(ast.dump(_parsed(module)).encode()).hexdigest()


def _imports(tree: ast.AST, module: str) -> _Reached:
    reached = _Reached()
    for node in ast.walk(tree):
        names: tuple[str, ...] = ()
        if isinstance(node, ast.Import):
            names = tuple(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = tuple(m for alias in node.names for m in _behind(node.module, alias.name))
        elif isinstance(node, ast.Name) and node.id == "discover":
            # variants are found at run time: every file beside this one counts
            names = tuple(_siblings(module))
        for name in names:
            if name.split(".")[0] in OURS:
                reached.modules.add(name)
            else:
                reached.libraries.add(name.split(".")[0])
    return reached


def _siblings(package: str) -> Iterator[str]:
    path = _path_of(package)
    if path is not None and path.name == "__init__.py":
        for file in sorted(path.parent.glob("*.py")):
            if file.name != "__init__.py":
                yield f"{package}.{file.stem}"


@lru_cache(maxsize=1024)
def _path_of(module: str) -> Path | None:
    """File of a module of ours, without importing it; None where there is no such module."""
    root = module.split(".", maxsplit=1)[0]
    if root not in OURS:
        return None
    spec = importlib.util.find_spec(root)
    if spec is None or not spec.submodule_search_locations:
        return None
    base = Path(next(iter(spec.submodule_search_locations))).joinpath(*module.split(".")[1:])
    for candidate in (base / "__init__.py", base.with_suffix(".py")):
        if candidate.is_file():
            return candidate
    return None


@lru_cache(maxsize=1024)
def _parsed(module: str) -> ast.Module:
    path = _path_of(module)
    if path is None:
        spec = importlib.util.find_spec(module)
        if spec is None or spec.origin is None:
            raise ModuleNotFoundError(f"code_version finds no source of module {module!r}")
        path = Path(spec.origin)
    tree = _parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            _drop_docstring(node)
    return tree


def _parse(text: str) -> ast.Module:
    """Parse a source; threads take turns.

    Python 3.11 counts the depth of what it builds for all threads together, and so may refuse sound sources when two of
    them parse at once (SystemError, "AST constructor recursion depth mismatch"). Other libraries parse, too: so once more.
    """
    with _PARSING:
        for _ in range(MOST_TRIES - 1):
            with suppress(SystemError):
                return ast.parse(text)
        return ast.parse(text)


def _drop_docstring(node: ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) -> None:
    """Take bare texts out of a body: its docstring, and those that stand below a constant or a field."""
    node.body = [part for part in node.body if not _is_text(part)] or [ast.Pass()]


def _is_text(part: ast.stmt) -> bool:
    return (
        isinstance(part, ast.Expr)
        and isinstance(part.value, ast.Constant)
        and isinstance(part.value.value, str)
    )


def library_versions() -> tuple[str, ...]:
    """Installed libraries whose version can change a number, with their versions."""
    return tuple(told for library in sorted(NUMERIC_LIBRARIES) for told in _versions(library))


@lru_cache(maxsize=64)
def _versions(library: str) -> tuple[str, ...]:
    found = []
    for distribution in NUMERIC_LIBRARIES[library]:
        with suppress(PackageNotFoundError):
            found.append(f"{distribution}=={version(distribution)}")
    return tuple(found)
