"""Rough contact against closed forms (Westergaard, Hertz), a dense solver of its own, and identities."""

import numpy as np
import pytest
from scipy.optimize import nnls

import flatpunch as fp
from flatpunch.reference import layers as closed
from support.rough_surfaces import HALF_SPACE, MEDIA, NU, STAR, E, H, layer, wavy


def compliance_of(kind, k, thickness):
    """C(k) from the closed forms of `reference`, which share nothing with the recursion of the package."""
    if kind == "half-space":
        response = np.ones_like(k)
    elif kind == "rigid":
        response = closed.bonded_on_rigid(k * thickness, NU)
    else:
        response = closed.bonded_on_half_space(k * thickness, E, NU, 5 * E, 0.2)
    return 2 * response / (STAR * k)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_westergaard(share):
    """p/p* = sin^2(pi a/lambda), p* = pi E* amplitude/lambda, and his pressure; the rim is known to a cell of 512."""
    n, amplitude = 512, 2e-6
    full = np.pi * STAR * amplitude / (n * H)
    result = fp.rough_contact(HALF_SPACE, wavy(n, n, amplitude), pressure=share * full, fields=True)
    psi = np.pi * np.arange(n) / n
    edge = np.arcsin(np.sqrt(share))
    assert float(result.area_fraction[0]) == pytest.approx(2 * edge / np.pi, abs=2 / n)
    root = np.sqrt(np.maximum(np.sin(edge) ** 2 - np.sin(psi) ** 2, 0.0))
    exact = 2 * share * full * np.abs(np.cos(psi)) / np.sin(edge) ** 2 * root
    # the pressure falls like a root at the rim, within a cell of which it is off by the root of a cell
    inside = np.abs(np.cos(psi)) > np.cos(edge) + 0.02
    assert result.pressure.values[0, 0][inside] == pytest.approx(exact[inside], rel=4e-3)


@pytest.mark.parametrize("kind", MEDIA)
def test_full_contact_is_heights_over_compliance(kind):
    n, amplitude = 64, 0.5e-6
    rough = wavy(n, 32, amplitude)
    k = 2 * np.pi / (32 * H)
    swing = amplitude / compliance_of(kind, np.array([k]), 3e-6)[0]
    result = fp.rough_contact(MEDIA[kind], rough, pressure=[0.999 * swing, 1.5 * swing], fields=True)
    assert result.area_fraction.values[0] < 1
    assert result.area_fraction.values[1] == 1
    p = result.pressure.values[1, 0]
    assert p == pytest.approx(swing * (1.5 + np.cos(k * H * np.arange(n))), rel=1e-6)
    assert abs(float(result.mean_gap[1])) < 1e-15
    # half of pressure times displacement; without the mean where that is infinite
    elastic = 0.25 * swing * amplitude * rough.area
    if kind == "rigid":
        softness = 3e-6 * (1 + NU) * (1 - 2 * NU) / ((1 - NU) * E)
        elastic += 0.5 * (1.5 * swing) ** 2 * softness * rough.area
        assert float(result.depth[1]) == pytest.approx(amplitude + 1.5 * swing * softness, rel=1e-6)
        assert float(result.stiffness[1]) == pytest.approx(rough.area / softness, rel=1e-4)
    else:
        assert np.isnan(result.depth.values).all()
    assert float(result.energy[1]) == pytest.approx(elastic, rel=1e-6)


@pytest.mark.parametrize("periodic", [True, False, (True, False)])
def test_hertz_in_a_large_cell(periodic):
    """A sphere whose contact is a sixteenth of the cell; neighbours in a square lattice change the area by (a/L)^3."""
    n, radius = 256, 1e-3
    x = (np.arange(n) - (n - 1) / 2) * H
    a = 16 * H
    force = 4 / 3 * STAR * a**3 / radius
    rough = fp.Topography(-(x**2 + x[:, None] ** 2) / (2 * radius), H, periodic)
    result = fp.rough_contact(HALF_SPACE, rough, force=force, fields=True)
    assert float(result.area_fraction_corrected[0]) * rough.area == pytest.approx(np.pi * a**2, rel=0.01)
    assert float(result.pressure.max()) == pytest.approx(2 * STAR * a / (np.pi * radius), rel=0.01)
    # 2 E* a; the cells widen the punch by a few hundredths of a cell
    if periodic is False:
        # the highest cell is not at the apex
        assert float(result.depth[0]) - rough.heights.max() == pytest.approx(a**2 / radius, rel=1e-3)
        assert float(result.stiffness[0]) == pytest.approx(2 * STAR * a, rel=0.01)
    assert int(result.patches[0]) == 1
    assert float(result.largest_patch[0]) == float(result.area[0])


def dense(kind, n, thickness, uniform):
    """Matrix of displacement from pressure on n x n periodic cells, summed wave by wave."""
    q = 2 * np.pi * np.fft.fftfreq(n, H)
    i = np.arange(n)
    wave = np.exp(1j * np.outer(i * H, q))
    k = np.hypot(q[:, None], q).ravel()
    c = np.r_[uniform, compliance_of(kind, k[1:], thickness)]
    both = np.kron(wave, wave)
    return np.real(both * c @ both.conj().T) / n**2


@pytest.mark.parametrize("kind", MEDIA)
@pytest.mark.parametrize("share", [0.05, 0.4, 1.0])
def test_random_surfaces_against_a_dense_solver(kind, share):
    """Non-negative least squares of Lawson and Hanson: the pressure that presses the gap to zero wherever it is positive."""
    n = 16
    rough = fp.self_affine(n, H, rms_slope=0.1, seed=3)
    mean = share * 0.15 * STAR * 0.1
    result = fp.rough_contact(MEDIA[kind], rough, pressure=mean, fields=True, tolerance=1e-10)
    softness = 3e-6 * (1 + NU) * (1 - 2 * NU) / ((1 - NU) * E) if kind == "rigid" else 2 * n * H / (2 * np.pi * STAR)
    matrix = dense(kind, n, 3e-6, softness)
    gap0 = (rough.heights.max() - rough.heights).ravel()
    # the depth at which the mean pressure is the one asked for, known from the solution to be checked
    p = result.pressure.values[0].ravel()
    loaded = p > 0
    depth = np.mean((matrix @ p + gap0)[loaded])
    upper = np.linalg.cholesky(matrix).T
    exact, _ = nnls(upper, np.linalg.solve(upper.T, depth - gap0), maxiter=10_000)
    assert np.array_equal(exact > 1e-9 * exact.max(), loaded)
    assert p == pytest.approx(exact, abs=2e-6 * exact.max())
    assert exact.mean() == pytest.approx(mean, rel=1e-6)
    if kind == "rigid":
        assert float(result.depth[0]) == pytest.approx(depth, rel=1e-6)
        by_depth = fp.rough_contact(MEDIA[kind], rough, depth=float(result.depth[0]), tolerance=1e-10)
        assert float(by_depth.force[0]) == pytest.approx(float(result.force[0]), rel=1e-6)


@pytest.mark.parametrize("kind", MEDIA)
def test_one_direction_that_ends(kind):
    """The Green's functions of half-periodic surfaces against Fourier sums over a period 24 times as long."""
    from flatpunch.bem.grid import Grid
    from flatpunch.bem.operator.periodic import periodic_operator
    from flatpunch.compliances.response import uniform_compliance

    medium = MEDIA[kind]
    kernel, uniform = fp.compliance(medium), uniform_compliance(medium)
    nx, ny, many = 16, 12, 24
    finite = float(np.isfinite(uniform))
    operator = periodic_operator(kernel, Grid(nx, ny, H), (True, False), finite)
    turned = periodic_operator(kernel, Grid(ny, nx, H), (False, True), finite)
    # resolved by the cells: near the shortest wave both are cut off, which reaches far
    p = np.random.default_rng(0).random((ny, nx)) * np.hanning(ny + 2)[1:-1, None] ** 4
    # no net force, of which the sum over images would not converge on elastic bases
    p -= p.mean(axis=0) * (np.hanning(ny + 2)[1:-1, None] ** 4) / np.mean(np.hanning(ny + 2)[1:-1] ** 4)
    long = np.zeros((many * ny, nx))
    long[:ny] = p
    whole = periodic_operator(kernel, Grid(nx, many * ny, H), (True, True), uniform if finite else 0.0).apply(long)[:ny]
    ours = operator.apply(p)
    np.testing.assert_allclose(turned.apply(p.T).T, ours, atol=1e-12)
    # images of the dipole along y: as the square of the ratio of the lengths
    assert ours - ours.mean() == pytest.approx(whole - whole.mean(), abs=3e-4 * np.ptp(whole))
    if finite:
        assert ours == pytest.approx(whole, abs=1e-4 * np.ptp(whole))


@pytest.mark.parametrize("periodic", [True, False, (False, True)])
def test_energy_and_stiffness_are_slopes(periodic):
    """F = dU/dd and K = dF/dd, or over the mean gap on elastic bases; by central differences of 1 %."""
    rough = fp.self_affine(64, H, rms_slope=0.1, roll_off=32 * H, cut_off=8 * H, seed=1)
    rough = fp.Topography(rough.heights, H, periodic)
    for medium, name in ((layer(5e-6), "depth"), (HALF_SPACE, "mean_gap")):
        if periodic is not True and name == "mean_gap":
            continue
        p = 0.02 * STAR * 0.1 * np.array([0.99, 1.0, 1.01])
        result = fp.rough_contact(medium, rough, pressure=p, tolerance=1e-9)
        moved = np.diff(result[name].values[[0, 2]])[0] * (1 if name == "depth" else -1)
        force, energy = (np.diff(result[each].values[[0, 2]])[0] / moved for each in ("force", "energy"))
        assert energy == pytest.approx(float(result.force[1]), rel=1e-4)
        stiffness = "stiffness" if name == "depth" else "gap_stiffness"
        # cells that close within the step of 2 % add to the slope or not
        assert force == pytest.approx(float(result[stiffness][1]), rel=1e-2)


def refined(heights, times):
    """Heights at cells `times` finer, through the same waves."""
    n, m = len(heights), len(heights) * times
    waves = np.fft.fftfreq(n, 1 / n).astype(int)
    kept = np.flatnonzero(np.abs(waves) < n / 2)
    spectrum = np.zeros((m, m), dtype=complex)
    spectrum[np.ix_(waves[kept], waves[kept])] = np.fft.fft2(heights)[np.ix_(kept, kept)]
    # centres of fine cells are not those of the wide ones
    shift = np.exp(-1j * np.pi * (times - 1) / m * np.fft.fftfreq(m, 1 / m))
    return np.fft.ifft2(spectrum * shift[:, None] * shift).real * times**2


@pytest.mark.long
@pytest.mark.parametrize("cut_off", [0, 3, 4, 6, 8, 16])
@pytest.mark.parametrize("medium", [HALF_SPACE, layer(3e-6, 10 * E, base=HALF_SPACE), layer(5e-6, poisson=0.45)])
def test_errors_of_the_cells_cover_finer_cells(cut_off, medium):
    """Cells three times finer; white noise, cut off at no wave, is noted, and its largest pressure has no limit."""
    rng = np.random.default_rng(cut_off)
    for n in (32, 45):
        heights = 1e-7 * rng.standard_normal((n, n))
        if cut_off:
            seed, hurst = int(rng.integers(1000)), rng.uniform(0.2, 1)
            heights = fp.self_affine(
                n, H, hurst=hurst, rms_slope=0.05, cut_off=cut_off * H, roll_off=n / 2 * H, seed=seed
            ).heights
        rough = fp.Topography(heights, H)
        pressure = STAR * rough.rms_slope * np.array([0.01, 0.1, 0.3])
        found = fp.rough_contact(medium, rough, pressure=pressure)
        finer = fp.rough_contact(medium, fp.Topography(refined(heights, 3), H / 3), pressure=pressure)
        for name, error in (
            ("area_fraction_corrected", "area"),
            ("mean_gap", "mean_gap"),
            ("max_pressure", "max_pressure"),
        ):
            if cut_off or error != "max_pressure":
                assert (np.abs(found[name] - finer[name]) <= found[f"{error}_error"]).all()
        assert cut_off or "on cells twice as wide the area differs" in found.notes


@pytest.mark.parametrize("hardness", [None, 0.15 * STAR])
@pytest.mark.parametrize("periodic", [False, (True, False)])
def test_errors_of_the_largest_pressure_at_a_border(periodic, hardness):
    """Cells half as wide on a surface that ends: at a border the pressure has no limit but the hardness."""
    waves = fp.self_affine(32, H, rms_slope=0.05, cut_off=8 * H, roll_off=16 * H, seed=1).heights
    pressure = STAR * 0.05 * np.array([0.003, 0.1])
    found, finer = (
        fp.rough_contact(
            HALF_SPACE, fp.Topography(refined(waves, times), H / times, periodic), pressure=pressure, hardness=hardness
        )
        for times in (1, 2)
    )
    missing = np.abs(found.max_pressure - finer.max_pressure)
    assert (missing <= found.max_pressure_error).all()
    no_limit = np.isinf(found.max_pressure_error.values)
    assert no_limit[-1] == (hardness is None)
    assert not no_limit[0]


def test_pressure_of_a_step_loads_the_inside():
    rough = fp.Topography(fp.self_affine(32, H, rms_slope=0.1).heights, H, periodic=False)
    result = fp.rough_contact(layer(5e-6, 5 * E, base=HALF_SPACE), rough, force=1e-3, fields=True)
    load = fp.PatchLoad(result.pressure.values[0], rough.spacing)
    inside = fp.fields(layer(5e-6, 5 * E, base=HALF_SPACE), load, x=0.0, y=0.0, z=[1e-6, 1e-2])
    assert inside.stress.sel(component="zz").values.ravel()[0] < 0


@pytest.mark.long
@pytest.mark.parametrize(
    ("ratio", "cells", "share"), [(300, 2.5, 0.3), (1000, 1.2, 0.3), (1000, 2.5, 0.03), (0, 0.4, 0.3)]
)
def test_stiff_films_and_incompressible_layers_of_about_a_cell(ratio, cells, share):
    """Their bending and flow take many iterations; gaps and penetrations of the pressure by C(k) itself."""
    rough = fp.self_affine(128, H, rms_slope=0.1, roll_off=32 * H, cut_off=8 * H, seed=3)
    film = fp.Medium([fp.Layer(ratio * E, 0.2, cells * H)], base=HALF_SPACE) if ratio else layer(cells * H, poisson=0.5)
    full = fp.full_contact(film, rough)
    result = fp.rough_contact(film, rough, pressure=share * full.rms_pressure, fields=True)
    assert "not converged" not in result.notes
    assert result.mean_pressure.values[0] == pytest.approx(share * full.rms_pressure, rel=1e-6)
    pressure = result.pressure.values[0]
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(128, H)[:, None], np.fft.rfftfreq(128, H))
    q[0, 0] = q[0, 1]
    # the mean is free
    gap = np.fft.irfft2(np.fft.rfft2(pressure) * fp.compliance(film)(q.ravel()).reshape(q.shape)) - rough.heights
    gap -= gap[pressure > 0].mean()
    assert np.abs(gap[pressure > 0]).max() < 1e-5 * rough.rms_height
    assert gap.min() > -1e-5 * rough.rms_height


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_stiffness_of_full_contact_is_that_of_uniaxial_strain(poisson):
    """Incompressible layers on a rigid base have none of it."""
    rough = fp.self_affine(16, H, rms_height=1e-7)
    body = layer(1e-6, poisson=poisson)
    result = fp.rough_contact(body, rough, pressure=10 * fp.full_contact(body, rough).rms_pressure)
    strain = (1 + poisson) * (1 - 2 * poisson) / ((1 - poisson) * E) * 1e-6
    assert result.stiffness.values[0] == pytest.approx(rough.area / strain if strain else np.inf, rel=1e-12)


def test_energy_of_full_contact_at_any_pressure():
    """Incompressible layers on a rigid base store that of the waves alone, however large the mean pressure."""
    rough = fp.self_affine(64, H, rms_slope=0.1, roll_off=32 * H, cut_off=8 * H)
    gel = layer(5e-6, poisson=0.5)
    full = fp.full_contact(gel, rough)
    result = fp.rough_contact(gel, rough, pressure=full.rms_pressure * np.array([10.0, 1e3, 1e6]))
    assert (result.area_fraction.values == 1).all()
    assert result.energy.values == pytest.approx(full.energy * rough.area, rel=1e-9)


@pytest.mark.parametrize("kind", MEDIA)
@pytest.mark.parametrize("factor", [0.02, 50.0])
def test_errors_of_the_gap_are_relative_to_the_approach(kind, factor):
    rough = fp.self_affine(64, H, rms_slope=0.1, roll_off=32 * H, cut_off=8 * H)
    result = fp.rough_contact(MEDIA[kind], rough, pressure=factor * 0.1 * STAR, fields=True, tolerance=1e-4)
    gap, touching = result.gap.values[0], result.pressure.values[0] > 0
    approach = float((rough.heights.max() - rough.heights).mean() - result.mean_gap[0])
    assert np.abs(gap[touching]).max() / approach == pytest.approx(float(result.gap_error[0]), rel=1e-3, abs=1e-9)
    assert float(result.gap_error[0]) <= 1e-4
