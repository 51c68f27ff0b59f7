"""A user's script as strict type checkers read it: `make types` checks it, and tests/test_user_script.py runs it.

A line with `type: ignore` is a mistake that a checker must find: strict checkers refuse ignores that nothing needs.
"""

from collections.abc import Callable

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import flatpunch as fp

gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1.2e-6)], base=fp.HalfSpace(young=70e9, poisson=0.22))

sharp: fp.Pyramid = fp.Berkovich()
worn: fp.Rounded = fp.Berkovich(tip_radius=50e-9)
flat: fp.Truncated = fp.Vickers(height_removed=20e-9)
rounded: fp.Rounded = fp.Rounded(fp.Berkovich(), radius=50e-9)
knoop: fp.Rounded = fp.Rounded(fp.Knoop(), radius=50e-9)
front: fp.FacetedPyramid = fp.AfmPyramid(np.radians(15), np.radians(25), np.radians(17.5))
cone: fp.Rounded = fp.SpheroCone(inclination=np.radians(20), radius=1e-6)
own = fp.Truncated(fp.Tilted(fp.Sphere(radius=1e-6), tilt_x=0.01), height_removed=1e-9)

curve: xr.Dataset = fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.linspace(1e-9, 1e-7, 5))
same: xr.Dataset = fp.indent(gel, fp.Sphere(radius=5e-6), force=[1e-10, 2e-10], method=fp.SecondOrder(), angles=24)
third: xr.Dataset = fp.indent(gel, fp.Sphere(radius=5e-6), radius=curve.radius, method="first-order")
sticky: xr.Dataset = fp.indent(gel, fp.Sphere(radius=5e-6), depth=1e-8, work_of_adhesion=1e-4)
creeping: xr.Dataset = fp.indent(
    fp.Medium(gel.layers, base=fp.RigidBase()),
    fp.Sphere(radius=5e-6),
    depth=[0.0, 1e-8],
    time=[0.0, 1.0],
    relaxation=fp.StandardLinearSolid(equilibrium=0.5, time=1.0),
)
field = fp.pressure(gel, fp.Sphere(radius=5e-6), 0.0, 0.0, depth=1e-8)
with_error: tuple[np.ndarray, np.ndarray] = fp.pressure(
    gel, fp.Sphere(radius=5e-6), 0.0, 0.0, depth=1e-8, return_error=True
)
stiffness: float = fp.flat_punch(gel, 1e-6).stiffness
draw: Callable[..., Axes] = fp.plot_curve

depth = np.linspace(-1e-7, 1e-7, 200)
force = np.where(depth > 0, np.interp(depth, curve.depth, curve.force, left=0.0), 0.0)
measured = fp.Curve(depth=depth, force=force)
fitted = fp.fit(measured, gel, fp.Sphere(radius=5e-6), ["layers[0].young"], baseline="none", contact=0.0)
modulus: float = fitted["layers[0].young"]


BEAD = fp.Sphere(radius=5e-6)


def mistakes() -> None:
    """Mistakes that a strict checker must find. Nobody calls this.

    Each comment names the error that its line must give: a comment without its error is an error itself, so that the test fails
    as soon as one of these mistakes passes.
    """
    fp.indent(gel, BEAD, depth=1e-8, method="fourth-ordr")  # type: ignore[call-overload]  # a method that does not exist
    fp.indent(gel, BEAD, dept=1e-8)  # type: ignore[call-overload]  # a misspelt keyword
    fp.indent(gel, BEAD, depth=1e-8, force=1e-9)  # type: ignore[call-overload]  # two controls at once
    fp.indent(gel, BEAD, depth="10 nm")  # type: ignore[arg-type]  # a text for a number
    fp.indent(gel, BEAD, depth=1e-8, time=[0.0, 1.0])  # type: ignore[call-overload]  # times without relaxation
    fp.indent([gel.layers[0]], BEAD, depth=1e-8)  # type: ignore[call-overload]  # a list for a body
    fp.fit(measured, gel, BEAD, ["layers[0].young"], basline="none")  # type: ignore[call-arg]  # a misspelt keyword
    fp.fit(measured, gel, BEAD, ["layers[0].young"], baseline="flat")  # type: ignore[arg-type]  # a baseline that does not exist
    fp.Rounded(fp.Sphere(radius=1e-6), radius=1e-7)  # type: ignore[arg-type]  # a round tip has no edges to round
    fp.Refined(rtoll=1e-3)  # type: ignore[call-arg]  # a misspelt setting
    fp.Berkovich(radius=1e-7)  # type: ignore[call-overload]  # a Berkovich tip has no radius of its own
