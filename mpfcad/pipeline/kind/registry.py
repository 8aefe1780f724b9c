"""Which kind a film is."""

from mpfcad.film import CellFilm, CellLibrary, FieldPiece, MadeFilm, PieceLibrary, PrismFilm
from mpfcad.job import CadTable
from mpfcad.pipeline.kind.base import Kind
from mpfcad.pipeline.kind.cell import Cells
from mpfcad.pipeline.kind.field import FieldGrooves
from mpfcad.pipeline.kind.groove import Grooves
from mpfcad.pipeline.kind.library import PieceGrooves
from mpfcad.pipeline.kind.made import MadeGrooves
from mpfcad.pipeline.kind.piece_cells import PieceCells
from mpfcad.pipeline.plan.made import Drawn

#: Class of the film -> its kind; another kind of film is one more line.
KINDS: dict[type, type[Kind]] = {
    PrismFilm: Grooves,
    MadeFilm: MadeGrooves,
    CellFilm: Cells,
    FieldPiece: FieldGrooves,
    PieceLibrary: PieceGrooves,
    CellLibrary: PieceCells,
}


def kind_of(film: Drawn, table: CadTable) -> Kind:
    """Return the kind of a film, drawn as the job's `[cad]` says.

    Raises
    ------
    KeyError
        for a film of no kind.
    """
    return KINDS[type(film)](film, table)
