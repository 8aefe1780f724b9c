"""CAD files of one pitch opened with other programs: FreeCAD, gmsh, admesh and lib3mf.

    python benchmarks/cad_openers.py [--grooves N] [--json]

Each row is what a program found, beside what it should be. A program that is not installed is
named as absent and the script ends with exit code 1: nothing is taken for opened that was not.
Debian has the programs as `freecad-python3`, `gmsh` and `admesh`.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

#: What FreeCAD runs: bodies, volume, and whether all of them are valid.
FREECAD = """import os, Part
shape = Part.Shape()
shape.read(os.environ["MPFCAD_STEP"])
valid = shape.isValid() and all(solid.isValid() for solid in shape.Solids)
print("FOUND", len(shape.Solids), repr(shape.Volume), int(valid), flush=True)
"""
#: What gmsh runs: bodies and volume.
GMSH = """SetFactory("OpenCASCADE");
body() = ShapeFromFile("film.step");
total = 0;
For i In {0 : #body() - 1}
  mass = Mass Volume {body(i)};
  total += mass;
EndFor
Printf("FOUND %g %.16g", #body(), total);
"""


def run(command, folder, **environment):
    """Return what a program prints, or None when it is not installed."""
    if shutil.which(command[0]) is None:
        return None
    environment = {**os.environ, **environment}
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=folder, env=environment, check=False
    )
    return done.stdout + done.stderr


def open_step(program, said, bodies, volume):
    """Return the row of a program that prints FOUND, bodies, volume and perhaps validity."""
    name = f"film.step in {program}: bodies, error of the volume, valid"
    if said is None:
        return {"name": f"{program}: absent", "found": None, "expected": None, "met": None}
    found = re.search(r"FOUND (\S+) (\S+)(?: (\d))?", said)
    if found is None:
        return {"name": name, "found": said[-200:], "expected": "bodies", "met": False}
    error = abs(float(found[2]) / volume - 1)
    met = int(float(found[1])) == bodies and error < 1e-9 and found[3] in (None, "1")
    state = "" if found[3] is None else f", valid {found[3]}"
    what = f"{float(found[1]):g}, {error:.1e}{state}"
    return {"name": name, "found": what, "expected": f"{bodies}, <= 1e-9", "met": met}


def open_stl(said):
    """Return the row of admesh."""
    if said is None:
        return {"name": "admesh: absent", "found": None, "expected": None, "met": None}
    words = ("Number of parts", "Degenerate facets", "Facets reversed", "Edges fixed")
    found = [re.search(rf"{word}\s*:\s*(\d+)", said) for word in words]
    numbers = [None if number is None else int(number[1]) for number in found]
    return {
        "name": "film.stl in admesh: parts, degenerate, reversed, edges fixed",
        "found": str(numbers),
        "expected": "[1, 0, 0, 0]",
        "met": numbers == [1, 0, 0, 0],
    }


def open_3mf(path, film):
    """Return the row of lib3mf."""
    from mpfcad.cad import check_3mf
    from mpfcad.errors import ExportError

    name = "film.3mf in lib3mf: unit, names, closed, volumes"
    try:
        check_3mf(path, film)
    except ExportError as error:
        return {"name": name, "found": str(error), "expected": "as written", "met": False}
    return {"name": name, "found": "as written", "expected": "as written", "met": True}


def openers(count):
    from mpfcad.cad import write_3mf, write_step, write_stl
    from mpfcad.film import Groove, PrismFilm
    from mpfcad.units import deg

    curvature = 60 + 19 * np.cos(np.arange(count) / 653.8 * 2 * np.pi)
    film = PrismFilm(Groove(0.050, 0.025), 0.2, 2.0, "filled", curvature)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_step(film, folder / "film.step")
        write_stl(film, folder / "film.stl", 0.5 * deg)
        write_3mf(film, folder / "film.3mf", 0.5 * deg)
        (folder / "open.py").write_text(FREECAD)
        (folder / "open.geo").write_text(GMSH)
        step = str(folder / "film.step")
        freecad = run(["freecadcmd", "open.py"], folder, MPFCAD_STEP=step)
        rows = [
            open_step("FreeCAD", freecad, count + 1, film.volume),
            open_step("gmsh", run(["gmsh", "-0", "open.geo"], folder), count + 1, film.volume),
            open_stl(run(["admesh", "film.stl"], folder)),
            open_3mf(folder / "film.3mf", film),
        ]
    return rows


def main():
    parser = argparse.ArgumentParser(description="CAD files in other programs.")
    parser.add_argument("--grooves", type=int, default=654, help="of the film [654: one pitch]")
    parser.add_argument("--json", action="store_true", help="one list of rows")
    options = parser.parse_args()
    rows = openers(options.grooves)
    if options.json:
        print(json.dumps(rows))
    else:
        words = {True: "met", False: "NOT MET", None: "-"}
        for row in rows:
            found, expected = row["found"] or "", row["expected"] or ""
            print(f"{row['name']:66} {found:24} {expected:16} {words[row['met']]}")
    sys.exit(0 if all(row["met"] for row in rows) else 1)


if __name__ == "__main__":
    main()
