"""All derivatives of a contact from two pressures, against differences of order eight of public results."""

from itertools import pairwise

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.media.paths import with_values
from flatpunch.sensitivities.parameters import difference, parameters
from flatpunch.sensitivities.round import _surface_change, law_change

FILM = fp.Medium([fp.Layer(2.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.25))
STACK = fp.Medium(
    [fp.Layer(2.0, 0.45, 1.0), fp.Layer(0.5, 0.1, 0.4, bonded=False), fp.Layer(10.0, 0.3, 2.0)],
    base=fp.HalfSpace(3.0, 0.25),
)
GEL = fp.Medium([fp.Layer(2.0, 0.49, 1.0)], base=fp.RigidBase())
PAIR = fp.TwoBodies(FILM, fp.Medium([fp.Layer(1.0, 0.2, 0.8)], base=fp.HalfSpace(8.0, 0.1)))
GRADED = fp.Medium(
    [fp.GradedLayer(([0.0, 0.3, 0.6, 1.0], [1.0, 2.0, 2.5, 4.0]), 0.3, 1.0)], base=fp.HalfSpace(4.0, 0.25)
)
BURIED = fp.Medium(
    [fp.Layer(2.0, 0.3, 0.5), fp.GradedLayer(fp.ExponentialModulus(1.0, 5.0, 1.0), 0.3, 0.8)], base=fp.RigidBase()
)
POWER = fp.PowerLawHalfSpace(2.0, 1.0, 0.3, 0.3)
THIN = fp.Medium([fp.Layer(60.0, 0.25, 0.02), fp.Layer(1.0, 0.45, 0.02)], base=fp.HalfSpace(20.0, 0.22))

ON_HOMOGENEOUS, ON_GRADED = 1e-8, 1e-6
"""Accuracies that `sensitivity` states, here absolute: logarithmic derivatives are of order one."""

CASES = [
    (fp.HalfSpace(2.0, 0.3), fp.Paraboloid(1.0), 0.3, ON_HOMOGENEOUS),
    (FILM, fp.Cone(0.3), 0.5, ON_HOMOGENEOUS),
    (FILM, fp.SpheroCone(0.4, 0.5), 1.5, ON_HOMOGENEOUS),
    (FILM, fp.Truncated(fp.Cone(0.3), 0.02), 0.5, ON_HOMOGENEOUS),
    (STACK, fp.Sphere(9.0), 4.0, ON_HOMOGENEOUS),
    (STACK, fp.PowerLaw(3.0, 0.2), 0.5, ON_HOMOGENEOUS),
    (GEL, fp.Paraboloid(2.0), 3.0, ON_HOMOGENEOUS),
    (THIN, fp.Cone(0.3), 0.8, ON_HOMOGENEOUS),
    (PAIR, fp.Paraboloid(2.0), 1.5, ON_HOMOGENEOUS),
    (BURIED, fp.Paraboloid(2.0), 1.5, ON_HOMOGENEOUS),
    (POWER, fp.Cone(0.3), 0.5, ON_HOMOGENEOUS),
    (fp.TwoBodies(POWER, fp.PowerLawHalfSpace(5.0, 2.0, 0.3, 0.2)), fp.Cone(0.3), 0.5, ON_HOMOGENEOUS),
    (GRADED, fp.Paraboloid(2.0), 1.0, ON_GRADED),
]


FEW = {
    GRADED: ("layers[0].young.entries[1]", "base.young"),
    BURIED: ("layers[1].young.bottom", "layers[1].thickness"),
    STACK: ("layers[0].poisson", "layers[1].thickness", "layers[2].young", "indenter.radius"),
    THIN: ("layers[0].young", "layers[1].thickness"),
    PAIR: ("upper.layers[0].young", "lower.base.poisson", "lower.layers[0].thickness", "indenter.radius"),
}
"""Parameters that are compared where others take long."""


def solved(medium, tip, **given):
    curve = fp.indent(medium, tip, method="first-order", angles=1, **given)
    return np.array([float(curve[name][0]) for name in ("force", "depth", "stiffness", "radius")])


def logarithmic(medium, tip, parameter, **given):
    """d ln of force, depth, stiffness and radius by d ln of one parameter, from public results."""

    def at(value):
        return np.log(solved(*with_values(medium, tip, {parameter.path: value}), **given))

    step = parameter.step or (2e-3 if parameter.kind == "poisson" else 1e-2 * parameter.value)
    return parameter.value * difference(at, parameter.value, step)


@pytest.mark.long
@pytest.mark.parametrize(
    ("medium", "tip", "radius", "accuracy"),
    # gradings take seconds each
    [*CASES[:-1], pytest.param(*CASES[-1], marks=pytest.mark.slow)],
    ids=[f"{type(case[1]).__name__} {i}" for i, case in enumerate(CASES)],
)
@pytest.mark.filterwarnings("ignore::flatpunch.FlatpunchWarning")
def test_against_differences_of_public_results(medium, tip, radius, accuracy):
    force, depth, _, _ = solved(medium, tip, radius=radius)
    found = fp.sensitivity(medium, tip, depth=depth)
    chosen = parameters(medium, tip)
    if medium in FEW:
        chosen = [each for each in chosen if each.path in FEW[medium]]
    for parameter in chosen:
        at = found.sel(parameter=parameter.path)
        at_depth = logarithmic(medium, tip, parameter, depth=depth)
        assert float(at.force) == pytest.approx(at_depth[0], rel=accuracy, abs=accuracy), parameter.path
        assert float(at.stiffness) == pytest.approx(at_depth[2], rel=accuracy, abs=accuracy), parameter.path
        assert float(at.radius) == pytest.approx(at_depth[3], rel=accuracy, abs=accuracy), parameter.path
        if medium not in FEW:
            at_force = logarithmic(medium, tip, parameter, force=force)
            assert float(at.depth) == pytest.approx(at_force[1], rel=accuracy, abs=accuracy), parameter.path
            assert float(at.stiffness_at_force) == pytest.approx(at_force[2], rel=accuracy, abs=accuracy), (
                parameter.path
            )
            assert float(at.radius_at_force) == pytest.approx(at_force[3], rel=accuracy, abs=accuracy), parameter.path


@pytest.mark.parametrize(
    "law",
    [fp.LinearModulus(1.0, 3.0, 1.0), fp.ExponentialModulus(2.0, 3.0, 1.0), ([0.0, 0.4, 1.0], [1.0, 2.0, 3.0])],
    ids=["linear", "exponential", "table"],
)
def test_the_surface_of_a_grading_changes_with_its_numbers(law):
    body, tip = fp.Medium([fp.GradedLayer(law, 0.3, 1.0)], base=fp.HalfSpace(4.0, 0.25)), fp.Cone(0.2)
    for parameter in parameters(body, tip):
        if parameter.path.startswith("layers[0].") and parameter.kind != "thickness":
            one, other = (
                with_values(body, tip, {parameter.path: parameter.value * factor})[0].surface_modulus
                for factor in (1 + 1e-6, 1 - 1e-6)
            )
            expected = np.log(one / other) / (2e-6 * parameter.value)
            assert _surface_change(parameter, body) == pytest.approx(expected, abs=1e-8), parameter.path


@pytest.mark.long
@pytest.mark.parametrize(("medium", "tip", "radius", "accuracy"), CASES)
@pytest.mark.filterwarnings("ignore::flatpunch.FlatpunchWarning")
def test_dimensions(medium, tip, radius, accuracy):
    """F is E times the square of a length times a function of ratios, whatever the moduli and lengths are."""
    found = fp.sensitivity(medium, tip, radius=radius)
    units = found.unit.values
    growth = float(found.contact_stiffness * found.contact_depth / found.contact_force)
    assert float(found.force.values[units == "Pa"].sum()) == pytest.approx(1.0, abs=accuracy)
    # a table has its depths as well, a power law a number with a fractional power of length
    if medium is not GRADED and tip.exponent in (None, 1, 2):
        assert float(found.force.values[units == "m"].sum()) + growth == pytest.approx(2.0, abs=accuracy)
    assert float(found.depth.values[units == "Pa"].sum()) == pytest.approx(-1 / growth, abs=accuracy)


@pytest.mark.parametrize("seed", range(3))
def test_entries_of_tables_near_kinks_of_their_cubics(seed):
    """Monotone cubics limit their slopes; however near a limit is, the sum of entries times derivatives is the law (Euler)."""
    rises = np.random.default_rng(seed).uniform(0.1, 2.0, 3)
    # the three-point slope at the lower face is cut off at zero where the last rise is a third of the one before
    rises[2] = rises[1] / 3 * (1.01 + 0.01 * seed)
    table = np.arange(4.0), np.cumsum([0.7, *rises])
    graded = fp.Medium([fp.GradedLayer(table, 0.3, 3.0)], base=fp.RigidBase())
    entries = [each for each in parameters(graded, None) if ".entries" in each.path]
    z = np.linspace(0, 3, 40)
    total = sum(each.value * law_change(each, z) for each in entries)
    np.testing.assert_allclose(total, graded.layers[0].young_at(z), rtol=1e-9)


@pytest.mark.long
def test_heights_of_a_profile_near_kinks_of_its_cubic():
    """Heights and depth together scale the force at the same contact radius."""
    r = np.linspace(0, 3, 7)
    for exponent in (1.2, 1.5, 2.2, 2.4, 2.6):
        found = fp.sensitivity(FILM, fp.RadialProfile(r, 0.2 * r**exponent), radius=1.7)
        growth = float(found.contact_stiffness * found.contact_depth / found.contact_force)
        heights = float(found.force.values[[n.startswith("indenter.f") for n in found.parameter.values]].sum())
        assert heights + growth == pytest.approx(1.0, abs=ON_HOMOGENEOUS), exponent


def test_flat_end():
    tip = fp.Cylinder(0.7)
    found = fp.sensitivity(FILM, tip, depth=0.01)
    for parameter in parameters(FILM, tip):
        wanted = logarithmic(FILM, tip, parameter, depth=0.01)
        at = found.sel(parameter=parameter.path)
        assert [float(at.force), float(at.stiffness), float(at.radius)] == pytest.approx(wanted[[0, 2, 3]], abs=1e-9)


@pytest.mark.long
def test_flat_end_on_thin_layers():
    """The square of the flat punch's pressure falls off most slowly with the wavenumber."""
    found = fp.sensitivity(THIN, fp.Cylinder(0.8), depth=0.1)
    for parameter in parameters(THIN, fp.Cylinder(0.8))[:-1]:

        def force(value, name=parameter.path):
            changed, _ = with_values(THIN, None, {name: value})
            return np.log(float(fp.indent(changed, fp.Cylinder(0.8), depth=0.1).force[0]))

        step = 2e-3 if parameter.kind == "poisson" else 1e-2 * parameter.value
        wanted = parameter.value * difference(force, parameter.value, step)
        assert float(found.force.sel(parameter=parameter.path)) == pytest.approx(wanted, abs=ON_HOMOGENEOUS), (
            parameter.path
        )


@pytest.mark.long
def test_contacts_thousands_of_times_wider_than_the_layers():
    """Only the base is felt, and all moduli together raise the force as much as they rise."""
    found = fp.sensitivity(THIN, fp.Paraboloid(1e4), radius=200.0, z=[200.0])
    assert float(found.force.values[found.unit.values == "Pa"].sum()) == pytest.approx(1.0, abs=ON_HOMOGENEOUS)
    assert float(found.force.sel(parameter="base.young")) == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize("medium", [FILM, STACK, PAIR, BURIED])
def test_depth_sensitivity_of_a_layer_is_that_of_its_modulus(medium):
    """Integrated over a layer below the first, where no short waves are needed."""
    bodies = {"upper.": medium.upper, "lower.": medium.lower} if isinstance(medium, fp.TwoBodies) else {"": medium}
    x, w = np.polynomial.legendre.leggauss(40)
    for prefix, body in bodies.items():
        if isinstance(body.base, fp.RigidBase):
            continue
        # the base: z = top + s/(1 - s)
        s = (1 + x) / 2
        z, weight = body.thickness + s / (1 - s), w / 2 / (1 - s) ** 2
        sign = -1 if prefix == "upper." else 1
        found = fp.sensitivity(medium, fp.Paraboloid(2.0), radius=1.5, z=sign * z)
        total = float(found.depth_sensitivity.values[::sign] @ weight)
        assert total == pytest.approx(float(found.force.sel(parameter=f"{prefix}base.young")), rel=1e-6)


def test_depth_sensitivity_integrates_to_one():
    """What is above 0.01 contact radii is taken as constant: it changes by per cents there."""
    x, w = np.polynomial.legendre.leggauss(16)
    edges = [0.01, 0.05, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 100.0, 1e3, 1e5]
    z = np.concatenate([(a + b) / 2 + (b - a) / 2 * x for a, b in pairwise(edges)])
    weight = np.concatenate([(b - a) / 2 * w for a, b in pairwise(edges)])
    found = fp.sensitivity(FILM, fp.Paraboloid(2.0), radius=1.0, z=z)
    near = 0.01 * float(found.depth_sensitivity[0])
    assert near + float(found.depth_sensitivity.values @ weight) == pytest.approx(1.0, abs=1e-3)


def test_default_depths_show_both_sides_of_interfaces():
    found = fp.sensitivity(STACK, fp.Paraboloid(2.0), radius=[0.5, 1.0])
    assert found.depth_sensitivity.dims == ("step", "z")
    face = found.z.values == 1.0
    assert face.sum() == 2
    assert sorted(found.layer.values[face]) == [0, 1]
    assert set(found.layer.values) == {0, 1, 2, 3}


def test_first_order_of_the_mean_profile():
    tip = fp.Pyramid(4, 0.3)
    found = fp.sensitivity(FILM, tip, depth=0.2, method="first-order")
    for parameter in parameters(FILM, tip):
        wanted = logarithmic(FILM, tip, parameter, depth=0.2)
        assert float(found.force.sel(parameter=parameter.path)) == pytest.approx(wanted[0], abs=1e-8)


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "method"),
    [(fp.Pyramid(4, 0.3), "second-order"), (fp.EllipticParaboloid(0.2, 0.5), "fourth-order")],
    ids=["pyramid", "ellipse"],
)
def test_series_against_richardson(tip, method):
    """1e-8 of the largest derivative against differences of order two extrapolated thrice, with steps of their own."""
    found = fp.sensitivity(FILM, tip, depth=0.1, method=method)
    wanted = []
    for name, value in zip(found.parameter.values, found.value.values, strict=True):
        steps = 0.03 * value / 2.0 ** np.arange(4)

        def curve(v, name=name):
            at = fp.indent(*with_values(FILM, tip, {name: v}), depth=0.1, method=method, angles=8)
            return np.log([at[n].values[0] for n in ("force", "stiffness", "radius")])

        rows = [(curve(value + h) - curve(value - h)) / (2 * h) * value for h in steps]
        for order in (2, 4, 6):
            rows = [(2**order * fine - rough) / (2**order - 1) for rough, fine in pairwise(rows)]
        wanted.append(rows[0])
    for name, column in zip(("force", "stiffness", "radius"), np.array(wanted).T, strict=True):
        np.testing.assert_allclose(found[name].values, column, atol=1e-8 * np.abs(column).max(), err_msg=name)
    moduli = [n for n in found.parameter.values if n.endswith("young")]
    assert float(found.force.sel(parameter=moduli).sum()) == pytest.approx(1, abs=1e-10)
    # at fixed force everything follows from what is known at fixed depth
    depth = -found.force * found.contact_force / found.contact_stiffness / found.contact_depth
    np.testing.assert_allclose(found.depth, depth, rtol=1e-12)
    at = fp.indent(FILM, tip, force=1.001 * float(found.contact_force), method=method, angles=8)
    same = fp.indent(
        *with_values(
            FILM, tip, {"layers[0].young": 1.001 * FILM.layers[0].young, "base.young": 1.001 * FILM.base.young}
        ),
        force=1.001 * float(found.contact_force),
        method=method,
        angles=8,
    )
    # moduli and force together: nothing but the stiffness changes
    total = float(found.stiffness_at_force.sel(parameter=moduli).sum())
    grown = float(np.log(at["stiffness"].values[0] / float(found.contact_stiffness)) / np.log(1.001))
    assert total + grown == pytest.approx(
        np.log(float(same["stiffness"].values[0] / found.contact_stiffness)) / np.log(1.001), abs=1e-3
    )
    assert any("curve, which expects its forces within" in line for line in found.attrs["notes"].splitlines())


@pytest.mark.long
def test_series_of_incompressible_layers_and_depth_sensitivity():
    """At a Poisson ratio of 1/2 the difference is taken backwards; the depth sensitivity is that of the mean profile."""
    gel = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], fp.RigidBase())
    tip = fp.Pyramid(4, 0.3)
    found = fp.sensitivity(gel, tip, depth=[0.05, 0.1], method="second-order", z=[0.2, 0.5])
    mean = fp.sensitivity(gel, tip, radius=found.contact_radius.values, method="first-order", z=[0.2, 0.5])
    np.testing.assert_allclose(found.depth_sensitivity, mean.depth_sensitivity, rtol=1e-12)
    # the first order is off by its own error of some per cent
    np.testing.assert_allclose(found.force, mean.force, rtol=0.1, atol=0.02)


@pytest.mark.long
def test_series_agree_with_boundary_elements():
    """To the error of the series, 0.3 % of the force, and of the cells, 1e-4."""
    tip = fp.Pyramid(4, 0.3)
    series = fp.sensitivity(FILM, tip, depth=0.3, method="fourth-order")
    cells = fp.sensitivity(FILM, tip, depth=0.3, method="bem")
    np.testing.assert_allclose(series.force, cells.force, atol=4e-3)


def test_every_number_of_fifty_layers_has_a_derivative():
    rng = np.random.default_rng(1)
    layers = [fp.Layer(10 ** rng.uniform(-1, 1), 0.3, 0.1) for _ in range(50)]
    found = fp.sensitivity(fp.Medium(layers, base=fp.HalfSpace(5.0, 0.25)), fp.Paraboloid(10.0), radius=1.0)
    assert found.sizes["parameter"] == 3 * 50 + 2 + 1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"depth": 0.0}, "must be > 0"),
        ({}, "exactly one"),
        ({"depth": 0.1, "z": 1e-9}, "too many wavenumbers"),
        ({"depth": 0.1, "z": -1.0}, "above the surface"),
    ],
)
def test_bad_input(given, message):
    with pytest.raises(ValueError, match=message):
        fp.sensitivity(FILM, fp.Paraboloid(2.0), **given)


def test_what_has_no_derivatives_is_refused():
    with pytest.raises(ValueError, match="which differences would multiply"):
        fp.sensitivity(FILM, fp.Pyramid(4, 0.3), depth=0.1, method="refined")
    with pytest.raises(ValueError, match="cannot control"):
        fp.sensitivity(FILM, fp.Pyramid(4, 0.3), radius=0.1)
    with pytest.raises(ValueError, match="power-law"):
        fp.sensitivity(POWER, fp.Paraboloid(1.0), depth=0.1, z=1.0)
    with pytest.raises(ValueError, match="inside the rigid base"):
        fp.sensitivity(GEL, fp.Paraboloid(1.0), depth=0.1, z=1.5)


@pytest.mark.parametrize(
    ("ratio", "error", "share"),
    [(0.01, 0.19, 0.002), (0.1, 0.16, 0.022), (0.5, 0.08, 0.085), (2.0, -0.11, 0.20), (10.0, -0.42, 0.34)],
)
def test_table_of_the_one_tenth_rule(ratio, error, share):
    """As printed on the page about AFM and nanoindentation."""
    body, tip = fp.Medium([fp.Layer(ratio, 0.3, 1.0)], fp.HalfSpace(1.0, 0.3)), fp.Cone(np.radians(19.7))
    found = fp.sensitivity(body, tip, depth=0.1)
    alone = float(fp.indent(fp.HalfSpace(ratio, 0.3), tip, depth=0.1).force[0])
    assert float(found.contact_force) / alone - 1 == pytest.approx(error, abs=0.006)
    assert float(found.force.sel(parameter="base.young")) == pytest.approx(share, rel=0.03, abs=0.0005)


def test_numbers_at_the_end_of_their_range():
    """Rounded ends that meet in the middle cannot be larger, nor the roller shorter."""
    found = fp.sensitivity(fp.HalfSpace(1.0, 0.3), fp.Roller(5.0, 4.0, end_radius=2.0), depth=0.3)
    length, end = (float(found.force.sel(parameter=f"indenter.{name}")) for name in ("length", "end_radius"))
    assert length > 0 > end


@pytest.mark.long
def test_tip_from_a_map():
    """Its heights are no numbers by name: those of the medium are left."""
    x = np.linspace(-2.0, 2.0, 21)
    film = fp.Medium([fp.Layer(10.0, 0.3, 0.5)], base=fp.HalfSpace(1.0, 0.3))
    tip = fp.HeightMap(x, x, np.hypot(x, x[:, None]) ** 2 / 4.0)
    found = fp.sensitivity(film, tip, depth=0.1)
    round_tip = fp.sensitivity(film, fp.Paraboloid(2.0), depth=0.1)
    assert found.parameter.values.tolist() == round_tip.parameter.values.tolist()[:5]
    assert found.force.values == pytest.approx(round_tip.force.values[:5], abs=1e-3)


TEXTURED = fp.TransverselyIsotropicHalfSpace(1.0, 2.0, 0.25, 0.2, 0.4)


@pytest.mark.parametrize(
    "medium",
    [
        TEXTURED,
        fp.TwoBodies(fp.RigidBase(), TEXTURED),
        fp.TwoBodies(TEXTURED, FILM),
        fp.TwoBodies(FILM, TEXTURED),
        fp.TwoBodies(TEXTURED, fp.HalfSpace(1.0, 0.3)),
    ],
    ids=["alone", "under a rigid body", "above", "below", "on a half-space"],
)
def test_every_elastic_body_has_its_own_derivatives(medium):
    """Moduli together scale the force; each by itself against a difference. Transversely isotropic half-spaces had none."""
    tip = fp.Sphere(10.0)
    found = fp.sensitivity(medium, tip, depth=0.1)
    total = 0.0
    for name, value, slope in zip(found.parameter.values.tolist(), found.value.values, found.force.values, strict=True):
        low, high = (
            float(fp.indent(*with_values(medium, tip, {name: value * (1 + s)}), depth=0.1).force[0])
            for s in (-1e-4, 1e-4)
        )
        assert slope == pytest.approx(np.log(high / low) / 2e-4, abs=1e-6)
        total += slope if "young" in name or "shear" in name else 0.0
    assert total == pytest.approx(1.0, abs=1e-7)
