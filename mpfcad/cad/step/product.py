"""Products, assembly and colours of a STEP file: what makes solids into named, coloured parts."""

from pathlib import Path

from mpfcad.cad.step.file import StepFile, text

#: Schema, application, name of the protocol and its year, as each protocol has them. What is
#: written is in both.
PROTOCOL = {
    "ap214": (
        "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
        "core data for automotive mechanical design processes", "automotive_design", 2000,
    ),
    "ap242": (
        "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
        "managed model based 3d engineering", "ap242_managed_model_based_3d_engineering", 2013,
    ),
}  # fmt: skip
#: The distance [mm] below which readers shall take two corners for one.
UNCERTAINTY = "1.E-07"
#: A body's colour: red, green, blue; 0…1.
Colour = tuple[float, float, float]


class Products:
    """The products of one file, all in one frame in mm."""

    def __init__(self, file: StepFile) -> None:
        self.file = file
        _, what, protocol, year = PROTOCOL[file.header.protocol]
        self.application = file.add(f"APPLICATION_CONTEXT('{what}')")
        file.add(
            f"APPLICATION_PROTOCOL_DEFINITION('international standard','{protocol}',{year},"
            f"{self.application})"
        )
        self.context = self._context()
        z, x = file.direction(0, 0, 1), file.direction(1, 0, 0)
        self.origin = file.axes(file.point(0, 0, 0), z, x)

    def part(self, name: str, solids: list[str], colour: Colour) -> tuple[str, str]:
        """Add a product of solids; return its definition and its shape."""
        items = ",".join([self.origin, *solids])
        shape = self.file.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({items}),{self.context})")
        self._colour(solids, colour)
        return self._product(name, shape), shape

    def assembly(self, name: str, parts: dict[str, tuple[str, str]]) -> None:
        """Add a product that holds each part once, where it was drawn."""
        shape = self.file.add(f"SHAPE_REPRESENTATION('',({self.origin}),{self.context})")
        uses = [(part, self.origin) for part in parts]
        self._uses(self._product(name, shape), shape, parts, uses)

    def placed(
        self,
        name: str,
        parts: dict[str, tuple[str, str]],
        where: dict[str, list[tuple[float, float]]],
    ) -> None:
        """Add a product that holds each part at all its places (x, y) [mm], moved alone."""
        file = self.file
        z, x = file.direction(0, 0, 1), file.direction(1, 0, 0)
        uses = [
            (part, file.axes(file.point(*place, 0), z, x))
            for part, places in where.items()
            for place in places
        ]
        axes = ",".join(dict.fromkeys([self.origin, *(place for _, place in uses)]))
        shape = file.add(f"SHAPE_REPRESENTATION('',({axes}),{self.context})")
        self._uses(self._product(name, shape), shape, parts, uses)

    def _uses(
        self,
        whole: str,
        shape: str,
        parts: dict[str, tuple[str, str]],
        uses: list[tuple[str, str]],
    ) -> None:
        """Add an occurrence of a part for each (part, placement)."""
        file = self.file
        for number, (part, place) in enumerate(uses, 1):
            definition, part_shape = parts[part]
            moved = file.share("ITEM_DEFINED_TRANSFORMATION", "''", self.origin, place)
            use = file.add(
                f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}',{text(part)},'',{whole},{definition},$)"
            )
            shape_of_use = file.add(f"PRODUCT_DEFINITION_SHAPE('Placement',$,{use})")
            relation = file.add(
                f"(REPRESENTATION_RELATIONSHIP('','',{part_shape},{shape})"
                f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({moved})"
                "SHAPE_REPRESENTATION_RELATIONSHIP())"
            )
            file.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{shape_of_use})")

    def write(self, path: Path, name: str) -> None:
        """Write the file in the schema of its protocol."""
        self.file.write(path, name, PROTOCOL[self.file.header.protocol][0])

    def _context(self) -> str:
        add = self.file.add
        length = add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
        angle = add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
        solid_angle = add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
        closeness = add(
            f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({UNCERTAINTY}),{length},"
            "'distance_accuracy_value','corners closer than this are one')"
        )
        return add(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)"
            f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({closeness}))"
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))"
            "REPRESENTATION_CONTEXT('','3D'))"
        )

    def _product(self, name: str, shape: str) -> str:
        """Return the definition of a new product with this shape."""
        file = self.file
        frame = file.share("PRODUCT_CONTEXT", self.application, "'mechanical'")
        product = file.add(f"PRODUCT({text(name)},{text(name)},'',({frame}))")
        file.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))")
        version = file.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        stage = file.add(
            f"PRODUCT_DEFINITION_CONTEXT('part definition',{self.application},'design')"
        )
        definition = file.add(f"PRODUCT_DEFINITION('design','',{version},{stage})")
        drawn = file.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        file.add(f"SHAPE_DEFINITION_REPRESENTATION({drawn},{shape})")
        return definition

    def _colour(self, solids: list[str], colour: Colour) -> None:
        add = self.file.add
        rgb = add(f"COLOUR_RGB('',{','.join(f'{part:.6f}' for part in colour)})")
        inside = add(f"FILL_AREA_STYLE_COLOUR('',{rgb})")
        area = add(f"FILL_AREA_STYLE('',({inside}))")
        face = add(f"SURFACE_STYLE_FILL_AREA({area})")
        side = add(f"SURFACE_SIDE_STYLE('',({face}))")
        usage = add(f"SURFACE_STYLE_USAGE(.BOTH.,{side})")
        style = add(f"PRESENTATION_STYLE_ASSIGNMENT(({usage}))")
        styled = [add(f"STYLED_ITEM('',({style}),{solid})") for solid in solids]
        add(
            "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',"
            f"({','.join(styled)}),{self.context})"
        )
