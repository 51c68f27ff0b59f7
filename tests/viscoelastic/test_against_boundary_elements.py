"""A second road: boundary elements stepped in time, with no knowledge of Lee-Radok, Ting or springs.

Each cell's pressure relaxes like the modulus. With the elastic pressure e and the memory q of one exponential,
p = g e + (1 - g) q, a step changes p by what e changes: p_new = P (g + (1 - g) m) + (what is left of the old), so that every
step is one elastic contact problem for P under a tip displaced by the memory.
"""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import build_operator
from flatpunch.bem.solver.active_set import solve_contact
from flatpunch.compliances import compliance

CELLS, STEPS = 64, 48
LAW = fp.StandardLinearSolid(0.3, 0.4)


def stepped(medium, radius, time, depth, half_width):
    """Force and contact area at each time for a paraboloid."""
    kernel = compliance(medium)
    grid = Grid.around((half_width, half_width), CELLS)
    operator = build_operator(kernel, grid)
    spacing = grid.spacing
    x, y = np.meshgrid(grid.x, grid.y)
    height = (x**2 + y**2) / (2 * radius) / spacing
    g, tau = LAW.equilibrium, LAW.time
    elastic, memory = np.zeros_like(height), np.zeros_like(height)
    force, area = np.zeros(time.size), np.zeros(time.size)
    for n in range(1, time.size):
        z = (time[n] - time[n - 1]) / tau
        decay, gain = np.exp(-z), -np.expm1(-z) / z
        total = g + (1 - g) * gain
        free = -(g * elastic + (1 - g) * decay * memory) / total
        offset = operator.apply(elastic + free)
        state = solve_contact(operator, height + offset, depth[n] / spacing, tolerance=1e-7)
        change = free + state.pressure
        elastic = elastic + change
        memory = decay * memory + gain * change
        force[n] = total * state.force * kernel.modulus * spacing**2
        area[n] = state.contact.sum() * spacing**2
    return force, area


@pytest.mark.parametrize(
    "medium",
    [fp.HalfSpace(1.0, 0.3), fp.Medium([fp.Layer(1.0, 0.45, 0.3)], base=fp.RigidBase())],
    ids=["half-space", "layer"],
)
def test_growing_shrinking_and_growing_again(medium):
    radius, most = 5.0, 0.05
    corners = [0, 1, 1.6, 2.2, 3.2]
    time = np.linspace(0, 3.2, STEPS + 1)
    depth = most * np.interp(time, corners, [0, 1, 0.45, 1.1, 0.1])
    fine = np.linspace(0, 3.2, 10 * STEPS + 1)
    curve = fp.indent(medium, fp.Paraboloid(radius), time=fine, depth=np.interp(fine, time, depth), relaxation=LAW)
    force, area = stepped(medium, radius, time, depth, float(curve.radius.max()))
    scale = float(curve.force.max())
    # 48 steps, linear within: measured 1.8e-3 where the contact shrinks, 4e-4 with twice as many; cells matter less
    assert np.allclose(force, curve.force.values[::10], rtol=0, atol=2.5e-3 * scale)
    # areas jump by cells along the rim, 4 pi a/spacing of them: 2 % of the largest
    assert np.allclose(area, curve.area.values[::10], rtol=0, atol=0.03 * float(curve.area.max()))
