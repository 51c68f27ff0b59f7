"""Conductance of contacts: closed forms, published values, other roads, and what is refused."""

import numpy as np
import pytest
import xarray as xr

import flatpunch as fp
from flatpunch import bem
from flatpunch.conduction import _kernel, _stacks
from flatpunch.reference.layers import small_contact_resistance

COATED = fp.Medium([fp.Layer(1.0, 0.3, 1.0)], base=fp.HalfSpace(4.0, 0.3))
PLAIN = fp.HalfSpace(2.0, 0.3)
STAR = 2.0 / 0.91


def of_discs(medium, radius, conductivity):
    return fp.conductance(medium, radius, conductivity=conductivity).conductance.values


def test_disc_on_a_half_space_conducts_four_times_its_radius():
    assert of_discs(PLAIN, [0.0, 0.1, 3.0], [5.0]) == pytest.approx([0.0, 2.0, 60.0], rel=1e-14)


# resistance times 4 lambda_1 a, calculated independently by the dual integral equations
SPREADING = {
    0.1: [0.96202, 0.81870, 0.67620, 0.50135, 0.30765],
    2.0: [1.02578, 1.12483, 1.23056, 1.38004, 1.59289],
    10.0: [1.10843, 1.53120, 2.00930, 2.77615, 4.19526],
}


@pytest.mark.parametrize("ratio", SPREADING)
def test_layer_on_a_half_space_has_known_resistances(ratio):
    radius = np.array([0.1, 0.5, 1.0, 2.0, 5.0])
    found = 4 * ratio * radius / of_discs(COATED, radius, [ratio, 1.0])
    assert found == pytest.approx(SPREADING[ratio], abs=5e-6)


@pytest.mark.parametrize(
    ("upper", "lower", "resistance"), [(10, 1, 2.52713166), (1, 10, 24.90485327), (1, 100, 24.89126819)]
)
def test_small_disc_agrees_with_dryden(upper, lower, resistance):
    """Dryden 1983, a/t = 0.01, to all digits."""
    assert 1 / of_discs(COATED, 0.01, [upper, lower])[0] == pytest.approx(resistance, abs=6e-9)


def test_small_discs_on_a_layer_have_their_closed_form():
    for upper, lower, radius in ((10.0, 1.0, 1e-3), (0.3, 4.0, 1e-3), (2.0, 2.0, 1e-2)):
        closed = small_contact_resistance(radius, 1.0, upper, lower)
        assert 1 / of_discs(COATED, radius, [upper, lower])[0] == pytest.approx(closed, rel=radius**2)


@pytest.mark.parametrize("medium", [COATED, fp.TwoBodies(upper=COATED, lower=PLAIN)], ids=["one", "two"])
def test_equal_conductors_are_a_half_space(medium):
    one = [3.0, 3.0]
    conductivity = (one, [3.0]) if medium.pair else one
    assert of_discs(medium, [0.2, 7.0], conductivity) == pytest.approx(
        np.array([2.4, 84.0]) / (2 if medium.pair else 1), rel=1e-12
    )


def test_wide_disc_on_a_base_at_one_temperature_conducts_like_a_plate():
    plate = of_discs(COATED, [50.0, 100.0, 200.0], [2.0, np.inf]) / (2.0 * np.pi * np.array([50.0, 100.0, 200.0]) ** 2)
    # flux beside the disc: 1 + (4 ln 2/pi) t/a and so on
    assert (plate - 1) * [50.0, 100.0, 200.0] == pytest.approx(4 * np.log(2) / np.pi, rel=0.05)


def test_infinite_body_leaves_the_other():
    pair = fp.TwoBodies(upper=PLAIN, lower=COATED)
    assert of_discs(pair, 0.7, ([np.inf], [2.0, 5.0])) == pytest.approx(of_discs(COATED, 0.7, [2.0, 5.0]), rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_random_stacks_agree_with_boundary_elements(seed):
    """A disc of cells; its edge leaves an error of the first power of their size, which two sizes remove."""
    rng = np.random.default_rng(seed)
    layers = [fp.Layer(1.0, 0.3, t) for t in 10 ** rng.uniform(-0.7, 0.5, rng.integers(1, 6))]
    body, own = fp.Medium(layers, base=PLAIN), 10 ** rng.uniform(-1, 1, len(layers) + 1)
    found = fp.conductance(body, 1.0, conductivity=own)
    kernel, coarse = _kernel(_stacks(body, own)), []
    for n in (64, 128):
        grid = bem.Grid(nx=n, ny=n, spacing=2.0 / n)
        punch = bem.solve_punch(kernel, lambda x, y: np.hypot(x, y) <= 1.0, grid, depth=1e-3, tolerance=1e-6)
        coarse.append(punch.stiffness)
    assert found.conductance.values[0] == pytest.approx(2 * coarse[1] - coarse[0], rel=4e-3)
    assert found.error.values[0] < 1e-9


@pytest.mark.parametrize("tip", [fp.Sphere(10.0), fp.Pyramid(sides=3, inclination=0.2)], ids=["sphere", "pyramid"])
def test_incremental_stiffness_is_the_conductance_of_half_spaces(tip):
    """Barber 2003: 2 lambda S/E*, for any outline."""
    contact = fp.indent(PLAIN, tip, depth=[0.01, 0.1])
    found = fp.conductance(PLAIN, contact, conductivity=[7.0])
    assert found.conductance.values == pytest.approx(14.0 * contact.stiffness.values / STAR, rel=1e-9)
    assert np.all(found.error.values <= contact.force_error.values + 1e-11)


@pytest.mark.parametrize("membrane", [{"tension": 0.5}, {"stretching": 0.5}], ids=["tense", "stiff"])
def test_membranes_and_large_strains_change_the_outline_alone(membrane):
    gel = fp.HalfSpace(1.0, 0.5)
    held = fp.Medium([], gel, fp.Membrane(**membrane))
    contact = fp.indent(held, fp.Paraboloid(10.0), depth=0.1)
    found = fp.conductance(held, contact, conductivity=[7.0])
    assert found.conductance.values == pytest.approx(28.0 * contact.radius.values, rel=found.error.values[0])
    small, large = (fp.indent(gel, fp.Pyramid(4, 0.7), depth=0.1, finite_strain=law) for law in (None, "neo-hookean"))
    assert large.contour.values == pytest.approx(small.contour.values)
    first, second = (fp.conductance(gel, each, conductivity=[7.0]) for each in (small, large))
    assert second.conductance.values == pytest.approx(first.conductance.values, rel=second.error.values[0])


@pytest.mark.long
def test_error_of_pyramids_on_layers_holds():
    contact = fp.indent(COATED, fp.Pyramid(sides=3, inclination=0.2), depth=0.2)
    found = fp.conductance(COATED, contact, conductivity=[10.0, 1.0])
    kernel, coarse = _kernel(_stacks(COATED, [10.0, 1.0])), []
    phi, contour = contact.phi.values, contact.contour.values[0]
    for n in (96, 192):
        grid = bem.Grid(nx=n, ny=n, spacing=2.05 * contour.max() / n)

        def inside(x, y):
            return np.hypot(x, y) <= np.interp(np.arctan2(y, x) % (2 * np.pi), phi, contour, period=2 * np.pi)

        coarse.append(bem.solve_punch(kernel, inside, grid, depth=1e-3, tolerance=1e-6).stiffness)
    truth = 2 * coarse[1] - coarse[0]
    assert 0.0 < found.error.values[0] < 0.03
    assert found.conductance.values[0] == pytest.approx(truth, rel=found.error.values[0])


@pytest.mark.parametrize("periodic", [True, False])
def test_rough_contacts_on_half_spaces_follow_their_stiffness(periodic):
    surface = fp.self_affine(64, 1.0, rms_slope=0.1, cut_off=8.0)
    surface = fp.Topography(surface.heights, 1.0, periodic)
    contact = fp.rough_contact(PLAIN, surface, pressure=[0.0, 0.02, 0.1], fields=True)
    found = fp.conductance(PLAIN, contact, conductivity=[7.0])
    stiffness = contact.gap_stiffness if periodic else contact.stiffness
    assert found.conductance.values == pytest.approx(14.0 * stiffness.values / STAR, rel=1e-5)
    assert np.all(found.error.values[1:] > 0)


@pytest.mark.parametrize("body", [PLAIN, COATED], ids=["half-space", "coated"])
def test_error_of_small_patches_holds(body):
    """A paraboloid on cells, anywhere between their centres and 1 to 10 of them in radius, is a disc."""
    own, rng, n = [7.0, 2.0] if body is COATED else [7.0], np.random.default_rng(11), 32
    for radius in 10 ** rng.uniform(0, 1, 12):
        x, y = np.arange(n) - n / 2 + rng.uniform(0, 1, (2, 1))
        surface = fp.Topography(-(x**2 + y[:, None] ** 2) / 2e3, 1.0, periodic=False)
        force = fp.indent(body, fp.Paraboloid(1e3), radius=radius).force
        found = fp.conductance(body, fp.rough_contact(body, surface, force=force, fields=True), conductivity=own)
        assert found.conductance.values == pytest.approx(of_discs(body, radius, own), rel=found.error.values[0])


def test_layer_under_a_rough_contact_conducts_as_its_surface_where_patches_are_small():
    surface = fp.self_affine(64, 1.0, rms_slope=0.1, cut_off=4.0)
    deep = fp.Medium([fp.Layer(2.0, 0.3, 1000.0)], base=fp.HalfSpace(2.0, 0.3))
    contact = fp.rough_contact(deep, surface, pressure=0.01, fields=True)
    found = [fp.conductance(deep, contact, conductivity=[1.0, base]).conductance.values[0] for base in (0.1, 1.0, 10.0)]
    assert found == pytest.approx([found[1]] * 3, rel=1e-6)


@pytest.mark.parametrize(
    ("medium", "contact", "conductivity", "says"),
    [
        (COATED, 1.0, [1.0], "must have 2 values"),
        (COATED, 1.0, 1.0, "must be a list"),
        (COATED, 1.0, [0.0, 1.0], r"conductivity\[0\] = 0"),
        (COATED, 1.0, [np.inf, 1.0], r"conductivity\[0\] = inf"),
        (COATED, 1.0, [1.0, np.nan], r"conductivity\[1\] = nan"),
        (PLAIN, 1.0, [np.inf], "no resistance"),
        (PLAIN, -1.0, [1.0], "contact"),
        (PLAIN, "far", [1.0], "contact"),
        (PLAIN, None, [1.0], "contact"),
        (PLAIN, 1.0, "ab", "conductivity"),
        (PLAIN, 1.0, [None], "conductivity"),
        (PLAIN, 1.0, {}, "conductivity"),
        (3.0, 1.0, [1.0], "medium"),
        (fp.TwoBodies(PLAIN, COATED), 1.0, [1.0, 2.0, 3.0], "pair"),
        (fp.FreeLayer(1.0, 0.3, 1.0), 1.0, [1.0, 2.0], "medium"),
        (COATED, 1e9, [1.0, 2.0], "radius"),
    ],
)
def test_bad_input_is_named(medium, contact, conductivity, says):
    with pytest.raises((ValueError, TypeError), match=says):
        fp.conductance(medium, contact, conductivity=conductivity)


def test_results_that_do_not_fit_are_refused():
    surface = fp.self_affine(32, 1.0, rms_slope=0.1, cut_off=8.0)
    plain = fp.rough_contact(PLAIN, surface, pressure=0.1)
    strip = fp.rough_contact(
        PLAIN, fp.Topography(surface.heights, 1.0, (True, False)), pressure=0.1, fields=True, tolerance=1e-4
    )
    for contact, medium, says in (
        (plain, PLAIN, "fields=True"),
        (plain, fp.HalfSpace(1.0, 0.2), "another body"),
        (strip, PLAIN, "one axis"),
    ):
        with pytest.raises(ValueError, match=says):
            fp.conductance(medium, contact, conductivity=[1.0])
    for other in (fp.peak_stresses(PLAIN, fp.Sphere(10.0), depth=0.1), xr.Dataset()):
        with pytest.raises(TypeError, match="result of indent or rough_contact"):
            fp.conductance(PLAIN, other, conductivity=[1.0])
