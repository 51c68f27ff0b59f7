"""Drag on the cantilever: fitted where the speed of the tip changes, else refused with the remedy."""

import numpy as np
import pytest

from flatpunch import plot_fit
from flatpunch.contact import indent
from flatpunch.fits import Curve, CurveError, fit
from flatpunch.indenters import Sphere
from flatpunch.media import Layer, Medium, RigidBase, StandardLinearSolid

GEL, START = (Medium([Layer(young, 0.5, 1e-6)], RigidBase()) for young in (5e3, 2e3))
TIP, FREE = Sphere(3e-6), "layers[0].young"


def fitted(curve, **settings):
    return fit(curve, START, TIP, [FREE], quick=True, **settings).estimates[FREE]


def moving(kind, spring, drag=0.2, seed=3):
    """Gel curve with a tilt and with drag, a share of the rise at the largest speed; and the drag in N s/m."""
    depth = np.linspace(0, 4.2e-7, 1500)
    force = indent(GEL, TIP, depth=depth, angles=8)["force"].values
    along = depth if spring is None else depth + force / spring
    last = float(np.interp(4e-7, depth, along))
    way = np.linspace(-last, last, 900)
    time = np.linspace(0, 1, 900)
    if kind == "two speeds":
        time[500:] = time[500] + 3 * (time[500:] - time[500])
    if kind == "slowing down":
        time = 1 - np.sqrt(1 - 0.99 * time)
    speed = np.gradient(way, time)
    if kind == "retraction":
        way, time = np.append(way, np.linspace(last, -last, 600)), np.append(time, 1 + np.linspace(0.001, 0.5, 600))
        speed = np.append(speed, np.full(600, np.diff(way[-2:]) / np.diff(time[-2:])))
    read = np.interp(way, along, force)
    rise = read.max()
    read = read + rise * (drag * speed / speed.max() + 0.1 * (way - way[0]) / last - 2)
    read = read + 0.003 * rise * np.random.default_rng(seed).normal(size=way.size)
    curve = (
        Curve(way, read, time=time)
        if spring is None
        else Curve.from_piezo(way, read, spring_constant=spring, time=time)
    )
    return curve, drag * rise / speed.max()


@pytest.mark.parametrize("spring", [None, 0.05])
@pytest.mark.parametrize("kind", ["retraction", "two speeds", "slowing down"])
def test_drag_that_the_speed_shows(kind, spring):
    curve, drag = moving(kind, spring)
    found = fit(curve, START, TIP, [FREE], quick=True, baseline="linear", drag="free").estimates
    for name, truth in ((FREE, 5e3), ("drag", drag)):
        assert abs(found[name].value - truth) < 4 * found[name].stderr
    assert found["drag"].stderr < 0.5 * drag


@pytest.mark.parametrize("spring", [None, 0.05])
def test_drag_at_one_speed_is_a_constant(spring):
    """Refused with the remedy; given as a number, or left out, the modulus is the same."""
    curve, drag = moving("one speed", spring)
    with pytest.raises(
        CurveError, match=r"drag = 'free' cannot be fitted: the tip moves at one speed.*Give drag as a number"
    ):
        fitted(curve, baseline="linear", drag="free")
    values = [fitted(curve, baseline="linear", drag=given).value for given in (0.0, drag, -3 * drag)]
    assert np.ptp(values) < 1e-3 * 5e3
    sticking, _ = moving("retraction", spring)
    # a retraction that ends in contact shows no speed of its own
    short = sticking.taken(slice(0, 1100))
    with pytest.raises(CurveError, match="the retraction has no part without contact"):
        fitted(short, baseline="linear", drag="free")


def test_noise_of_the_position_is_no_speed():
    curve, _ = moving("one speed", None)
    shaken = Curve(
        curve.depth + 2e-10 * np.random.default_rng(1).normal(size=curve.depth.size), curve.force, time=curve.time
    )
    with pytest.raises(CurveError, match="drag = 'free' cannot be fitted"):
        fitted(shaken, baseline="linear", drag="free")


def test_a_relaxing_approach_at_one_speed_shows_no_drag():
    curve, _ = moving("one speed", None)
    with pytest.raises(CurveError, match="drag = 'free' cannot be fitted"):
        fit(curve, START, TIP, [FREE], baseline="linear", drag="free", relaxation=StandardLinearSolid(0.5, 0.3))


def test_each_way_of_the_tip_has_its_line():
    """Drag lifts the approach and lowers the retraction: a line through both in order of depth would fill the picture."""
    curve, _ = moving("retraction", 0.05)
    found = fit(curve, START, TIP, [FREE], quick=True, baseline="linear", drag="free")
    lines = [line for line in plot_fit(found).get_lines() if line.get_linestyle() == "-"]
    drawn = [np.array([line.get_xdata(), line.get_ydata()]) for line in lines if len(line.get_xdata()) > 2]
    assert len(drawn) == 2
    for _, force in drawn:
        assert np.abs(np.diff(force)).max() < 0.05 * np.ptp(drawn[0][1])
