"""Stresses inside under rough contacts that repeat: against Westergaard, sums of waves, patches of many periods."""

import json

import numpy as np
import pytest
import xarray as xr

import flatpunch as fp
from flatpunch import kernels
from flatpunch.reference.half_space import westergaard_stresses
from support.rough_surfaces import HALF_SPACE, NU, STAR, E, H, wavy

COATING = fp.Medium([fp.Layer(3 * E, 0.25, 4e-6)], base=HALF_SPACE)
BODIES = {
    "half-space": HALF_SPACE,
    "layers on a rigid base": fp.Medium([fp.Layer(E, 0.5, 2e-6), fp.Layer(3 * E, 0.2, 3e-6)], base=fp.RigidBase()),
    "graded coating": fp.Medium([fp.GradedLayer(fp.ExponentialModulus(E, 3 * E, 3e-6), 0.3, 3e-6)], base=HALF_SPACE),
    "anisotropic": fp.Medium([fp.TransverselyIsotropicLayer(2 * E, E, 0.3, 0.2, E / 2, 3e-6)], base=HALF_SPACE),
    "power law": fp.PowerLawHalfSpace(E, 1e-6, 0.4, 0.3),
}


def pressed(pressure, periodic=(True, True)):
    """What a result of `rough_contact` holds of a pressure on cells of side H."""
    y, x = (H * (np.arange(n) - (n - 1) / 2) for n in pressure.shape)
    attributes = {"topography": json.dumps({"periodic": periodic, "spacing": H})}
    return xr.Dataset({"pressure": (("step", "y", "x"), pressure[None])}, {"y": y, "x": x}, attributes)


def waves_one_by_one(body, pressure, z, friction, direction):
    """Fluctuations of stress at the cells, shape (6, nz, ny, nx): every wave of the grid by `kernels.interior`."""
    ny, nx = pressure.shape
    amplitudes = np.fft.fft2(pressure) / pressure.size
    traction = friction * np.array([np.cos(direction), np.sin(direction), 0.0]) + [0, 0, 1]
    rows, columns = np.mgrid[:ny, :nx]
    total = np.zeros((6, len(z), ny, nx))
    for i in range(ny):
        for j in range(nx):
            # the shortest wave of an even number of cells is both of its directions, half each
            signs = [
                (i - ny, i) if 2 * i == ny else (i - ny * (2 * i > ny),),
                (j - nx, j) if 2 * j == nx else (j - nx * (2 * j > nx),),
            ]
            both = [(m, n) for m in signs[0] for n in signs[1] if m or n]
            for m, n in both:
                qx, qy = 2 * np.pi * n / (nx * H), 2 * np.pi * m / (ny * H)
                _, stress = kernels.interior(body, qx, qy, z)
                wave = amplitudes[i, j] / len(both) * np.exp(1j * H * (qx * columns + qy * rows))
                total += ((stress @ traction).T[:, :, None, None] * wave).real
    return total


@pytest.mark.parametrize("kind", BODIES)
@pytest.mark.parametrize("shape", [(6, 5), (5, 8)])
def test_sums_of_waves(kind, shape):
    """Every stress on every cell, even and odd numbers of cells, under friction in any direction."""
    body, z = BODIES[kind], np.array([0.3e-6, 1.1e-6, 2.7e-6])
    pressure = np.random.default_rng(7).random(shape)
    found = fp.rough_stresses(body, pressed(pressure), z, friction=0.4, direction=0.7, fields=True)
    planes = [int(np.argmin(np.abs(found.depth.values - depth))) for depth in z]
    mine = found.stress.values[:, planes]
    apart = mine - mine.mean(axis=(2, 3), keepdims=True)
    # panels of wavenumbers in the graded layer, splines of the power law: 1e-9
    assert apart == pytest.approx(waves_one_by_one(body, pressure, z, 0.4, 0.7), abs=3e-9)
    mean = found.stress.values.mean(axis=(2, 3)) / pressure.mean()
    assert mean[2:] == pytest.approx(
        np.tile([[-1], [-0.4 * np.sin(0.7)], [-0.4 * np.cos(0.7)], [0]], found.sizes["plane"]), abs=1e-12
    )
    assert mean[0] == pytest.approx(mean[1], abs=1e-12)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_westergaard(share, friction):
    """From a hundredth of the period down, and the largest von Mises stress within its error."""
    n = 256
    period = n * H
    full = np.pi * STAR * 1e-6 / period
    contact = fp.rough_contact(HALF_SPACE, wavy(n, n, 1e-6), pressure=share * full, fields=True)
    strip = {"wavelength": period, "half_width": period / np.pi * np.arcsin(share**0.5), "mean": share * full}
    z = period * np.array([0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0])
    found = fp.rough_stresses(HALF_SPACE, contact, z, friction=friction, fields=True)
    exact = westergaard_stresses(np.arange(n) * H, z[:, None], **strip, poisson=NU, friction=friction)
    off = np.abs(found.stress.values[:, :, 0] - exact).max(axis=(0, 2)) / float(contact.max_pressure[0])
    assert off[0] < 5e-3
    assert off[3:].max() < 2e-4
    finer = np.linspace(z[0], z[-1], 800)[:, None], np.linspace(-period / 2, period / 2, 3001)
    xx, yy, zz, _, xz, _ = westergaard_stresses(finer[1], finer[0], **strip, poisson=NU, friction=friction)
    mises = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xz**2).max()
    if np.isfinite(found.von_mises_error[0]):
        assert abs(float(found.von_mises[0]) - mises) < float(found.von_mises_error[0])


def test_westergaards_stresses_are_in_equilibrium_and_have_his_pressure():
    strip = {"wavelength": 1.0, "half_width": 0.2, "mean": 2.0, "poisson": 0.3, "friction": 0.4}
    x, z, step = np.array([0.1, 0.19, 0.37, -0.45]), np.array([[0.05], [0.4]]), 1e-5
    by_x, by_z = (
        (westergaard_stresses(x + a, z + b, **strip) - westergaard_stresses(x - a, z - b, **strip)) / (2 * step)
        for a, b in ((step, 0.0), (0.0, step))
    )
    assert by_x[0] + by_z[4] == pytest.approx(0, abs=1e-6)
    assert by_x[4] + by_z[2] == pytest.approx(0, abs=1e-6)
    x = np.linspace(-0.5, 0.5, 101)
    root = np.sqrt(np.maximum(np.sin(0.2 * np.pi) ** 2 - np.sin(np.pi * x) ** 2, 0))
    pressure = 4.0 * np.cos(np.pi * x) / np.sin(0.2 * np.pi) ** 2 * root
    inside = np.abs(np.abs(x) - 0.2) > 1e-6
    surface = westergaard_stresses(x[inside], 0.0, **strip)
    assert -surface[2] == pytest.approx(pressure[inside], abs=1e-12)
    assert -surface[4] == pytest.approx(0.4 * pressure[inside], abs=1e-12)
    deep = westergaard_stresses(0.3, 9.0, **strip)
    assert deep == pytest.approx([-6 / 7, -6 / 7, -2.0, 0, -0.8, 0], abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_patches_of_many_periods(friction):
    """Below the middle of 9 x 9 periods on a rigid base, whose ends are twelve thicknesses of the layers away."""
    body = BODIES["layers on a rigid base"]
    y, x = np.mgrid[:12, :16] * 2 * np.pi / np.array([12, 16])[:, None, None]
    smooth = 1 + np.cos(x) * np.cos(y) / 2 + np.cos(2 * x) / 3
    # values whose waves are those of uniform squares of the smooth ones
    squares = 1 + np.cos(x) * np.cos(y) / 2 * np.sinc(1 / 16) * np.sinc(1 / 12) + np.cos(2 * x) / 3 * np.sinc(2 / 16)
    z = [2.5e-6, 4e-6]
    found = fp.rough_stresses(body, pressed(squares), z, friction=friction, direction=0.4, fields=True)
    patch = fp.PatchLoad(np.tile(smooth, (9, 9)), H, center=(7.5 * H + 8 * H, 5.5 * H + 6 * H))
    # the center is that of the middle period
    first_x, first_y = patch.center[0] - 8 * H + H / 2, patch.center[1] - 6 * H + H / 2
    for column, row in ((0, 0), (3, 5)):
        exact = fp.fields(body, patch, first_x + column * H, first_y + row * H, z, friction=friction, direction=0.4)
        planes = [int(np.argmin(np.abs(found.depth.values - depth))) for depth in z]
        assert found.stress.values[:, planes, row, column] == pytest.approx(exact.stress.values, abs=5e-5)


def test_largest_stresses_are_those_of_the_planes():
    rough = fp.self_affine(64, H, rms_slope=0.1, cut_off=10 * H)
    contact = fp.rough_contact(COATING, rough, pressure=[0.01 * E, 0.02 * E], fields=True)
    strengths = [fp.Strength(yield_stress=0.1 * E, interface_tension=E), fp.Strength(shear=0.01 * E)]
    depths = np.linspace(0, 8e-6, 9)
    found = fp.rough_stresses(COATING, contact, depths, friction=0.2, strengths=strengths, fields=True)
    assert found.depth.values == pytest.approx([0, 1e-6, 2e-6, 3e-6, 4e-6, 4e-6, 5e-6, 6e-6, 7e-6, 8e-6])
    assert found.plane_layer.values.tolist() == [0] * 5 + [1] * 5
    assert found.stress.values[2, 0] == pytest.approx(-contact.pressure.values[1], abs=1e-9 * E)
    tension = np.linalg.eigvalsh(
        np.moveaxis(found.stress.values[[0, 5, 4, 5, 1, 3, 4, 3, 2]], 0, -1).reshape(-1, 64, 64, 3, 3)
    )
    for layer, planes in enumerate((slice(0, 5), slice(5, 10))):
        assert float(found.tension[layer]) == pytest.approx(tension[planes, ..., 2].max(), rel=1e-9)
        assert float(found.shear[layer]) == pytest.approx(
            (tension[planes, ..., 2] - tension[planes, ..., 0]).max() / 2, rel=1e-9
        )
    assert float(found.interface_tension[0]) == found.stress.values[2, 4].max()
    traction = np.hypot(*found.stress.values[3:5, 4])
    assert float(found.interface_shear[0]) == traction.max()
    place = found.interface_shear_place[0]
    at = found.stress.sel(x=place[0], y=place[1])[:, 4]
    assert float(np.hypot(at[3], at[4])) == traction.max()
    assert float(place[2]) == 4e-6
    assert found.factor.sel(criterion="layers[1].shear") == 0.01 * E / found.shear[1]
    assert found.factor.sel(criterion="layers[0].yield") == 0.1 * E / found.von_mises[0]
    assert found.attrs["first"] == str(found.criterion.values[int(np.argmin(found.factor.values))])
    # deeper planes give the same at those that are there
    again = fp.rough_stresses(COATING, contact, depths[::2], step=1, friction=0.2)
    assert float(again.interface_shear[0]) == traction.max()
    assert abs(float(again.shear[0] - found.shear[0])) <= float(again.shear_error[0])


def test_planes_that_do_not_enclose_the_largest_have_no_error():
    contact = fp.rough_contact(HALF_SPACE, wavy(64, 64, 1e-6), pressure=1e6, fields=True)
    shallow, enclosed = (fp.rough_stresses(HALF_SPACE, contact, np.linspace(start * H, 40 * H, 5)) for start in (8, 0))
    assert np.isnan(shallow.von_mises_error[0])
    assert float(enclosed.von_mises_error[0]) > 0
    assert np.isnan(fp.rough_stresses(HALF_SPACE, contact, [1e-6, 2e-6]).von_mises_error[0])


@pytest.mark.parametrize("side", [1, 2, 3])
def test_errors_hold_where_the_largest_stress_of_a_patch_is_between_the_surface_and_the_next_plane(side):
    pressure = np.zeros((48, 48))
    pressure[20 : 20 + side, 20 : 20 + side] = 1.0
    exact = fp.rough_stresses(HALF_SPACE, pressed(pressure), np.linspace(0, 4 * H, 40))
    for gap in (2, 3, 4, 5, 6):
        found = fp.rough_stresses(HALF_SPACE, pressed(pressure), gap * H * np.arange(5))
        for name in ("von_mises", "shear"):
            assert abs(float(found[name][0] - exact[name][0])) < float(found[f"{name}_error"][0])


def test_largest_stresses_beside_the_surface_of_a_power_law_body_have_no_error():
    pressure = np.zeros((48, 48))
    pressure[20:23, 20:23] = 1.0
    found = fp.rough_stresses(BODIES["power law"], pressed(pressure), 2 * H * np.arange(5))
    assert found.tension_place[0, 2] == pytest.approx(2 * H)
    assert np.isnan(found.tension_error[0])


SLIDING = fp.Medium([fp.Layer(E, NU, 3e-6, bonded=False)], base=HALF_SPACE)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda c: fp.rough_stresses(HALF_SPACE, pressed(np.ones((4, 4)), (True, False)), 1e-6),
            ValueError,
            "PatchLoad",
        ),
        (lambda c: fp.rough_stresses(HALF_SPACE, c.drop_vars("pressure"), 1e-6), TypeError, "fields=True"),
        (lambda c: fp.rough_stresses(HALF_SPACE, 3.0, 1e-6), TypeError, "fields=True"),
        (lambda c: fp.rough_stresses(HALF_SPACE, c, -1e-6), ValueError, "depths"),
        (lambda c: fp.rough_stresses(HALF_SPACE, c, 1e-6, step=1), ValueError, "step"),
        (lambda c: fp.rough_stresses(SLIDING, c, 1e-6, friction=0.1), ValueError, "Give friction = 0"),
        (lambda c: fp.rough_stresses(fp.FreeLayer(E, NU, 1e-6), c, 1e-6), ValueError, "lifts off"),
        (lambda c: fp.rough_stresses(fp.TwoBodies(HALF_SPACE, HALF_SPACE), c, 1e-6), TypeError, "the upper one"),
        (lambda c: fp.rough_stresses(BODIES["layers on a rigid base"], c, 6e-6), ValueError, "rigid base"),
        (
            lambda c: fp.rough_stresses(
                BODIES["layers on a rigid base"], c, 1e-6, strengths=[None, None, fp.Strength(shear=1.0)]
            ),
            ValueError,
            "no stresses",
        ),
        (
            lambda c: fp.rough_stresses(HALF_SPACE, pressed(np.ones((512, 512))), np.arange(40.0), fields=True),
            ValueError,
            "fewer depths",
        ),
    ],
)
def test_refusals(call, error, message):
    with pytest.raises(error, match=message):
        call(pressed(np.ones((4, 4))))


def test_layers_that_slide_have_stresses_without_friction():
    found = fp.rough_stresses(SLIDING, pressed(np.random.default_rng(3).random((6, 6))), [1e-6, 4e-6], fields=True)
    above, below = np.flatnonzero(found.depth.values == 3e-6)
    assert found.stress.values[3:5, above] == pytest.approx(0, abs=1e-12)
    assert found.stress.values[2, above] == pytest.approx(found.stress.values[2, below], abs=1e-12)
