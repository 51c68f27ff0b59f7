"""Waves interpolated between panels of wavenumbers against those at every one of them."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliance.depth import waves_at
from flatpunch.fields.axisymmetric.layered import wavenumbers
from flatpunch.fields.axisymmetric.wave_table import waves_between

BASES = {"soft": fp.HalfSpace(1e-4, 0.5), "stiff": fp.HalfSpace(30.0, 0.2), "rigid": fp.RigidBase()}
FACES = {"bonded": True, "sliding": False, "weak spring": fp.Interface(shear=1e-4), "springs": fp.Interface(2.0, 0.3)}


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("depth", [0.0, 0.02, 0.9])
def test_panels_against_every_wavenumber(base, face, depth):
    """Within what other steps through the layer change, of the largest of each field; long waves included."""
    graded = fp.GradedLayer(fp.ExponentialModulus(1.0, 3.0, 1.0), 0.3, 1.0, bonded=FACES[face])
    medium = fp.Medium([graded, fp.Layer(0.5, 0.4, 0.5)], BASES[base])
    z, layer = np.array([depth, depth + 0.05]), np.zeros(2, dtype=int)
    k, _ = wavenumbers(36 / max(depth, 0.02), 2.0, 1.5)
    ours, exact = waves_between(medium, k, z, layer, shear=True), waves_at(medium, k, z, layer)
    # steps follow from the largest wavenumber
    other = waves_at(medium, np.append(k, 1.3 * k[-1]), z, layer)
    for name in ("normal", "shear", "transverse"):
        mine, theirs, again = getattr(ours, name), getattr(exact, name), getattr(other, name)[:, :-1]
        # displacements of sliding layers grow like 1/k: what counts in integrals over k dk is k times the field
        scale = np.abs(theirs * k[:, None]).max(axis=(1, 2), keepdims=True)
        off, steps = ((np.abs(each - theirs) * k[:, None] / scale).max(axis=(1, 2)) for each in (mine, again))
        assert (off < 2 * steps + 1e-10).all()
