"""[slip] of a case file: the friction, and what is prescribed along the surface."""

from __future__ import annotations

from pathlib import Path

from flatpunch._support.checks import positive, values
from flatpunch._support.paths import Plain
from flatpunch.files.tables.fields import Number, Table
from flatpunch.files.tables.steps import ForceSteps, LengthSteps, only_one, steps_of

_ALONG = ("tangential_force", "stick_radius", "displacement")


class SlipTable(Table):
    """[slip]: friction, and at most one of tangential_force, stick_radius and displacement."""

    friction: Number
    tangential_force: ForceSteps | None = None
    stick_radius: LengthSteps | None = None
    displacement: LengthSteps | None = None

    def build(self, folder: Path) -> Plain:
        """Return what `partial_slip` takes by name besides the normal contact."""
        found: Plain = {"friction": positive("friction", self.friction, "It is the coefficient of friction.")}
        if any(getattr(self, name) is not None for name in _ALONG):
            name, given = only_one(self, _ALONG)
            found[name] = values(name, steps_of(given))
        return found
