"""Partial slip: closed forms of half-spaces, published shares of the force, identities, rings of traction, and bad input."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.special import j0, j1

import flatpunch as fp
from flatpunch.compliances.tangential import radial_compliance
from flatpunch.reference.partial_slip import power_law_tip

H, MU = 1e-6, 0.4
SOFT = fp.HalfSpace(1e9, 0.3)
FILM = fp.Medium([fp.Layer(5e9, 0.3, H)], base=SOFT)
MEDIA = {
    "film": FILM,
    "rigid base": fp.Medium([fp.Layer(1e9, 0.3, H)], base=fp.RigidBase()),
    "incompressible": fp.Medium([fp.Layer(1e9, 0.5, H)], base=fp.RigidBase()),
    "half-space": SOFT,
    "stiff on soft": fp.Medium([fp.Layer(100e9, 0.3, H)], base=fp.HalfSpace(1e8, 0.4)),
    "springs": fp.Medium([fp.Layer(1e9, 0.3, H, bonded=fp.Interface(normal=2e15, shear=1e15))], base=SOFT),
    "graded": fp.Medium([fp.GradedLayer(fp.LinearModulus(1e9, 5e9, H), 0.3, H)], base=fp.HalfSpace(5e9, 0.3)),
    "graded below": fp.Medium(
        [fp.Layer(2e9, 0.3, H / 2), fp.GradedLayer(fp.ExponentialModulus(5e9, 1e9, H), 0.4, H)], base=fp.RigidBase()
    ),
    "wood": fp.Medium([fp.TransverselyIsotropicLayer(1e9, 5e9, 0.2, 0.05, 1e8, H)], base=SOFT),
    "pair": fp.TwoBodies(FILM, fp.HalfSpace(2e9, 0.4)),
}
TIPS = {"paraboloid": fp.Paraboloid(1e-4), "cone": fp.Cone(0.05), "rounded": fp.SpheroCone(0.1, radius=5e-6)}
PRINTED = 6e-6
"""Half of the last of five digits."""


@pytest.mark.parametrize(
    ("kind", "share"),
    [
        ("film", [0.98720, 0.89509, 0.62044, 0.30262]),
        ("rigid base", [0.98408, 0.87116, 0.56679, 0.26166]),
        ("incompressible", [0.98153, 0.85428, 0.53414, 0.23817]),
        ("half-space", 1 - np.array([0.25, 0.5, 0.75, 0.9]) ** 3),
    ],
)
def test_share_of_the_force_is_that_of_dense_rings(kind, share):
    """At a/h = 2, from rings of traction."""
    radius = 2 * H
    found = fp.partial_slip(
        MEDIA[kind],
        TIPS["paraboloid"],
        friction=MU,
        radius=radius,
        stick_radius=np.array([0.25, 0.5, 0.75, 0.9]) * radius,
    )
    np.testing.assert_allclose(found.tangential_force / (MU * found.force), share, rtol=0, atol=PRINTED)


@pytest.mark.parametrize("exponent", [1.0, 2.0, 3.5])
def test_half_spaces_are_cattaneo_and_mindlin(exponent):
    a, stick = 1e-6, np.array([0.0, 0.3, 0.7, 1.0])
    found = fp.partial_slip(SOFT, fp.PowerLaw(exponent, 1.0), friction=MU, radius=a, stick_radius=stick * a)
    force, depth = float(found.force[0]), float(found.depth[0])
    closed = power_law_tip(stick, exponent=exponent, force=force, depth=depth, friction=MU, poisson=0.3)
    np.testing.assert_allclose(found.tangential_force, closed.force, rtol=1e-12, atol=1e-13 * force)
    np.testing.assert_allclose(found.displacement, closed.displacement, rtol=1e-12, atol=1e-13 * depth)
    # the energy is a difference of two products
    np.testing.assert_allclose(found.dissipated_energy, closed.energy, rtol=1e-9, atol=1e-12 * force * depth)
    shear = 1e9 / 2.6
    np.testing.assert_allclose(found.lateral_stiffness, 8 * shear * stick * a / 1.7, rtol=1e-12)


def test_power_law_half_spaces_keep_the_difference_of_two_contacts():
    """F ~ a^(n + 1 + e) and d ~ a^n on E ~ z^e, whatever the direction of the load."""
    body, a, stick = fp.PowerLawHalfSpace(1e9, H, 0.4, 0.3), 1e-6, np.array([0.3, 0.7])
    found = fp.partial_slip(body, TIPS["paraboloid"], friction=MU, radius=a, stick_radius=stick * a)
    np.testing.assert_allclose(found.tangential_force / (MU * found.force), 1 - stick**3.4, rtol=1e-10)


@pytest.mark.parametrize("tip", TIPS)
@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.long if kind == "graded" else ()) for kind in MEDIA]
)
def test_what_sticks_to_the_rim_carries_no_force(kind, tip):
    """Two kernels and the surface between them meet: the tip on the moved surface has the depth and force of the tip itself."""
    a = 1.3 * H
    found = fp.partial_slip(MEDIA[kind], TIPS[tip], friction=MU, radius=a, stick_radius=[a, 0.0])
    full = found.isel(step=1)
    # what the series of the pressure leave under a graded surface
    rounding = 1e-6 if kind == "graded" else 1e-10
    assert float(found.tangential_force[0]) <= rounding * float(full.tangential_force)
    assert float(found.displacement[0]) <= rounding * float(full.displacement)
    np.testing.assert_allclose(full.tangential_force, MU * full.force, rtol=1e-12)
    # under cones, rounded or not, this film bends away
    assert bool(found.valid.all()) == (kind != "stiff on soft" or tip == "paraboloid")


@pytest.mark.parametrize("kind", ["film", "incompressible", "wood"])
def test_stiffness_and_energy_are_derivatives_of_the_loop(kind):
    """dT/ddelta, and dW = 4 (delta dT - T ddelta) of a cycle that follows Masing."""
    a, step = 2 * H, 1e-4
    stick = 0.6 * a * (1 + step * np.array([-1, 0, 1]))
    found = fp.partial_slip(MEDIA[kind], TIPS["paraboloid"], friction=MU, radius=a, stick_radius=stick)
    pulled, moved, energy = (
        np.diff(found[name].values[::2])[0] for name in ("tangential_force", "displacement", "dissipated_energy")
    )
    middle = found.isel(step=1)
    # central differences: step^2
    np.testing.assert_allclose(pulled / moved, middle.lateral_stiffness, rtol=1e-6)
    slope = 4 * (float(middle.tangential_force) * moved - float(middle.displacement) * pulled)
    np.testing.assert_allclose(energy, slope, rtol=1e-6)


def test_force_radius_and_displacement_prescribe_one_another():
    found = fp.partial_slip(FILM, TIPS["cone"], friction=MU, force=1e-4, stick_radius=np.array([0.1, 0.3, 0.45]) * 1e-6)
    for name in ("tangential_force", "displacement"):
        again = fp.partial_slip(FILM, TIPS["cone"], friction=MU, force=1e-4, **{name: found[name].values})
        # the search ends at rounding of the radius
        np.testing.assert_allclose(again.stick_radius, found.stick_radius, rtol=1e-9)
        np.testing.assert_allclose(again.dissipated_energy, found.dissipated_energy, rtol=1e-6)


def test_beyond_full_slip_the_force_is_that_of_friction():
    slid = fp.partial_slip(FILM, TIPS["paraboloid"], friction=MU, radius=2 * H, stick_radius=0.0)
    further = 3 * slid.displacement.values
    found = fp.partial_slip(FILM, TIPS["paraboloid"], friction=MU, radius=2 * H, displacement=further)
    most = MU * float(slid.force[0])
    np.testing.assert_allclose(found.tangential_force, most, rtol=1e-12)
    np.testing.assert_allclose(
        found.dissipated_energy - slid.dissipated_energy, 4 * most * (further - further / 3), rtol=1e-9
    )
    assert float(found.lateral_stiffness[0]) == float(found.stick_radius[0]) == 0


def test_full_stick_feels_the_surface_or_the_layer_alone():
    """Small contacts that of the layer's half-space, 8 G a/(2 - nu); large ones on a rigid base pi a^2 G/h."""

    def stiffness(kind, a):
        found = fp.partial_slip(MEDIA[kind], fp.Paraboloid(1.0), friction=MU, radius=a, tangential_force=0.0)
        return float(found.lateral_stiffness[0])

    shear = 1e9 / 2.6
    # the layer counts by a/h
    assert stiffness("rigid base", 1e-3 * H) == pytest.approx(8 * shear * 1e-3 * H / 1.7, rel=1e-3)
    # a rim of about a thickness is dragged along
    assert stiffness("rigid base", 30 * H) == pytest.approx(np.pi * (30 * H) ** 2 * shear / H, rel=0.08)


def test_tractions_are_those_of_slip_outside_and_add_up_to_the_force():
    a, c = 2 * H, 1.2 * H
    found = fp.partial_slip(FILM, TIPS["paraboloid"], friction=MU, radius=a, stick_radius=c, places=201)
    r, p, q = found.place.values * a, found.pressure.values[0], found.traction.values[0]
    np.testing.assert_array_equal(q[r > c], MU * p[r > c])
    assert (q <= MU * p * (1 + 1e-9)).all()
    assert (q >= 0).all()
    # trapezoids on roots of the distance to either edge
    assert 2 * np.pi * np.trapezoid(q * r, r) == pytest.approx(float(found.tangential_force[0]), rel=2e-3)


@pytest.mark.parametrize("kind", ["half-space", "film"])
def test_traction_on_the_axis_of_sharp_tips_is_a_difference_of_infinite_pressures(kind):
    """Cones: E*/2 tan(inclination) ln(a/c) on half-spaces; on films what is next to the axis."""
    a, stick = 2 * H, np.array([0.6, 0.1])
    found = fp.partial_slip(MEDIA[kind], TIPS["cone"], friction=MU, radius=a, stick_radius=stick * a, places=201)
    axis, beside = found.traction.values[:, 0], found.traction.values[:, 1]
    if kind == "half-space":
        closed = -MU * SOFT.surface_modulus / 2 * np.tan(0.05) * np.log(stick)
        np.testing.assert_allclose(axis, closed, rtol=1e-6)
    # the traction has a horizontal tangent there
    np.testing.assert_allclose(axis, beside, rtol=1e-3)


@pytest.mark.parametrize("kind", ["half-space", "film"])
def test_flat_ends_of_worn_tips_slide_as_a_whole(kind):
    """Within a flat end nothing presses; a larger contact slides at the force of friction."""
    tip = fp.Truncated(TIPS["cone"], 0.05 * H)
    found = fp.partial_slip(
        MEDIA[kind], tip, friction=MU, radius=np.array([0.5, 2.0]) * H, stick_radius=[0.0, 0.2 * H], places=3
    )
    np.testing.assert_array_equal(found.isel(step=0).traction, 0)
    assert not found.valid[0]
    assert "flat end" in found.notes
    if kind == "half-space":
        np.testing.assert_allclose(found.tangential_force[1], MU * found.force[1], rtol=1e-12)
        assert bool(found.valid[1])
        assert float(found.stick_radius[1]) == float(found.lateral_stiffness[1]) == 0


def test_tips_sharper_than_cones_slide():
    found = fp.partial_slip(FILM, fp.PowerLaw(0.8, 1e-3), friction=MU, radius=H, stick_radius=0.0)
    np.testing.assert_allclose(found.tangential_force, MU * found.force, rtol=1e-12)


def ring_traction(body, a, c, displacement, slip, rings=60):
    """Force of ring loads of uniform traction: `displacement` where r < c, the traction `slip` beyond."""
    edges = np.linspace(0, a, rings + 1)
    middle = (edges[1:] + edges[:-1]) / 2
    t, w = np.polynomial.legendre.leggauss(20)
    # panels of four radians of k a, and shorter ones where layers on soft bases respond like plates
    ends = np.concatenate([[0.0], np.geomspace(1e-6, 4.0, 24), np.arange(8.0, 60 * rings, 4.0)]) / a
    half = np.diff(ends)[:, None] / 2
    k, weight = (ends[:-1, None] + half * (1 + t)).ravel(), (half * w).ravel()
    waves = radial_compliance(body, k)
    discs = (waves.along + waves.across) / 2 * weight * edges[1:, None] * j1(np.outer(edges[1:], k))
    matrix = j0(np.outer(middle, k)) @ np.diff(discs, axis=0, prepend=0).T
    sticks = middle < c
    traction = slip(middle)
    rest = displacement - matrix[:, ~sticks] @ traction[~sticks]
    traction[sticks] = np.linalg.solve(matrix[np.ix_(sticks, sticks)], rest[sticks])
    return np.pi * np.diff(edges**2) @ traction


@pytest.mark.long
@pytest.mark.parametrize("kind", ["stiff on soft", "incompressible", "graded", "wood", "pair"])
def test_force_is_that_of_rings_of_traction(kind):
    """At the computed displacement, by collocation: C_T is all that is shared."""
    body, a, tip = MEDIA[kind], 2 * H, TIPS["paraboloid"]
    found = fp.partial_slip(body, tip, friction=MU, radius=a, stick_radius=0.5 * a)

    def slip(r):
        return MU * fp.pressure(body, tip, r, 0.0, radius=a)

    force = ring_traction(body, a, 0.5 * a, float(found.displacement[0]), slip)
    # rings of a sixtieth of the radius leave up to 1.6e-3
    assert force == pytest.approx(float(found.tangential_force[0]), rel=2e-3)


def test_slip_that_begins_in_the_middle_is_not_valid():
    """Under a very stiff film the pressure makes the surface hollow along x in the middle: the force would exceed friction."""
    stiff = fp.Medium([fp.Layer(3e12, 0.3, H)], base=SOFT)
    a = 3 * H
    found = fp.partial_slip(
        stiff, TIPS["paraboloid"], friction=MU, radius=a, stick_radius=np.array([0.9, 0.3, 0.0]) * a
    )
    np.testing.assert_array_equal(found.valid, [True, False, False])
    assert "no disc" in found.notes


@pytest.mark.long
def test_no_valid_step_has_tractions_beyond_friction():
    """On layers that bend, slip of flat-nosed tips begins in the middle, before less sticks at a larger displacement."""
    layers = [fp.Layer(0.9e9, 0.0, H), fp.Layer(0.08e9, 0.0, 1.5 * H)]
    bending, stick = fp.Medium(layers, base=fp.HalfSpace(1e9, 0.0)), np.linspace(1, 0.1, 10)
    a = 1.9 * H
    found = fp.partial_slip(
        bending, fp.PowerLaw(4.0, 1e12), friction=MU, radius=a, stick_radius=stick * a, places=21
    ).isel(place=slice(None, -1))
    beyond = (found.traction > MU * found.pressure * (1 + 1e-6)).any("place")
    assert bool(beyond.any())
    np.testing.assert_array_equal(found.valid, ~beyond)


def test_picture_is_the_cycle_whose_energy_is_reported():
    """Its area, through fifty steps."""
    a = 2 * H
    found = fp.partial_slip(FILM, TIPS["cone"], friction=MU, radius=a, stick_radius=np.linspace(1.0, 0.3, 50) * a)
    axes = fp.plot_curve(found, Figure().add_subplot())
    x, y = (np.asarray(each) for each in axes.get_lines()[0].get_data())
    # shoelace, closed, in nanometres and millinewtons or what the labels say
    area = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    first = axes.get_lines()[1].get_data()
    scale = first[0][-1] / found.displacement.values[-1] * first[1][-1] / found.tangential_force.values[-1]
    # trapezoids through fifty steps
    assert area / scale == pytest.approx(float(found.dissipated_energy[-1]), rel=2e-3)


@pytest.mark.parametrize("ending", [".nc", ".csv"])
def test_results_are_written_and_read(tmp_path, ending):
    found = fp.partial_slip(SOFT, TIPS["cone"], friction=MU, radius=H, displacement=[0.0, 1e-9])
    fp.save(found, tmp_path / f"slip{ending}")
    again = fp.load(tmp_path / f"slip{ending}")
    np.testing.assert_array_equal(again.tangential_force, found.tangential_force)
    assert again.attrs["friction"] == MU


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"tangential_force": 1.0}, "exceeds friction times the normal force"),
        ({"stick_radius": 3 * H}, "exceeds the radius of the contact"),
        ({"tangential_force": 0.0, "displacement": 0.0}, "exactly one of tangential_force"),
        ({"tangential_force": [0.0, 0.0], "radius": [H, H, H]}, "give as many, or one"),
        ({"tangential_force": 0.0, "friction": 0.0}, "coefficient of friction"),
        ({"tangential_force": 0.0, "indenter": fp.Cylinder(H)}, "flat end"),
        ({"tangential_force": 0.0, "indenter": fp.Pyramid(4, 0.3)}, "not round"),
        (
            {"tangential_force": 0.0, "medium": fp.Medium([fp.Layer(1e9, 0.3, H, bonded=False)], base=SOFT)},
            "slides without",
        ),
        ({"tangential_force": 0.0, "radius": 400 * H}, "up to 300 of them"),
        ({"tangential_force": 0.0, "medium": fp.FreeLayer(1e9, 0.3, H)}, "lifts off"),
        ({"tangential_force": 0.0, "medium": fp.PowerLawHalfSpace(1e9, H, 1.0, 0.5)}, "vanishes at the surface"),
    ],
)
def test_what_cannot_be_is_refused_by_name(change, text):
    arguments = {"medium": FILM, "indenter": TIPS["paraboloid"], "friction": MU, "radius": 2 * H}
    with pytest.raises(ValueError, match=text):
        fp.partial_slip(**{**arguments, **change})
