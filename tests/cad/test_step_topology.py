"""STEP files read by a parser that is no CAD kernel (steputils): schema, topology, header."""

from collections import Counter

import numpy as np
import pytest
from steputils import p21

from mpfcad.cad import write_step
from mpfcad.cad.step.cell import write_cell_step
from mpfcad.cad.step.file import Header, text
from mpfcad.cad.step.section import FILM_COLOUR, write_section_step
from mpfcad.film import CellFilm, Imperfection, MadeFilm

#: Number of attributes of each entity, inherited ones with it: the same in AP214 and AP242.
ATTRIBUTES = {
    "ADVANCED_BREP_SHAPE_REPRESENTATION": 3, "ADVANCED_FACE": 4, "APPLICATION_CONTEXT": 1,
    "APPLICATION_PROTOCOL_DEFINITION": 4, "AXIS2_PLACEMENT_3D": 4,
    "B_SPLINE_SURFACE_WITH_KNOTS": 13, "CARTESIAN_POINT": 2, "CIRCLE": 3, "CLOSED_SHELL": 2,
    "COLOUR_RGB": 4, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION": 2, "DIRECTION": 2,
    "EDGE_CURVE": 5, "EDGE_LOOP": 2, "FACE_OUTER_BOUND": 3, "FILL_AREA_STYLE": 2,
    "FILL_AREA_STYLE_COLOUR": 2, "ITEM_DEFINED_TRANSFORMATION": 4, "LINE": 3,
    "MANIFOLD_SOLID_BREP": 2, "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION": 3,
    "NEXT_ASSEMBLY_USAGE_OCCURRENCE": 6, "ORIENTED_EDGE": 5, "PARABOLA": 3, "PLANE": 2,
    "PRESENTATION_STYLE_ASSIGNMENT": 1, "PRODUCT": 4, "PRODUCT_CONTEXT": 3,
    "PRODUCT_DEFINITION": 4, "PRODUCT_DEFINITION_CONTEXT": 3, "PRODUCT_DEFINITION_FORMATION": 3,
    "PRODUCT_DEFINITION_SHAPE": 3, "PRODUCT_RELATED_PRODUCT_CATEGORY": 3,
    "SHAPE_DEFINITION_REPRESENTATION": 2, "SHAPE_REPRESENTATION": 3, "STYLED_ITEM": 3,
    "SURFACE_OF_LINEAR_EXTRUSION": 3, "SURFACE_SIDE_STYLE": 2, "SURFACE_STYLE_FILL_AREA": 1,
    "SURFACE_STYLE_USAGE": 2, "UNCERTAINTY_MEASURE_WITH_UNIT": 4, "VECTOR": 3, "VERTEX_POINT": 2,
}  # fmt: skip
#: Types that the references of topology may have.
CURVES = {"LINE", "PARABOLA", "CIRCLE", "complex", "B_SPLINE_CURVE_WITH_KNOTS"}
SURFACES = {"PLANE", "SURFACE_OF_LINEAR_EXTRUSION", "B_SPLINE_SURFACE_WITH_KNOTS", "complex"}


class Step:
    """A file's entities by reference."""

    def __init__(self, path):
        self.file = p21.readfile(str(path))
        self.name, self.parameters = {}, {}
        for entity in self.file.data[0].instances.values():
            if p21.is_complex_entity_instance(entity):
                self.name[entity.ref] = "complex"
                self.parameters[entity.ref] = [e.params for e in entity.entities]
            else:
                self.name[entity.ref] = entity.entity.name
                self.parameters[entity.ref] = entity.entity.params

    def all(self, name):
        return [ref for ref, own in self.name.items() if own == name]

    def references(self, value):
        if p21.is_reference(value):
            yield value
        elif isinstance(value, list | tuple) or p21.is_parameter_list(value):
            for part in value:
                yield from self.references(part)


def check_schema(step):
    for ref, name in step.name.items():
        parameters = step.parameters[ref]
        assert set(step.references(parameters)) <= set(step.name), (ref, name)
        if name != "complex":
            assert len(parameters) == ATTRIBUTES[name], (ref, name)
    for ref in step.all("EDGE_CURVE"):
        _, start, end, curve, sense = step.parameters[ref]
        assert step.name[start] == step.name[end] == "VERTEX_POINT" and start != end
        assert step.name[curve] in CURVES and str(sense) == ".T."
    for ref in step.all("ADVANCED_FACE"):
        _, bounds, surface, _ = step.parameters[ref]
        assert [step.name[b] for b in bounds] == ["FACE_OUTER_BOUND"]
        assert step.name[surface] in SURFACES


def check_topology(step):
    """Each oriented edge in one loop, loops closed, shells closed, nothing shared by solids."""
    in_loops = Counter(e for r in step.all("EDGE_LOOP") for e in step.parameters[r][1])
    assert set(in_loops) == set(step.all("ORIENTED_EDGE"))
    assert set(in_loops.values()) == {1}
    owners = Counter()
    for solid in step.all("MANIFOLD_SOLID_BREP"):
        shell = step.parameters[solid][1]
        uses, own = Counter(), {shell}
        for face in step.parameters[shell][1]:
            own.add(face)
            loop = step.parameters[step.parameters[face][1][0]][1]
            own.add(loop)
            ends = []
            for oriented in step.parameters[loop][1]:
                _, _, _, edge, sense = step.parameters[oriented]
                _, start, end, _, _ = step.parameters[edge]
                forward = str(sense) == ".T."
                uses[edge, forward] += 1
                ends.append((start, end) if forward else (end, start))
                own |= {oriented, edge, start, end}
            for (_, end), (start, _) in zip(ends, ends[1:] + ends[:1], strict=True):
                assert end == start, loop
        # Each edge of a closed shell once in each direction.
        assert set(uses.values()) == {1}
        assert {(edge, not forward) for edge, forward in uses} == set(uses)
        owners.update(own)
    assert set(owners.values()) == {1}


def check_ends(step):
    """Vertices of straight edges lie on their lines."""

    def place(ref):
        return np.array([float(v) for v in step.parameters[ref][1]])

    for ref in step.all("EDGE_CURVE"):
        _, start, end, curve, _ = step.parameters[ref]
        if step.name[curve] != "LINE":
            continue
        origin, vector = step.parameters[curve][1:]
        way = place(step.parameters[vector][1])
        for vertex in (start, end):
            apart = place(step.parameters[vertex][1]) - place(origin)
            assert np.linalg.norm(np.cross(apart, way)) < 1e-9
        along = place(step.parameters[end][1]) - place(step.parameters[start][1])
        assert along @ way > 0


@pytest.mark.parametrize("protocol", ["ap214", "ap242"])
@pytest.mark.parametrize("bodies", ["separate", "fused"])
def test_grooves(make_film, tmp_path, protocol, bodies):
    film = make_film([60.0, 80.0, 20.0, 79.99, 0.0, 40.0, 60.0])
    path = tmp_path / "film.step"
    header = Header(protocol, "Zoë O'Neil", "光学")
    write_step(film, path, bodies=bodies, header=header)
    step = Step(path)
    check_schema(step)
    check_topology(step)
    check_ends(step)
    schema = str(step.file.header["FILE_SCHEMA"].params[0][0])
    assert schema.startswith(
        "AUTOMOTIVE_DESIGN {" if protocol == "ap214" else "AP242_MANAGED_MODEL_BASED_3D_ENGI"
    )
    named = step.file.header["FILE_NAME"].params
    assert [p21.step_decoder(str(part[0])) for part in named[2:4]] == ["Zoë O'Neil", "光学"]
    # Each product has its own solids, and they are all of them.
    shapes = [step.parameters[r][1][1:] for r in step.all("ADVANCED_BREP_SHAPE_REPRESENTATION")]
    solids = [solid for shape in shapes for solid in shape]
    assert sorted(solids) == sorted(step.all("MANIFOLD_SOLID_BREP"))


def test_other_kinds(make_film, tmp_path):
    made = MadeFilm(make_film([60.0, 50.0]), Imperfection(tip_radius=0.002, valley_radius=0.001))
    write_section_step(
        made.section(), tmp_path / "made.step", name="a", body="film", colour=FILM_COLOUR
    )
    groove = make_film(60.0).groove
    write_cell_step(CellFilm(groove, 0.2, "pyramid", "filled", 60.0, (2, 3)), tmp_path / "c.step")
    for path in (tmp_path / "made.step", tmp_path / "c.step"):
        step = Step(path)
        check_schema(step)
        check_topology(step)


def test_strings_are_written_in_ascii():
    assert text("O'Neil\\µ") == r"'O''Neil\\\X2\00B5\X0\'"
    assert text("𝛼") == r"'\X4\0001D6FC\X0\'"
