"""A job's film printed again with more or less resin, whatever kind of film it is."""

from collections.abc import Mapping
from dataclasses import fields
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.pipeline.confidence.variant import RESIN, TONE, Variants
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.kind.base import Reprint
from mpfcad.pipeline.plan.plan import Plan


class Reprints(Variants):
    """The scenes of a job with the resin changed of each place that its print sets."""

    @classmethod
    def of(cls, variants: Variants) -> "Reprints":
        """Return the same scenes."""
        return cls(**{field.name: getattr(variants, field.name) for field in fields(variants)})

    @property
    def _job(self) -> Plan:
        assert isinstance(self.plan, Plan)  # what is printed again is a job's film
        return self.plan

    @cached_property
    def _reprint(self) -> Reprint | None:
        return kind_of(self._job.drawn, self._job.job.cad).reprint(self._job.piece)

    @property
    def has_grooves(self) -> bool:
        """Whether the print sets the resin, and a film with other resin is made."""
        return self._reprint is not None and not self.stack.needs_prism

    @cached_property
    def _modes(self) -> NDArray[np.float64] | None:
        """What the process does not know of ln(fill) of the film's places, (k, n)."""
        process, again = self.plan.process, self._reprint
        if process is None or again is None:
            return None
        modes = process.fill_modes(process.aperture_ratio_of_curvature(again.places.ravel()))
        return None if modes is None else modes[:2]

    def _film(self, change: Mapping[str, float]) -> Path | None:
        """Return the mesh of the film as shipped, or of one that is written with other resin."""
        again = self._reprint
        if again is None or not {RESIN, TONE} & set(change):
            return super()._film(change)
        changed = again.film(self.resin_factor(change).reshape(again.places.shape))
        path = self.changed_file()
        kind_of(changed, self._job.job.cad).write(path, self._job.job.name)
        return path
