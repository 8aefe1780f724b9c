"""Which format a file's bytes are of, and what a file that is no mesh looks like."""

_MAGIC = (
    (b"\x89PNG", "a PNG image"), (b"%PDF", "a PDF"), (b"glTF", "a glTF binary"),
    (b"\xd0\xcf\x11\xe0", "an OLE file, as SolidWorks and old Office write"),
    (b"\x1f\x8b", "a gzip archive"), (b"Rar!", "a RAR archive"), (b"7z\xbc\xaf", "a 7z archive"),
    (b"\xff\xd8\xff", "a JPEG image"), (b"II*\0", "a TIFF image"), (b"MM\0*", "a TIFF image"),
    (b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ", "a Parasolid file"), (b"ACIS", "an ACIS file"),
    (b"400 ", "an ACIS SAT file"), (b"Version", "a JT file"), (b"AC10", "a DWG drawing"),
    (b"Kaydara FBX", "an FBX file"), (b"BLENDER", "a Blender file"), (b"COFF", "a binary OFF"),
    (b"OFF", "an OFF mesh"), (b"<?xml", "an XML file"), (b"<", "an XML or HTML file"),
    (b"# VTK", "a VTK file"), (b"$MeshFormat", "a gmsh mesh"), (b"{", "a JSON file"),
)  # fmt: skip
#: What has no mark: text of no known kind, or a binary STL that is cut off.
PLAIN = "no known kind of file"
_OBJ = (b"v", b"vn", b"vt", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl")


def mesh_format(data: bytes) -> str | None:
    """Return stl-text, stl, 3mf, ply, obj or step, by the bytes alone; None where it is no other.

    A binary STL has no mark: it is what has room for its count of facets.
    """
    start = data[:4000].lstrip(b"\xef\xbb\xbf \t\r\n")
    lower = start.lower()
    if data.startswith(b"PK\x03\x04"):
        return "3mf" if b"3dmodel.model" in data else None
    if start.startswith(b"ISO-10303-21"):
        return "step"
    if lower.startswith((b"ply\n", b"ply\r", b"ply ")):
        return "ply"
    if lower.startswith(b"solid") and (b"facet" in lower or b"endsolid" in lower):
        return "stl-text"
    if len(data) >= 84 and len(data) >= 84 + 50 * int.from_bytes(data[80:84], "little") > 84:
        return "stl"
    words = [line.split() for line in start.splitlines() if line.split() and line[:1] != b"#"]
    if words and words[0][0] in _OBJ and b"\0" not in start:
        return "obj"
    return None


def looks_like(data: bytes) -> str:
    """Return in words what a file seems to be."""
    if not data:
        return "an empty file"
    if data.startswith(b"PK\x03\x04"):
        return "a ZIP archive without a 3MF model"
    start = data[:400].lstrip(b"\xef\xbb\xbf \t\r\n")
    for magic, words in _MAGIC:
        if start.startswith(magic):
            return words
    if data[72:73] == b"S" and data[73:80].strip().isdigit():
        return "an IGES file"
    if b"\0" not in data[:400] and b"SECTION" in data[:400]:
        return "a DXF drawing"
    return PLAIN
