"""Membranes on the surface: closed forms, cells, thin films and thin layers above them, rough surfaces, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import struve, y0

import flatpunch as fp
from flatpunch.bem.operator.influence import influence_coefficients
from flatpunch.compliances.depth import waves_at
from flatpunch.compliances.response import layered_response
from flatpunch.kernels import interior, normal_compliance, surface_compliance

GEL = fp.HalfSpace(1.0, 0.5)
E_STAR = GEL.surface_modulus
TIP = fp.Paraboloid(10.0)
TENSE = fp.Medium([], GEL, fp.Membrane(tension=0.5))
STACK = [fp.Layer(1.0, 0.3, 1.0), fp.Layer(3.0, 0.4, 0.5, bonded=False)]
K = np.geomspace(1e-3, 1e3, 50)


@pytest.mark.parametrize(("tension", "bending"), [(0.5, 0.0), (0.0, 0.3), (0.2, 0.1), (1e-6, 0.0), (1e6, 1e-6)])
def test_closed_form(tension, bending):
    """An incompressible half-space has no coupling: its stiffness and that of the membrane add up."""
    medium = fp.Medium([], GEL, fp.Membrane(tension=tension, bending=bending, stretching=3.0))
    stiffness = E_STAR * K / 2 + tension * K**2 + bending * K**4
    np.testing.assert_allclose(fp.compliance(medium, membrane=True)(K) * stiffness, 1, rtol=1e-12)
    np.testing.assert_allclose(normal_compliance(medium, K) * stiffness, 1, rtol=1e-12)


@pytest.mark.parametrize("side", [3e-3, 0.3, 30.0])
def test_influence_coefficients(side):
    """A point force on a tense surface sinks by (H0 - Y0)(r/l)/(4 T), l = 2 T/E* (Hajji 1978)."""
    tension = 0.5
    length = 2 * tension / E_STAR
    g = influence_coefficients(fp.compliance(TENSE, membrane=True), side, (40, 40))

    def green(r):
        return (struve(0, r / length) - y0(r / length)) / (4 * tension)

    def spoke(angle):
        return quad(lambda r: green(r) * r, 0, side / 2 / np.cos(angle), epsabs=0, epsrel=1e-11)[0]

    x, w = np.polynomial.legendre.leggauss(40)
    for row, column in ((0, 0), (0, 1), (3, 5), (30, 20)):
        if row == column == 0:
            exact = 8 * quad(spoke, 0, np.pi / 4, epsabs=0, epsrel=1e-10)[0]
        else:
            r = np.hypot(side * (row + x[:, None] / 2), side * (column + x / 2))
            exact = (side / 2) ** 2 * float(w @ green(r) @ w)
        assert g[row, column] == pytest.approx(exact, rel=1e-8)


@pytest.mark.parametrize("contrast", [10.0, 1e3])
def test_thin_stiff_film(contrast):
    """A film of thickness t on the surface is a membrane there, in all directions, up to t."""
    nu, k, errors = 0.3, np.geomspace(0.03, 5, 12), []
    for t in (1e-2, 1e-3):
        stretching = contrast * t / (1 - nu**2)
        membrane = fp.Membrane(0.0, stretching, contrast * t / (2 * (1 + nu)), stretching * t**2 / 12)
        film = fp.Medium([fp.Layer(contrast, nu, t), *STACK], fp.RigidBase())
        ours, exact = (
            np.diagonal(surface_compliance(each, k, 0 * k), axis1=1, axis2=2).real
            for each in (fp.Medium(STACK, fp.RigidBase(), membrane), film)
        )
        errors.append(np.abs(ours / exact - 1).max())
    assert errors[0] < 0.07
    assert errors[1] < 0.15 * errors[0]


def test_waves_below_the_surface():
    """The membrane takes its part of the traction, and the fields have the compliance of the surface."""
    membrane, k = fp.Membrane(0.7, 2.0, 0.8, 0.3), np.geomspace(0.03, 10, 20)
    for layers, base in ((STACK, fp.RigidBase()), ([], GEL), ([fp.Layer(2.0, 0.3, 1.0)], fp.HalfSpace(1.0, 0.2))):
        medium = fp.Medium(layers, base, membrane)
        waves = waves_at(medium, k, np.zeros(1), np.zeros(1, dtype=int))
        along, across, normal = membrane.stiffness(k) / k
        for (u_l, u_z, s_lz, s_zz), load in ((waves.normal[:4, :, 0], (0, -1)), (waves.shear[:4, :, 0], (1, 0))):
            np.testing.assert_allclose(s_lz - along * u_l, load[0], rtol=0, atol=1e-12)
            np.testing.assert_allclose(s_zz - normal * u_z, load[1], rtol=0, atol=1e-12)
        u_t, s_tz, _ = waves.transverse[..., 0]
        np.testing.assert_allclose(s_tz - across * u_t, 1, rtol=0, atol=1e-12)
        c, moved = surface_compliance(medium, k, 0 * k), interior(medium, k, 0 * k, 0.0)[0][:, 0]
        np.testing.assert_allclose(moved, c, rtol=0, atol=1e-11 * np.abs(c).max())
        np.testing.assert_allclose(c, np.conj(np.swapaxes(c, -1, -2)), rtol=0, atol=1e-12 * np.abs(c).max())


@pytest.mark.long
def test_tense_surface_below_a_thin_layer():
    """A layer of thickness h above the membrane takes a share h^2 of the force: the exact method comes to the cells."""
    cells = fp.indent(TENSE, TIP, depth=0.1)
    assert cells.attrs["method"] == "bem"
    forces = []
    for h in (0.02, 0.01, 0.005):
        face = fp.Interface(membrane=TENSE.membrane)
        forces.append(float(fp.indent(fp.Medium([fp.Layer(1.0, 0.5, h, face)], GEL), TIP, depth=0.1).force[0]))
    differences = np.diff(forces)
    extrapolated = forces[-1] + differences[-1] * differences[-1] / (differences[-2] - differences[-1])
    assert float(cells.force[0]) == pytest.approx(extrapolated, rel=max(float(cells.force_error[0]), 2e-5))


@pytest.mark.long
@pytest.mark.parametrize("tension", [0.05, 0.5, 5.0, 50.0])
@pytest.mark.parametrize("layers", [0, 2])
def test_reported_errors(tension, layers):
    """Forces and outlines against four times as many cells along a side; a pyramid touches along its edges alone."""
    medium = fp.Medium(STACK[:layers], GEL, fp.Membrane(tension=tension))
    for tip in (TIP, fp.Cone(0.2), fp.Pyramid(4, 0.2)):
        coarse = fp.indent(medium, tip, depth=0.1, method=fp.BoundaryElements(grid=128))
        fine = fp.indent(medium, tip, depth=0.1, method=fp.BoundaryElements(grid=512))
        assert abs(float(coarse.force[0] / fine.force[0]) - 1) <= float(coarse.force_error[0])
        if not tip.round:
            continue
        assert bool(coarse.valid[0])
        off = np.abs(coarse.contour.values - fine.contour.values).max() / float(fine.radius[0])
        assert off <= float(coarse.contour_error[0] + fine.contour_error[0])


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("layers", [0, 2])
def test_in_plane_stiffness_alone(poisson, layers):
    """Short waves have a larger modulus and no line forces: the exact methods hold, and are those of cells."""
    medium = fp.Medium(STACK[:layers], fp.HalfSpace(1.0, poisson), fp.Membrane(stretching=2.0))
    kernel = fp.compliance(medium, membrane=True)
    np.testing.assert_allclose(kernel(K), layered_response(medium, K) * 2 / (medium.surface_modulus * K), rtol=1e-10)
    exact = fp.indent(medium, TIP, depth=0.1)
    assert exact.attrs["method"] == "exact"
    assert float(fp.indent(medium, TIP, depth=0.1, method="bem").force[0]) == pytest.approx(
        float(exact.force[0]), rel=2e-5
    )


def test_rough_surface_pressed_flat():
    """All waves in contact: the pressure is the amplitude over C(k), with the stiffness of the membrane in it."""
    n, period, height = 64, 2.0, 1e-3
    x = period * np.arange(n) / n
    wave = np.tile(height * np.cos(2 * np.pi * x / period), (n, 1))
    surface = fp.Topography(wave, period / n, periodic=True)
    for layers, base in (([], GEL), (STACK, fp.RigidBase())):
        medium = fp.Medium(layers, base, fp.Membrane(tension=0.3, bending=0.02))
        k = 2 * np.pi / period
        amplitude = height / float(fp.compliance(medium, membrane=True)(k)[0])
        contact = fp.rough_contact(medium, surface, pressure=1.5 * amplitude, fields=True, tolerance=1e-9)
        pressure = contact.pressure.values[0, 0]
        np.testing.assert_allclose(pressure, amplitude * (1.5 + np.cos(k * x)), rtol=0, atol=1e-5 * amplitude)
        assert fp.full_contact(medium, surface).rms_pressure == pytest.approx(amplitude / np.sqrt(2), rel=1e-6)


@pytest.mark.long
def test_two_bodies_and_gradings():
    """Compliances of two surfaces add up; a graded top is the one that many layers approach."""
    pair = fp.TwoBodies(upper=TENSE, lower=fp.HalfSpace(2.0, 0.3))
    both = fp.compliance(pair, membrane=True)
    np.testing.assert_allclose(
        both(K), fp.compliance(TENSE, membrane=True)(K) + fp.compliance(fp.HalfSpace(2.0, 0.3))(K), rtol=1e-12
    )
    assert both.limit == pytest.approx(both.modulus / fp.HalfSpace(2.0, 0.3).surface_modulus)
    graded = fp.Medium([fp.GradedLayer(fp.LinearModulus(1.0, 3.0, 1.0), 0.4, 1.0)], GEL, TENSE.membrane)
    plain = fp.Medium(graded.layers, GEL)
    k = np.geomspace(0.01, 100, 8)
    normal, own = fp.compliance(plain)(k), fp.compliance(graded, membrane=True)(k)
    # without in-plane stiffness the membrane is a stiffness in parallel
    np.testing.assert_allclose(1 / own, 1 / normal + 0.5 * k**2, rtol=1e-9)
    assert float(fp.indent(graded, TIP, depth=0.1).force[0]) > float(fp.indent(plain, TIP, depth=0.1).force[0])


def test_a_membrane_without_stiffness_is_none():
    plain = fp.indent(GEL, TIP, depth=0.1)
    assert fp.indent(fp.Medium([], GEL, fp.Membrane()), TIP, depth=0.1).force.values == plain.force.values
    with pytest.raises(TypeError, match=r"Medium.membrane = 0.5 must be a Membrane"):
        fp.Medium([], GEL, 0.5)


REFUSED = {
    "sensitivity": lambda: fp.sensitivity(TENSE, TIP, depth=0.1),
    "fields": lambda: fp.fields(TENSE, TIP, 0.0, 0.0, 1.0, depth=0.1),
    "load": lambda: fp.fields(TENSE, fp.PatchLoad(np.ones((4, 4)), 0.1), 0.0, 0.0, 1.0),
    "energy": lambda: fp.energy_by_depth(TENSE, TIP, depth=0.1),
    "peaks": lambda: fp.peak_stresses(TENSE, TIP, depth=0.1),
    "critical load": lambda: fp.critical_load(TENSE, TIP, strengths=[fp.Strength(yield_stress=1.0)]),
    "shakedown": lambda: fp.shakedown_load(TENSE, fp.Sphere(10.0), strengths=[fp.Strength(yield_stress=1.0)]),
    "flat punch": lambda: fp.flat_punch(TENSE, 1.0),
    "compliance": lambda: fp.compliance(TENSE),
    "pull-off": lambda: fp.pull_off(TENSE, fp.Sphere(10.0), work_of_adhesion=0.1),
    "adhesion": lambda: fp.indent(TENSE, fp.Sphere(10.0), depth=0.1, work_of_adhesion=0.1),
    "adhesive pressure": lambda: fp.pressure(TENSE, fp.Sphere(10.0), 0.0, 0.0, depth=0.1, work_of_adhesion=0.1),
    "slip": lambda: fp.partial_slip(TENSE, fp.Sphere(10.0), friction=0.3, depth=0.1, stick_radius=0.1),
    "asperities": lambda: fp.asperities(TENSE, fp.Sphere(10.0), [[0, 0], [5, 0]], depth=0.1),
    "history": lambda: fp.indent(
        TENSE, fp.Sphere(10.0), depth=[0.0, 0.1], time=[0.0, 1.0], relaxation=fp.Prony([0.5], [1.0])
    ),
    "each layer": lambda: fp.indent(
        fp.Medium(STACK[:1], GEL, TENSE.membrane),
        fp.Sphere(10.0),
        depth=[0.0, 0.1],
        time=[0.0, 1.0],
        relaxation=[fp.Prony([0.5], [1.0]), None],
    ),
    "fit": lambda: fp.fit(
        fp.Curve(np.linspace(-1, 1, 50), np.maximum(np.linspace(-1, 1, 50), 0) ** 1.5), TENSE, TIP, free=["base.young"]
    ),
    "bending": lambda: fp.indent(fp.Medium([], GEL, fp.Membrane(bending=0.1)), TIP, depth=0.1),
    "exact": lambda: fp.indent(TENSE, TIP, depth=0.1, method="exact"),
    "series": lambda: fp.indent(TENSE, fp.Pyramid(4, 0.2), depth=0.1, method="second-order"),
    "refined": lambda: fp.indent(TENSE, fp.Pyramid(4, 0.2), depth=0.1, method="refined"),
    "cylinder": lambda: fp.indent(TENSE, fp.Cylinder(1.0), depth=0.1),
    "pressure": lambda: fp.pressure(TENSE, TIP, 0.0, 0.0, depth=0.1, method="exact"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_elsewhere(name):
    with pytest.raises(ValueError, match="below a layer that is thin against the contact"):
        REFUSED[name]()


def test_finite_strain_has_no_membranes():
    for medium in (TENSE, fp.Medium(STACK[:1], fp.RigidBase(), TENSE.membrane)):
        with pytest.raises(ValueError, match="finite_strain"):
            fp.indent(medium, fp.Sphere(10.0), depth=0.1, finite_strain="neo-hookean")


def test_case_file(tmp_path):
    path = tmp_path / "case.toml"
    text = """
        control = { depth = "100 nm" }
        indenter = { kind = "sphere", radius = "5 um" }
        base = { kind = "half-space", young = "1 kPa", poisson = 0.5 }
        membrane = { tension = "1 mN/m" }
        """
    path.write_text(text)
    case = fp.read_case(path)
    assert case.medium == fp.Medium([], fp.HalfSpace(1e3, 0.5), fp.Membrane(tension=1e-3))
    assert "Body      a membrane, tension 1 mN/m, on the surface" in "\n".join(fp.files.describe(case))
    assert "surface                              a membrane, tension 1 mN/m" in str(case.medium)
    for wrong in ('tension = "1 kPa"', 'tensions = "1 mN/m"', 'tension = "-1 mN/m"'):
        path.write_text(text.replace('tension = "1 mN/m"', wrong))
        with pytest.raises(fp.files.CaseError, match="membrane"):
            fp.read_case(path)
