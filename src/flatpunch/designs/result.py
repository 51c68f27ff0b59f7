"""What a design found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from flatpunch._support.checks import Array
from flatpunch._support.readable import readable
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body


@dataclass(frozen=True, slots=True)
class DesignedValue:
    """One varied number: its value in the case, the one found, its bounds [SI], and which bound it is at.

    Attributes
    ----------
    name, unit : str
    start, found, low, high : float
    at_bound : {"", "low", "high"}
    """

    name: str
    unit: str
    start: float
    found: float
    low: float
    high: float
    at_bound: Literal["", "low", "high"]


@dataclass(frozen=True, slots=True)
class Minimum:
    """Where one of the starts ended: its misfit, or the largest load [N], and the values in the order of the table."""

    misfit: float | None
    load: float | None
    values: tuple[float, ...]


@readable
@dataclass(frozen=True, eq=False)
class Design:
    """A designed medium and tip.

    Attributes
    ----------
    medium, indenter : object
        With the values found.
    values : tuple of DesignedValue
        The table of start, found values and active bounds.
    quantity, control : str
        What was prescribed, and at which quantity; "critical load" and "" for the largest load.
    at, wanted, achieved, before : ndarray, shape (n,)
        Depths or forces, prescribed values, those of the design and those of the case before [SI].
    misfit : float
        Root of the mean square of the relative deviations; zero for the largest load.
    minima : tuple of Minimum
        Different ends of the starts, the best first.
    notes : tuple of str
        What a user should know: bounds that stop the design, ranges that no values reach, minima that differ.
    evaluations : int
        Number of contacts or critical loads solved.

    See Also
    --------
    flatpunch.design : Makes it.
    flatpunch.plot_design : The picture.

    Examples
    --------
    >>> film = fp.Layer(young=2e9, poisson=0.4, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=70e9, poisson=0.22))
    >>> wanted = fp.Target("stiffness", 50e3, force=2e-3)
    >>> found = fp.design(film, fp.Sphere(radius=20e-6), vary={"layers[0].young": (1e9, 9e9)}, objective=wanted)
    >>> print(f"{found.medium.layers[0].young / 1e9:.2f} GPa, misfit below 1e-6: {found.misfit < 1e-6}")
    3.64 GPa, misfit below 1e-6: True
    """

    medium: Body
    indenter: Indenter
    values: tuple[DesignedValue, ...]
    quantity: str
    control: str
    at: Array
    wanted: Array
    achieved: Array
    before: Array
    misfit: float
    minima: tuple[Minimum, ...]
    notes: tuple[str, ...]
    evaluations: int

    def __getitem__(self, name: str) -> float:
        """Return the value found for a varied number [SI]."""
        for each in self.values:
            if each.name == name:
                return each.found
        raise KeyError(name)
