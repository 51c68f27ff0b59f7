"""Interfaces that yield: between a layer that sticks to what is below it and one that slides."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Annotated

import numpy as np

from flatpunch._support.checks import shown
from flatpunch._support.numbers import Checked, a_stiffness
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable

_HOW = (
    "True sticks to what lies below, False slides on it without friction, an Interface(normal=..., shear=...) yields."
)


@readable
@dataclass(frozen=True, slots=True)
class Interface(Checked):
    """Springs between the lower face of a layer and what lies below it: a weak interphase, a glue, contact at asperities.

    The traction at the interface is the stiffness times the jump of the displacement across it, without lift-off. A thin
    interphase of thickness t has normal = C33/t and shear = G/t of its material.

    Parameters
    ----------
    normal : float, optional
        Traction per jump across the interface [Pa/m], > 0; by default it does not yield.
    shear : float, optional
        Traction per jump along it [Pa/m], >= 0; by default it does not yield. 0 slides.

    Raises
    ------
    ValueError, TypeError
        If a stiffness is outside its range.

    See Also
    --------
    Layer, GradedLayer, TransverselyIsotropicLayer : Take one as `bonded`.

    Examples
    --------
    >>> glue = fp.Interface(normal=1e15, shear=3e14)
    >>> film = fp.Medium([fp.Layer(70e9, 0.22, thickness=5e-6, bonded=glue)], base=fp.HalfSpace(200e9, 0.3))
    >>> print(f"{float(fp.indent(film, fp.Sphere(50e-6), depth=1e-7).force[0]) * 1e3:.1f} mN")
    11.0 mN
    """

    normal: Annotated[float | None, a_stiffness("normal interface stiffness")] = None
    shear: Annotated[float | None, a_stiffness("shear interface stiffness", above=-inf, least=0.0)] = None

    def __post_init__(self) -> None:
        for name in ("normal", "shear"):
            value = getattr(self, name)
            if isinstance(value, (float, np.floating)) and value == inf:
                object.__setattr__(self, name, None)
        Checked.__post_init__(self)

    def __bool__(self) -> bool:
        """Whether it carries shear; otherwise it slides."""
        return self.shear != 0

    @property
    def softness(self) -> tuple[float, float]:
        """Jumps along the interface and across it per traction [m/Pa]; infinite where it slides."""
        along, across = self.shear, self.normal
        return (0.0 if along is None else 1 / along if along else inf), (0.0 if across is None else 1 / across)


def lower_face(name: str, value: object) -> bool | Interface:
    """How the lower face of a layer is attached, checked."""
    if isinstance(value, Interface):
        return value
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} = {shown(value)} must be True, False or an Interface. {_HOW}")
    return bool(value)


def in_words(bonded: bool | Interface) -> str:
    """How a lower face is attached, for tables."""
    if not isinstance(bonded, Interface):
        return "bonded" if bonded else "slides"
    normal = "" if bonded.normal is None else f"normal {text(bonded.normal, 'Pa/m')}"
    shear = "" if bonded.shear is None else "slides" if bonded.shear == 0 else f"shear {text(bonded.shear, 'Pa/m')}"
    return "springs, " + ", ".join(each for each in (normal, shear) if each) if normal or shear else "bonded"
