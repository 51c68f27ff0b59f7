"""The error of partial slip, against friction in all directions on cells."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import kernels

H, MU, CELLS = 1e-6, 0.3, 48
TIP = fp.Paraboloid(1e-4)


def forces_on_cells(body, a, displacements, *, along):
    """T/(mu F) of the least energy with |traction| <= mu p in each cell; `along` has round tractions' mean response alone."""
    spacing, size = 2.2 * a / CELLS, 4 * CELLS
    x = (np.arange(CELLS) - (CELLS - 1) / 2) * spacing
    most = MU * fp.pressure(body, TIP, x[:, None], x, radius=a)
    q = 2 * np.pi * np.fft.fftfreq(size, spacing)
    waves = kernels.surface_compliance(body, q[:, None], q[: size // 2 + 1])[..., :2, :2].real
    if along:
        waves = np.trace(waves, axis1=-2, axis2=-1)[..., None, None] / 2 * np.eye(2)

    def moved(traction):
        transform = np.fft.rfft2(traction, s=(size, size))
        return np.fft.irfft2(np.einsum("xyij,jxy->ixy", waves, transform), s=(size, size))[:, :CELLS, :CELLS]

    # no wave moves the surface more than a uniform traction, on a rigid base
    step, pull, found = 1 / np.abs(waves).max(), np.array([1.0, 0.0])[:, None, None], []
    for displacement in displacements:
        here = ahead = np.zeros((2, CELLS, CELLS))
        speed = 1.0
        for _ in range(1000):
            trial = ahead - step * (moved(ahead) - displacement * pull)
            trial[1] *= not along
            trial *= np.minimum(1.0, most / np.maximum(np.hypot(*trial), 1e-300))
            change = np.abs(trial - here).max()
            # momentum, anew where it leads uphill (O'Donoghue and Candes)
            speed = 1.0 if ((ahead - trial) * (trial - here)).sum() > 0 else speed
            faster = (1 + np.sqrt(1 + 4 * speed**2)) / 2
            here, ahead, speed = trial, trial + (speed - 1) / faster * (trial - here), faster
            if change < 1e-7 * most.max():
                break
        found.append(here[0].sum() / most.sum())
    return np.array(found)


@pytest.mark.long
@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_what_moves_across_the_force_changes_less_than_the_error(poisson):
    """The same cells with and without it, so that only this differs."""
    body, a = fp.Medium([fp.Layer(1e9, poisson, H)], base=fp.RigidBase()), 2 * H
    found = fp.partial_slip(body, TIP, friction=MU, radius=a, stick_radius=np.array([0.95, 0.6, 0.2]) * a)
    whole, alone = (forces_on_cells(body, a, found.displacement.values, along=along) for along in (False, True))
    assert (np.abs(whole / alone - 1) <= found.error).all()
    # and the cells themselves come close to the theory
    np.testing.assert_allclose(alone, found.tangential_force / (MU * found.force), rtol=3e-3)
