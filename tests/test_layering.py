"""Imports point down only, no cycles, and each module can be imported."""

import ast
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import mpfcad

ROOT = Path(mpfcad.__file__).parent
LAYER = {
    "mpfcad": 0,
    "units": 0,
    "errors": 0,
    "sound": 0.5,
    "gate": 0.5,
    "compiling": 0,
    "boundary": 1,
    "store": 1.5,
    "film": 2,
    "spectrum": 2,
    "mask": 3,
    "cad": 3,
    "optics": 3,
    "backlight": 4,
    "measure": 5,
    "design": 6,
    "confidence": 6,
    "fit": 6.5,
    "export": 7,
    "record": 7,
    "report": 8,
    "job": 9,
    "pipeline": 10,
    "cli": 11,
    "api": 12,
}
#: Packages that must not see each other although one of them is not above the other.
APART = {"optics": {"film", "mask", "cad"}, "mask": {"cad"}, "cad": {"mask"}}
MODULES = sorted(
    ".".join(("mpfcad", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")
    for path in ROOT.rglob("*.py")
)


def source_of(module):
    path = ROOT.joinpath(*module.split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def imports_of(module):
    """Return the mpfcad modules that `module` imports, in its functions too."""
    found = set()
    for node in ast.walk(ast.parse(source_of(module).read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: relative import"
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in MODULES else node.module for name in inner}
    return {name for name in found if name.split(".")[0] == "mpfcad"}


#: The package itself only hands on the names of `api`, when they are first used.
INNER = [module for module in MODULES if module != "mpfcad"]


def package_of(module):
    return module.split(".")[1] if "." in module else "mpfcad"


def test_imports_point_down():
    wrong = [(module, name) for module in INNER for name in imports_of(module) if up(module, name)]
    assert wrong == []


def up(module, name):
    """Return whether a module may not import another."""
    here, there = package_of(module), package_of(name)
    down = there == here or LAYER[there] < LAYER[here]
    return not down or there in APART.get(here, ())


def test_no_cycles():
    """Deferred imports count too: a cycle that only shows later is a cycle all the same."""
    graph = {}
    for module in INNER:
        names = imports_of(module) - {module}
        # `mpfcad.x` imported from one of its own files only names the folder.
        graph[module] = {name for name in names & set(INNER) if not module.startswith(name + ".")}
    list(TopologicalSorter(graph).static_order())


def test_each_module_imports():
    """In any order: without cycles (above) a module finds all that it needs as it is imported."""
    code = "import importlib, sys; [importlib.import_module(name) for name in sys.argv[1:]]"
    done = subprocess.run([sys.executable, "-c", code, *reversed(MODULES)], check=False)
    assert done.returncode == 0
