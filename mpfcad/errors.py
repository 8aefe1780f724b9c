"""The errors of the house, one class a kind of trouble.

Only `InputError` is the user's to mend: the command line prints it as one line and ends with exit
code 2. The others mean that something of ours went wrong and end with exit code 3.
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
