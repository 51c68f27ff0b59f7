"""The shipped tables against direct solutions, published and reference values, and their own promises."""

import csv
from pathlib import Path

import numpy as np
import pytest

import atlas_tables
import flatpunch as fp
from atlas_tables import FAMILIES
from flatpunch import atlas
from flatpunch.atlas.library import folder, identify
from flatpunch.compliances import compliance
from flatpunch.contact.perturbation.power_law_terms import PowerPerturbation, round_base
from flatpunch.punch.harmonics import edges_of
from flatpunch.punch.matrix import solve_round, sufficient_terms

DATA = Path(__file__).resolve().parents[1] / "data"
WITH_RESPONSES = [name for name, family in FAMILIES.items() if family.responses]


def some_parameters(family, seed):
    rng = np.random.default_rng(seed)
    return {p.name: float(p.at(rng.uniform(-1, 1))) for p in family.parameters}


@pytest.mark.long
@pytest.mark.parametrize("name", FAMILIES)
def test_keeps_its_bound_at_random_points(name):
    table = atlas.table(name)
    # points that the bound was not measured at; graded media cost most
    found = atlas_tables.verify(table, FAMILIES[name], points=25, seed=2026, workers=1)
    assert max(found.largest[q] for q in ("Kbar", "kappa_1", "kappa_2")) <= table.bound


@pytest.mark.parametrize("name", FAMILIES)
def test_bound_is_what_was_promised(name):
    # one- and two-parameter families (beta counted) to 1e-8, three-parameter ones to 1e-7
    assert atlas.table(name).bound <= (1e-8 if len(FAMILIES[name].parameters) < 2 else 1e-7)
    assert atlas.table(name).attributes["verified_points"] == 2000


def test_size_of_the_data():
    assert sum(path.stat().st_size for path in folder().glob("*.nc")) < 10e6


@pytest.mark.parametrize("name", FAMILIES)
def test_coefficients_edges_and_derivatives(name):
    family, table = FAMILIES[name], atlas.table(name)
    values = some_parameters(family, 5)
    solution, kernel = table.at(**values), compliance(family.make(**values))
    for beta in (0.02, 0.9, 12.0):
        x = np.array([beta])
        direct = solve_round(kernel, x, sufficient_terms(kernel, beta))
        flat, first, second = solution.coefficients(x)
        scale = direct.flat[0, 0]
        # coefficients are kept to the tolerance of the family, which sums keep to the bound
        n = min(flat.shape[1], direct.flat.shape[1])
        # the last terms of a slowly falling series depend on where it is cut
        n = n // 2 if kernel.graded else n
        np.testing.assert_allclose(flat[0, :n], direct.flat[0, :n], atol=10 * table.bound * scale)
        assert solution.edge_coefficient(beta) == pytest.approx(1 + np.pi * direct.edge[0, 0], rel=100 * table.bound)
        # central differences, good to the square of their step, of the table itself
        step = 1e-3
        ends = [solution.coefficients(x * np.exp(s))[0] for s in (-step, step)]
        np.testing.assert_allclose(first, (ends[1] - ends[0]) / (2 * step), atol=1e-4 * scale)
        np.testing.assert_allclose(second, (ends[1] - 2 * flat + ends[0]) / step**2, atol=1e-2 * scale)


def test_pressure_is_that_of_the_punch():
    medium = fp.Medium([fp.Layer(young=1.0, poisson=0.45, thickness=1.0)], base=fp.RigidBase())
    solution = atlas.table("bonded-layer").at(poisson=0.45)
    punch, r = fp.flat_punch(medium, 1.7), np.linspace(0, 0.99, 12)
    modulus = medium.surface_modulus
    np.testing.assert_allclose(solution.pressure(1.7, r) * modulus / 1.7, punch.pressure(1.7 * r), rtol=1e-9)


@pytest.mark.parametrize("name", WITH_RESPONSES)
@pytest.mark.parametrize("exponent", [1, 2])
def test_responses_are_those_of_perturbation_theory(name, exponent):
    family = FAMILIES[name]
    values = some_parameters(family, 7)
    solution, kernel = atlas.table(name).at(**values), compliance(family.make(**values))
    for beta in (0.05, 1.3, 8.0):
        x, orders = np.array([beta]), np.array([2, 3, 4, 6, 8, 12, 33])
        edges, base = edges_of(kernel, x, orders), round_base(kernel, exponent, x)
        outline = edges.power_edge(exponent, orders) / (base.edge * base.slope)
        stiffening = edges.stiffening(orders)
        for column, m in enumerate(orders):
            found = solution.responses(beta, int(m), exponent)
            # d'(a) holds second derivatives of the table; between the harmonics above 24 the responses are interpolated
            assert found["outline"][0] == pytest.approx(outline[0, column], rel=1e-6, abs=1e-6)
            tangent = 2 * np.pi**2 * base.edge[0, 0] ** 2 * base.slope[0, 0]
            force = (tangent * outline[0, column] ** 2 - base.excess[0, 0]) / (4 * base.force[0, 0])
            assert found["force"][0] == pytest.approx(force, rel=1e-5, abs=1e-6)
            gain = np.pi * base.edge[0, 0] ** 2 / base.flat[0, 0] * (1 + stiffening[0, column]) / 2
            assert found["stiffness"][0] == pytest.approx(gain, rel=1e-6)


@pytest.mark.parametrize("name", WITH_RESPONSES)
def test_responses_of_the_widest_contacts(name):
    family = FAMILIES[name]
    medium = family.make(**some_parameters(family, 11))
    table, kernel = compliance(atlas.tabulated(medium)).solution, compliance(medium)
    orders = np.array([2, 3, 8, 24, 41])
    for beta in (30.0, 60.0, 99.0):
        stiffening, strength = table.edges(np.array([beta]), orders, 1.0)
        edges = edges_of(kernel, np.array([beta]), orders)
        np.testing.assert_allclose(stiffening, edges.stiffening(orders), rtol=5e-6)
        np.testing.assert_allclose(strength, edges.power_edge(1.0, orders), rtol=1e-6)


def test_responses_on_the_half_space():
    # contacts a thousandth of the layer wide: R = 2/3 and chi = 5/24 for ellipses, exact Hertz; the layer is felt as beta
    found = atlas.table("sliding-layer").at().responses(1e-3, 2, 2)
    assert found["outline"][0] == pytest.approx(2 / 3, abs=2e-3)
    assert found["force"][0] == pytest.approx(5 / 24, abs=2e-3)
    with pytest.raises(ValueError, match="n = 1 and 2"):
        atlas.table("sliding-layer").at().responses(1.0, 2, 1.5)
    with pytest.raises(ValueError, match="of no indenter"):
        atlas.table("bonded-coating").at(modulus_ratio=1, dundurs_position=0.5).responses(1.0, 2, 2)


def rows(name):
    lines = (line for line in (DATA / name).read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    return list(csv.DictReader(lines))


def test_layers_on_rigid_bases_of_the_reference():
    """Recomputed by another method (Fredholm equation), self-converged to 4e-12 and printed with ten digits."""
    for row in rows("layer_on_rigid_base.csv"):
        bonded, beta = row["base"] == "bonded", float(row["beta"])
        values = {"poisson": float(row["nu"])} if bonded else {}
        table = atlas.table("bonded-layer" if bonded else "sliding-layer")
        found = [float(v) for v in table.stiffness_and_moments(beta, (1, 2, 4), **values)]
        expected = [float(row[name]) for name in ("Kbar", "kappa1", "kappa2", "kappa4")]
        assert found == pytest.approx(expected, rel=1e-9)
        # (a Kbar)' = Kbar + beta dKbar/dbeta is the square of the edge coefficient
        square = expected[0] + beta * float(row["dKbar_dbeta"])
        assert float(table.at(**values).edge_coefficient(beta)) ** 2 == pytest.approx(square, rel=1e-8)


def test_coated_half_spaces_of_the_reference():
    """Recomputed with the closed Burmister kernel to 3e-9."""
    table = atlas.table("bonded-coating")
    for row in rows("coated_half_space.csv"):
        film = fp.Layer(young=float(row["E1"]), poisson=float(row["nu1"]), thickness=1.0)
        medium = fp.Medium([film], base=fp.HalfSpace(young=float(row["E2"]), poisson=float(row["nu2"])))
        found = table.stiffness_and_moments(float(row["a_over_h"]), (1, 2), **identify(medium)[1])
        expected = [float(row[name]) for name in ("Kbar", "kappa1", "kappa2")]
        assert [float(v) for v in found] == pytest.approx(expected, rel=table.bound)


def test_hayes_1972():
    """Published stiffness of a flat punch on a bonded layer, rounded to three digits; Hayes' series fall short at large a/h."""
    table = atlas.table("bonded-layer")
    for row in rows("hayes1972_flat_punch.csv"):
        beta, poisson = float(row["a_over_h"]), float(row["nu"])
        found = float(table.stiffness_and_moments(beta, poisson=poisson)[0])
        assert found == pytest.approx(float(row["kappa_exact"]), rel=1e-8)
        if beta <= 0.6:
            assert found == pytest.approx(float(row["kappa_hayes"]), rel=1e-3)


def test_power_law_in_closed_form():
    table = atlas.table("power-law")
    beta = np.array([0.01, 1.0, 40.0])
    for grading, poisson in ((0.0, 0.3), (0.5, 0.2), (-0.3, 0.45)):
        found = table.stiffness_and_moments(beta, (1, 2), grading=grading, poisson=poisson)
        for i, b in enumerate(beta):
            punch = fp.flat_punch(fp.PowerLawHalfSpace(1.0, 1.0, grading, poisson), float(b))
            expected = (punch.normalized_stiffness, punch.moment(1), punch.moment(2))
            assert [float(f[i]) for f in found] == pytest.approx(expected, rel=1e-12)
            edge = table.edge_coefficients(beta, grading=grading, poisson=poisson)[i]
            assert edge == pytest.approx(punch.edge_coefficient, rel=1e-12)


def test_many_media_at_once_equal_one_by_one():
    rng = np.random.default_rng(9)
    for name, family in FAMILIES.items():
        table = atlas.table(name)
        beta = np.exp(rng.uniform(*np.log(table.beta_range), 12))
        values = {p.name: p.at(rng.uniform(-1, 1, 12)) for p in family.parameters}
        together = (*table.stiffness_and_moments(beta, (0.7, 2), **values), table.edge_coefficients(beta, **values))
        for i in range(12):
            one = table.at(**{k: float(v[i]) for k, v in values.items()})
            one_radius = float(beta[i])
            alone = [one.normalized_stiffness(one_radius), one.moment(one_radius, 0.7), one.moment(one_radius, 2)]
            alone.append(one.edge_coefficient(one_radius))
            # rounding of sums in another order
            assert [float(v[i]) for v in together] == pytest.approx([float(v) for v in alone], rel=1e-11)


def test_what_is_outside_is_refused():
    table = atlas.table("bonded-layer")
    with pytest.raises(ValueError, match=r"beta = 200 lies outside the table, which holds 0\.001 \.\.\. 100"):
        table.stiffness_and_moments(200.0, poisson=0.3)
    with pytest.raises(ValueError, match=r"poisson = -0\.1 lies outside"):
        table.at(poisson=-0.1)
    with pytest.raises(TypeError, match="takes poisson beside beta, not nu"):
        table.at(nu=0.3)
    with pytest.raises(ValueError, match=r"'bonded' is no table: there are .*bonded-layer"):
        atlas.table("bonded")


def test_a_pyramid_needs_no_matrix_on_a_tabulated_layer(monkeypatch):
    medium = fp.Medium([fp.Layer(young=1.0, poisson=0.4, thickness=1.0)], base=fp.RigidBase())
    tip = fp.Pyramid(sides=4, inclination=0.3)
    direct = PowerPerturbation(compliance(medium), tip, 0.0, fourth=True).at(np.array([0.3, 2.0]))[0]
    monkeypatch.setattr("flatpunch.punch.harmonics.solve_edges", None)
    monkeypatch.setattr("flatpunch.punch.family.solve_round", None)
    read = PowerPerturbation(compliance(atlas.tabulated(medium)), tip, 0.0, fourth=True).at(np.array([0.3, 2.0]))[0]
    # the fourth-order columns hold two more derivatives by ln beta
    np.testing.assert_allclose(read.x2, direct.x2, rtol=1e-7)
    np.testing.assert_allclose(read, direct, rtol=1e-4, atol=1e-6)
