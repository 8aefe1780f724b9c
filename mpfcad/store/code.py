"""Which code a figure comes from: the package's own text, and the libraries' versions."""

import hashlib
import platform
from collections.abc import Callable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]
#: What figures and files come from, besides mpfcad.
LIBRARIES = (
    "numpy",
    "scipy",
    "numba",
    "build123d",
    "gdstk",
    "klayout",
    "ezdxf",
    "tifffile",
    "pillow",
    "trimesh",
    "plotly",
)
#: Those that only the key of kept work has to know.
_BELOW = ("llvmlite", "manifold3d", "miepython", "pydantic", "shapely", "xarray")
#: What a trace depends on besides its inputs: `measure` and all that it imports.
TRACE = (
    "measure", "backlight", "optics", "film", "spectrum", "store", "boundary",
    "compiling.py", "errors.py", "sound.py", "units.py",
)  # fmt: skip
#: What shows results or asks for them: no kept work depends on it.
SHOWN = ("report", "cli", "api")
#: A file that compiles a kernel has one of these words in it.
_KERNEL_WORDS = (b"njit", b"base.kernel")


@cache
def code_hash(*packages: str) -> str:
    """Return the SHA-256 of all of mpfcad's files, presets included, or of some packages' only."""
    places = [_PACKAGE / package for package in packages] or [_PACKAGE]
    return _hash(lambda path, text: _is_within(path, places))


@cache
def work_hash(kind: str) -> str:
    """Return the SHA-256 of the code that an entry of a kind depends on.

    Kernels: `kernel_hash`. Half-done traces and those of fits: `TRACE`. All else: every file but
    those of `SHOWN`.
    """
    if kind == "kernel":
        return kernel_hash()
    if kind in ("trace", "fit"):
        return code_hash(*TRACE)
    shown = [_PACKAGE / package for package in SHOWN]
    return _hash(lambda path, text: not _is_within(path, shown))


def _is_within(path: Path, places: list[Path]) -> bool:
    return any(path == place or place in path.parents for place in places)


@cache
def kernel_hash() -> str:
    """Return the SHA-256 of every file whose text is compiled, or gives a kernel its constants."""
    places = [_PACKAGE / "optics", _PACKAGE / "units.py"]

    def compiles(path: Path, text: bytes) -> bool:
        if path.suffix != ".py":
            return False
        return _is_within(path, places) or any(word in text for word in _KERNEL_WORDS)

    return _hash(compiles)


def _hash(is_part: Callable[[Path, bytes], bool]) -> str:
    digest = hashlib.sha256()
    for path in sorted(_PACKAGE.rglob("*")):
        if path.suffix in (".pyc", ".nbi", ".nbc") or "__pycache__" in path.parts:
            continue
        if not path.is_file():
            continue
        text = path.read_bytes()
        if is_part(path, text):
            name = path.relative_to(_PACKAGE).as_posix().encode()
            digest.update(b"%d %s %d\n" % (len(name), name, len(text)) + text)
    return digest.hexdigest()


@cache
def _found(libraries: tuple[str, ...]) -> dict[str, str]:
    found = {}
    for library in libraries:
        try:
            found[library] = version(library)
        except PackageNotFoundError:
            found[library] = "not installed"
    return found


def versions() -> dict[str, str]:
    """Return the versions of Python, mpfcad and every library that figures and files come from."""
    from mpfcad import __version__

    return {"python": platform.python_version(), "mpfcad": __version__, **_found(LIBRARIES)}


def all_versions() -> dict[str, str]:
    """Return `versions` and those of the libraries below them."""
    return {**versions(), **_found(_BELOW)}
