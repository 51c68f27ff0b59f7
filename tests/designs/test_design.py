"""Designs: what they do is solved anew by the public functions; what cannot be done is said."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact.curve import Control
from flatpunch.designs.search import Problem
from flatpunch.designs.statement import variables

FILM = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
TIP = fp.Sphere(20e-6)
STIFF = fp.Target("stiffness", 50e3, force=2e-3)
YOUNG, THICKNESS = {"layers[0].young": (1e9, 9e9)}, {"layers[0].thickness": (2e-7, 5e-6)}


def solved(found, **given):
    return fp.indent(found.medium, found.indenter, angles=1, **given)


def test_stiffness_at_a_load():
    found = fp.design(FILM, TIP, vary=YOUNG, objective=STIFF, starts=2)
    assert float(solved(found, force=2e-3).stiffness[0]) == pytest.approx(50e3, rel=1e-7)
    assert found["layers[0].young"] == found.medium.layers[0].young
    assert found.values[0].start == 2e9
    assert found.before[0] == pytest.approx(float(fp.indent(FILM, TIP, force=2e-3).stiffness[0]))
    assert found.notes == ()


def test_two_numbers_for_one_value_are_not_determined():
    found = fp.design(FILM, TIP, vary=YOUNG | THICKNESS, objective=fp.Target("depth", 1e-7, force=1e-3), starts=3)
    assert float(solved(found, force=1e-3).depth[0]) == pytest.approx(1e-7, rel=1e-7)
    assert any("determines 1 combination of the 2 numbers" in note for note in found.notes)
    assert any("different designs" in note for note in found.notes)
    assert len(found.minima) == 3


def test_a_limit_is_kept_and_named_where_it_stops():
    limit = fp.Limit("depth", maximum=6e-8, force=2e-3)
    found = fp.design(FILM, TIP, vary=YOUNG | THICKNESS, objective=STIFF, limits=[limit], starts=1)
    assert float(solved(found, force=2e-3).depth[0]) <= 6e-8 * (1 + 1e-6)
    assert any("What stops it is the limit depth <= 6e-08 m" in note for note in found.notes)


def test_misfit_of_what_cannot_be_reached_is_that_of_all_points():
    impossible = fp.Target("stiffness", [50e3, 5e3], force=[1e-3, 2e-3])
    found = fp.design(FILM, TIP, vary=YOUNG, objective=impossible, starts=1)
    assert found.misfit == pytest.approx(np.sqrt(np.mean(np.log(found.achieved / found.wanted) ** 2)), rel=1e-9)


@pytest.mark.slow
def test_moduli_of_a_fine_stack_are_recovered():
    """From its force curve; on one start, as each takes tens of seconds."""
    moduli = [1.0, 1.5, 2.5, 3.0, 3.5, 4.0]
    depth, base, tip = np.geomspace(0.01, 2, 8), fp.HalfSpace(6.0, 0.3), fp.Paraboloid(1.0)
    fine = fp.Medium([fp.Layer(young, 0.3, 0.25) for young in moduli], base=base)
    force = fp.indent(fine, tip, depth=depth, angles=1).force.values
    case = fp.Medium([fp.Layer(2.0, 0.3, 0.25)] * 6, base=base)
    vary = {f"layers[{i}].young": (0.5, 10.0) for i in range(6)}
    found = fp.design(case, tip, vary=vary, objective=fp.Target("force", force, depth=depth), starts=1)
    np.testing.assert_allclose(solved(found, depth=depth).force, force, rtol=1e-6)
    # the deep layers are felt least: 1e-8 in force is 1e-3 of them
    np.testing.assert_allclose([layer.young for layer in found.medium.layers], moduli, rtol=1e-2)


@pytest.mark.long
def test_what_the_bounds_make_impossible_is_said():
    depth = np.array([0.05, 0.2, 0.8])
    wanted = fp.indent(fp.HalfSpace(1.0, 0.3), fp.Paraboloid(1.0), depth=depth, angles=1).force.values
    case = fp.Medium([fp.Layer(2.0, 0.3, 0.5)], base=fp.HalfSpace(6.0, 0.3))
    found = fp.design(
        case,
        fp.Paraboloid(1.0),
        vary={"layers[0].young": (1.5, 3.0)},
        objective=fp.Target("force", wanted, depth=depth),
    )
    assert found.values[0].at_bound == "low"
    assert any("is impossible" in note for note in found.notes)
    assert found.misfit > 0.1


@pytest.mark.long
def test_a_design_beyond_the_theory_says_so():
    """Depths below a layer on a rigid base, prescribed, and on a stiff one under the largest load."""
    gel = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.RigidBase())
    found = fp.design(gel, TIP, vary=YOUNG, objective=fp.Target("force", 1.0, depth=2e-6), starts=1)
    assert any("pressed through a layer" in note for note in found.notes)
    aim = fp.LargestLoad(fp.Strength(yield_stress=1e10))
    on_steel = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(2e14, 0.3))
    problem = Problem(variables(on_steel, TIP, YOUNG), fp.FirstOrder())
    u = problem.variables.internal(problem.variables.start)
    problem.load(u, aim)
    assert problem.limits[u.tobytes()][0] == "The load is limited by yield of layer 1."
    assert "pressed through a layer" in problem.limits[u.tobytes()][1]


def test_values_are_kept_by_what_is_asked():
    """Places that come and go, as in the search of reachable ranges: the value of one is not that of another."""
    medium = fp.HalfSpace(1e9, 0.3)
    problem = Problem(variables(medium, TIP, {"base.young": (5e8, 2e9)}), fp.FirstOrder())
    u = problem.variables.internal(problem.variables.start)
    depths = np.geomspace(1e-8, 1e-6, 20)
    found = [problem.quantity(u, Control("depth", np.array([d])), "force")[0][0] for d in depths]
    np.testing.assert_allclose(found, fp.indent(medium, TIP, depth=depths, angles=1)["force"], rtol=1e-12)
    assert problem.evaluations == 20
    assert problem.quantity(u, Control("depth", depths[:1]), "stiffness")[0][0] != found[0]


@pytest.mark.long
def test_nodes_of_a_grading():
    """Below a homogeneous surface layer, from the curve of another grading."""

    def body(top, bottom):
        graded = fp.GradedLayer(([0.0, 1.0], [top, bottom]), 0.3, 1.0)
        return fp.Medium([fp.Layer(2.0, 0.3, 0.5), graded], base=fp.RigidBase())

    depth = np.array([0.02, 0.2])
    force = fp.indent(body(1.0, 3.0), fp.Paraboloid(1.0), depth=depth, angles=1).force.values
    found = fp.design(
        body(2.0, 2.5),
        fp.Paraboloid(1.0),
        vary={"layers[1].young": (0.5, 10.0)},
        objective=fp.Target("force", force, depth=depth),
        starts=1,
    )
    np.testing.assert_allclose(found.medium.layers[1].young.entries, [1.0, 3.0], rtol=1e-4)


@pytest.mark.long
def test_profile_of_a_tip():
    """Slopes up to the contact are those of the tip whose curve is prescribed; beyond it they keep their values."""
    r = np.linspace(0, 2.5, 6)
    start, wanted = fp.RadialProfile(r, r**2 / 2), fp.RadialProfile(r, 0.3 * r**2 + 0.05 * r**3)
    gel, depth = fp.Medium([fp.Layer(1.0, 0.4, 1.0)], base=fp.RigidBase()), np.geomspace(0.05, 0.6, 5)
    force = fp.indent(gel, wanted, depth=depth, angles=1).force.values
    found = fp.design(
        gel, start, vary={"indenter.slopes": (1e-2, 5.0)}, objective=fp.Target("force", force, depth=depth), starts=1
    )
    assert (np.diff(found.indenter.f) > 0).all()
    # the slopes between points are limited, which makes the curve a function of the heights with kinks: the search ends there
    np.testing.assert_allclose(solved(found, depth=depth).force, force, rtol=2e-4)
    touched = r < 1.2
    np.testing.assert_allclose(np.array(found.indenter.f)[touched], np.array(wanted.f)[touched], rtol=1e-2)


def test_designs_of_other_tips_hold_by_boundary_elements():
    tip, film = fp.Pyramid(4, 0.3), fp.Medium([fp.Layer(2.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.25))
    method = fp.BoundaryElements(grid=48)
    found = fp.design(
        film,
        tip,
        vary={"layers[0].young": (0.5, 9.0)},
        objective=fp.Target("force", 0.3, depth=0.3),
        starts=1,
        method=method,
    )
    force = float(fp.indent(found.medium, tip, depth=0.3, method=method).force[0])
    # the sensitivity solves to a smaller tolerance
    assert force == pytest.approx(0.3, rel=1e-4)
    with pytest.raises(ValueError, match="not designed with boundary elements"):
        fp.design(film, tip, vary={"layers[0].young": (0.5, 9.0)}, objective=fp.Target("stiffness", 1.0, depth=0.3))


def test_largest_load():
    """Of a half-space the load before yield falls with the square of its modulus: the softest one bears most."""
    steel, strength = fp.HalfSpace(210e9, 0.3), fp.Strength(yield_stress=1e9)
    found = fp.design(
        steel,
        fp.Sphere(50e-6),
        vary={"base.young": (100e9, 400e9)},
        objective=fp.LargestLoad(strength),
        starts=1,
    )
    assert found.values[0].at_bound == "low"
    again = fp.critical_load(found.medium, found.indenter, strength).force
    assert found.achieved[0] == pytest.approx(again)
    assert found.achieved[0] / found.before[0] == pytest.approx(2.1**2, rel=1e-2)


@pytest.mark.long
def test_a_design_in_which_nothing_fails():
    """Beside the contact of an incompressible body there is no tension."""
    found = fp.design(
        fp.HalfSpace(1e9, 0.3),
        TIP,
        vary={"base.poisson": (0.2, 0.5)},
        objective=fp.LargestLoad(fp.Strength(tensile=1e6)),
        starts=1,
    )
    assert found["base.poisson"] == 0.5
    assert found.achieved[0] == np.inf
    assert found.notes == ("With the values found nothing fails up to the largest contact of the tip.",)
    axes = fp.plot_design(found)
    assert [bar.get_height() > 0 for bar in axes.patches] == [True, False]
    assert [text.get_text() for text in axes.texts] == ["nothing fails"]


@pytest.mark.long
def test_tips_that_fail_at_the_first_touch_are_passed_by():
    """Exponents up to one are sharp: their load is zero, and the search goes on elsewhere."""
    problem = Problem(
        variables(fp.HalfSpace(1e9, 0.3), fp.PowerLaw(2.0, 100.0), {"indenter.exponent": (0.9, 2.5)}), fp.FirstOrder()
    )
    aim = fp.LargestLoad(fp.Strength(yield_stress=1e7))
    assert problem.load(np.array([0.95]), aim) == -np.inf
    found = fp.design(
        problem.variables.medium,
        problem.variables.indenter,
        vary={"indenter.exponent": (0.9, 2.5)},
        objective=aim,
        starts=1,
    )
    assert found["indenter.exponent"] == 2.5


def test_progress_is_told():
    heard = []
    fp.design(FILM, TIP, vary=YOUNG, objective=STIFF, starts=2, progress=lambda *step: heard.append(step))
    assert heard == [(1, 2), (2, 2)]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vary": {"layers[0].yung": (1e9, 2e9)}}, r"did you mean 'layers\[0\]\.young'"),
        ({"vary": {"layers[0].young": (3e9, 9e9)}}, "starts outside its bounds"),
        ({"vary": {"layers[0].young": (9e9, 1e9)}}, "smaller one first"),
        ({"vary": {"layers[0].young": (-1e9, 9e9)}}, "must be > 0"),
        (
            {"vary": {"layers[0].poisson": (0.1, 0.9)}},
            r"the bound 0\.9 of layers\[0\]\.poisson is impossible: Layer\.poisson",
        ),
        ({"vary": {"indenter.slopes": (0.1, 1)}}, "goes with a RadialProfile"),
        ({"vary": {}}, "must name the numbers"),
        ({"objective": "weight"}, "must be a Target"),
        ({"limits": ["thin"]}, "must be a list of Limit"),
        ({"limits": 3}, "limits = 3 must be a list of Limit"),
        ({"objective": fp.LargestLoad([None, fp.Strength(yield_stress=1e15)])}, "nothing fails in this case"),
        (
            {"limits": [fp.Limit("depth", maximum=1e-8, force=1e-3), fp.Limit("depth", minimum=2e-8, force=1e-3)]},
            "exclude each other",
        ),
        (
            {"limits": [fp.Limit("depth", maximum=1e-9, force=2e-3)], "starts": 1},
            "no values within the bounds keep depth",
        ),
    ],
)
def test_bad_input(change, message):
    with pytest.raises((ValueError, TypeError), match=message):
        fp.design(FILM, TIP, **({"vary": YOUNG, "objective": STIFF} | change))


def test_a_number_without_effect_is_refused():
    """At a Poisson ratio of zero E* = E/(1 - nu^2) is stationary."""
    wanted = fp.Target("depth", 1e-8, force=1e-6)
    with pytest.raises(ValueError, match=r"base\.poisson has no effect"):
        fp.design(fp.HalfSpace(1e9, 0.0), TIP, vary={"base.poisson": (-0.1, 0.4)}, objective=wanted)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fp.Target("weight", 1.0, depth=1.0), "is no quantity of a contact"),
        (lambda: fp.Target("force", 1.0, force=1.0), "give the other"),
        (lambda: fp.Target("force", 1.0), "exactly one of depth and force"),
        (lambda: fp.Target("force", [1.0, 2.0], depth=1.0), "go together one by one"),
        (lambda: fp.Limit("depth", force=1.0), "neither minimum nor maximum"),
        (lambda: fp.Limit("depth", force=1.0, minimum=2.0, maximum=1.0), "must be below"),
    ],
)
def test_nonsense_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
