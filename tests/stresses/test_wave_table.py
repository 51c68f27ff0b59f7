"""Waves interpolated between panels of wavenumbers against those at every one of them."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances.depth import waves_at
from flatpunch.stresses.axisymmetric.round_load import wavenumbers, waves_between

BASES = {"soft": fp.HalfSpace(1e-4, 0.5), "stiff": fp.HalfSpace(30.0, 0.2), "rigid": fp.RigidBase()}
FACES = {"bonded": True, "sliding": False, "weak spring": fp.Interface(shear=1e-4), "springs": fp.Interface(2.0, 0.3)}


@pytest.mark.long
@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("depth", [0.0, 0.02, 0.9])
def test_panels_against_every_wavenumber(base, face, depth):
    """Within what finer steps through the layer change, of the largest of each field; long waves included."""
    graded = fp.GradedLayer(fp.ExponentialModulus(1.0, 3.0, 1.0), 0.3, 1.0, bonded=FACES[face])
    medium = fp.Medium([graded, fp.Layer(0.5, 0.4, 0.5)], BASES[base])
    z, layer = np.array([depth, depth + 0.05]), np.zeros(2, dtype=int)
    k, _ = wavenumbers(36 / max(depth, 0.02), 2.0, 1.5)
    ours, exact = waves_between(medium, k, z, layer, shear=True), waves_at(medium, k, z, layer)
    # steps end at depths that are asked for
    cuts = np.linspace(0.0, 1.0, 31)[1:-1]
    finer = waves_at(medium, k, np.append(cuts, z), np.zeros(cuts.size + 2, dtype=int))
    for name in ("normal", "shear", "transverse"):
        mine, theirs, true = getattr(ours, name), getattr(exact, name), getattr(finer, name)[:, :, cuts.size :]
        # displacements of sliding layers grow like 1/k: what counts in integrals over k dk is k times the field
        scale = np.abs(theirs * k[:, None]).max(axis=(1, 2), keepdims=True)
        off, steps = ((np.abs(each - true) * k[:, None] / scale).max(axis=(1, 2)) for each in (mine, theirs))
        assert (off < 2 * steps + 1e-10).all()


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_tables_of_the_modulus_at_many_depths(friction):
    """Stresses along the surface bend where the modulus does: one panel in depth over the table was 1e-3 of the pressure off."""
    h = 1e-6
    table = fp.GradedLayer(fp.DepthTable((0, h / 3, h), (1e9, 3e9, 2e9)), 0.3, h)
    film, a = fp.Medium([table], base=fp.HalfSpace(0.5e9, 0.3)), 8 * h
    z = np.linspace(0, 1.2 * h, 97)
    many, few = (
        fp.fields(film, fp.Paraboloid(20e-6), 0.3 * a, 0.0, each, radius=a, friction=friction) for each in (z, z[::12])
    )
    off = np.abs(many.stress.values[:, ::12] - few.stress.values).max()
    assert off < 1e-8 * few.attrs["force"] / (np.pi * a**2)


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.Cone(0.3), fp.Truncated(fp.Cone(0.3), 0.005)], ids=["cone", "truncated"])
def test_errors_beside_the_apex(tip):
    """The pressure by its own road; errors beside an apex were not among those that were measured."""
    film = fp.Medium([fp.GradedLayer(fp.ExponentialModulus(1.0, 3.0, 0.15), 0.3, 0.15)], base=fp.HalfSpace(1.0, 0.3))
    x = np.linspace(-1.5, 1.5, 400)
    inside = fp.fields(film, tip, x, 0.0, 0.0, radius=1.0)
    p, error = fp.pressure(film, tip, x, 0.0, radius=1.0, return_error=True)
    stated = inside.attrs["stress_error"] * inside.attrs["force"] / np.pi
    off = np.abs(inside.stress.sel(component="zz").values + p)
    finite = np.isfinite(off)
    assert (off <= error + 2 * stated)[finite].all()
