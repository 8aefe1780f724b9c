"""What ray files are made of: IES TM-25, Zemax .DAT and LightTools .ray, all little-endian.

Layouts: IES TM-25-13; OpticStudio's and LightTools' manuals.
"""

import numpy as np

#: Endings of each form, and its name; the first ending of a form is the usual one.
FORMS = {
    ".tm25ray": "IES TM-25",
    ".tm25": "IES TM-25",
    ".dat": "Zemax .DAT",
    ".ray": "LightTools .ray",
}
SUFFIXES = tuple(FORMS)

TM25_MAGIC, RAY_MAGIC, RAY_END = b"TM25", b"LTRF", b"LTRFEND"
#: Kinds that a .DAT may begin with; the first is the usual one.
DAT_KINDS = (1010, 8675309)
#: TM-25's texts: light source, its maker, model's and file's creator, tools, camera, operation,
#: more, reference; characters of each.
TM25_TEXTS, TM25_TEXT = 9, 1000

#: `has`: place, direction, W, wavelength, lm, Stokes, XYZ, spectrum.
TM25 = np.dtype([
    ("magic", "S4"), ("version", "<i4"), ("method", "<i4"), ("lm", "<f4"), ("watt", "<f4"),
    ("rays", "<u8"), ("date", "S28"), ("start", "<i4"), ("spectrum", "<i4"), ("wave", "<f4", 3),
    ("spectra", "<i4"), ("extra", "<i4"), ("text", "<i4"), ("reserved", "S168"), ("has", "<i4", 8),
    ("texts", "<u4", (TM25_TEXTS, TM25_TEXT)),
])  # fmt: skip
DAT = np.dtype([
    ("kind", "<i4"), ("rays", "<u4"), ("text", "S100"), ("flux", "<f4", 3), ("angle", "<f4", 4),
    ("unit", "<u4"), ("pose", "<f4", 9), ("unused", "<f4", 4), ("form", "<i4"), ("type", "<i4"),
    ("rest", "<i4", 2),
])  # fmt: skip
RAY = np.dtype([
    ("magic", "S4"), ("version", "<u4", 2), ("data", "<u4"), ("far", "<u4"), ("colour", "<u4"),
    ("unit", "<u4"), ("origin", "<f4", 3), ("flux", "<f4"),
])  # fmt: skip
