"""Writers of areal maps in instruments' formats, from the formats' descriptions."""

import struct
import zipfile

import numpy as np

XML = """<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1><Revision>ISO5436 - 2000</Revision>
<FeatureType>SUR</FeatureType><Axes>
<CX><AxisType>I</AxisType><DataType>D</DataType><Increment>{step}</Increment><Offset>0</Offset></CX>
<CY><AxisType>I</AxisType><DataType>D</DataType><Increment>{step}</Increment><Offset>0</Offset></CY>
<CZ><AxisType>A</AxisType><DataType>D</DataType><Increment>1</Increment><Offset>0</Offset></CZ>
</Axes></Record1>
<Record2><Date>2026-01-01T00:00:00.0Z</Date><Instrument><Manufacturer>x</Manufacturer><Model>x</Model>
<Serial>x</Serial><Version>x</Version></Instrument><CalibrationDate>2026-01-01T00:00:00.0Z</CalibrationDate>
<ProbingSystem><Type>Contacting</Type><Identification>x</Identification></ProbingSystem></Record2>
<Record3><MatrixDimension><SizeX>{nx}</SizeX><SizeY>{ny}</SizeY><SizeZ>1</SizeZ></MatrixDimension>
<DataLink><PointDataLink>bindata/data.bin</PointDataLink>
<MD5ChecksumPointData>0</MD5ChecksumPointData></DataLink></Record3>
<Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4></p:ISO5436_2>
"""


def write_map(path, height, step):
    """Write heights (nx, ny) [mm] at steps [mm]; the ending says in which format."""
    {".x3p": _x3p, ".sdf": _sdf, ".gwy": _gwy}[path.suffix](path, height / 1e3, step / 1e3)


def _x3p(path, z, step):
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("main.xml", XML.format(step=repr(step), nx=z.shape[0], ny=z.shape[1]))
        file.writestr("bindata/data.bin", np.ascontiguousarray(z.T).astype("<f8").tobytes())


def _sdf(path, z, step):
    head = {
        "ManufacID": "x", "CreateDate": "010120261200", "ModDate": "010120261200",
        "NumPoints": z.shape[0], "NumProfiles": z.shape[1], "Xscale": f"{step:.9E}",
        "Yscale": f"{step:.9E}", "Zscale": "1.0E-9", "Zresolution": "1.0E-12", "Compression": "0",
        "DataType": "7", "CheckType": "0",
    }  # fmt: skip
    lines = ["aISO-1.0", *(f"{key} = {value}" for key, value in head.items()), "*"]
    lines += [" ".join(f"{v * 1e9:.1f}" for v in row) for row in z.T]
    path.write_text("\n".join([*lines, "*", ""]))


def _gwy(path, z, step):
    def item(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + data

    def item_object(name, kind, *items):
        body = b"".join(items)
        return item(name, "o", kind.encode() + b"\0" + struct.pack("<I", len(body)) + body)

    def unit(name):
        return item_object(name, "GwySIUnit", item("unitstr", "s", b"m\0"))

    numbers = np.ascontiguousarray(z.T).astype("<f8")
    field = item_object(
        "/0/data",
        "GwyDataField",
        item("xres", "i", struct.pack("<i", z.shape[0])),
        item("yres", "i", struct.pack("<i", z.shape[1])),
        item("xreal", "d", struct.pack("<d", step * z.shape[0])),
        item("yreal", "d", struct.pack("<d", step * z.shape[1])),
        unit("si_unit_xy"),
        unit("si_unit_z"),
        item("data", "D", struct.pack("<I", numbers.size) + numbers.tobytes()),
    )
    body = field + item("/0/data/title", "s", b"Height\0")
    path.write_bytes(b"GWYPGwyContainer\0" + struct.pack("<I", len(body)) + body)
