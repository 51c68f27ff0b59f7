"""The error of partial slip, against friction in all directions on cells."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import kernels

H, MU, CELLS = 1e-6, 0.3, 48
TIP = fp.Paraboloid(1e-4)


def cells_across(a):
    """Middles of the cells across a contact of radius a."""
    return (np.arange(CELLS) - (CELLS - 1) / 2) * 2.2 * a / CELLS


def tractions_on_cells(body, a, displacements, *, along):
    """Tractions along x over mu F of the least energy with |traction| <= mu p in each cell, shape (n, cells, cells).

    `along` has round tractions' mean response alone.
    """
    x = cells_across(a)
    spacing, size = x[1] - x[0], 4 * CELLS
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
        found.append(here[0] / most.sum())
    return np.array(found)


@pytest.mark.parametrize("exponent", [1.0, 2.0, 4.5])
def test_angle_between_slip_and_force_is_the_same_everywhere_under_powers(exponent):
    """On half-spaces, where all slides: r^2 u_2 is an integral of r^2 f'."""
    found = fp.partial_slip(
        fp.HalfSpace(1e9, 0.4), fp.PowerLaw(exponent, 1e3), friction=MU, depth=1e-7, stick_radius=0.0
    )
    angle = 0.4 / 1.6 * exponent / (exponent + 2)
    np.testing.assert_allclose(found.error, angle**2 / 4, rtol=1e-12)


def test_forces_and_displacements_next_to_none_stick_to_the_rim():
    a = 1.9e-7
    body = fp.Medium([fp.Layer(5.4e9, 0.3, 1.6e-7)], base=fp.HalfSpace(1e9, 0.1))
    for name, value in (("displacement", 1e-23), ("tangential_force", 1e-20)):
        found = fp.partial_slip(body, TIP, friction=MU, radius=a, places=3, **{name: value})
        np.testing.assert_allclose(found.stick_radius, a, rtol=1e-5)
        assert np.isfinite(found.traction_error).all()


@pytest.mark.long
@pytest.mark.parametrize(
    ("layers", "a"),
    [
        ([fp.Layer(1e9, 0.3, H)], 2 * H),
        ([fp.Layer(1e9, 0.5, H)], 2 * H),
        # the film moves with the soft layer, and slips little
        ([fp.Layer(4e9, 0.3, H / 5), fp.Layer(0.4e9, 0.3, H / 4)], H),
    ],
)
def test_what_moves_across_the_force_changes_less_than_the_error(layers, a):
    """The same cells with and without it, so that only this differs."""
    body, stick = fp.Medium(layers, base=fp.RigidBase()), np.array([0.95, 0.6, 0.2, 0.0]) * a
    found = fp.partial_slip(body, TIP, friction=MU, radius=a, stick_radius=stick, places=201)
    tractions = [tractions_on_cells(body, a, found.displacement.values, along=along) for along in (False, True)]
    whole, alone = (each.sum(axis=(1, 2)) for each in tractions)
    assert (np.abs(whole / alone - 1) <= found.error).all()
    # and the cells themselves come close to the theory
    np.testing.assert_allclose(alone, found.tangential_force / (MU * found.force), rtol=3e-3)
    # in the mean over rings two cells wide
    x = cells_across(a)
    r = np.hypot(x[:, None], x) / a
    ring = (r * CELLS / 4.4).astype(int)
    for i in range(found.step.size):
        error = np.interp(r, found.place, found.traction_error[i])
        change, most = (
            np.bincount(ring[r < 1], each[r < 1])
            for each in (MU * found.force.values[i] * (tractions[0][i] - tractions[1][i]), error * (x[1] - x[0]) ** 2)
        )
        assert (np.abs(change) <= most).all()
