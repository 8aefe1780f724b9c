"""The errors of the package, one class a kind of trouble; each ends a command with one line.

`InputError` is the user's to mend: exit code 2. `ExportError` says that a file is not what it
should be: exit code 1, and 4 where `mpfcad verify` finds an export changed. The others mean that
something of ours went wrong: exit code 3.
"""


class MpfcadError(Exception):
    """Any error that mpfcad raises on purpose."""


class InputError(MpfcadError):
    """A file, field or row of the user's is wrong; the text names it, its value and the range."""


class GeometryError(MpfcadError):
    """A film, solid or mesh that cannot be what it should be."""


class ExportError(MpfcadError):
    """A file that was written does not read back as what it should hold."""


class TraceError(MpfcadError):
    """A ray trace that cannot be carried out or trusted."""
