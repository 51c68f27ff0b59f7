"""Make the synthetic curves of the examples: exact contact of each case, an offset, noise from a fixed seed."""

from pathlib import Path

import numpy as np

import flatpunch as fp
from flatpunch.fits import Tip

HERE = Path(__file__).parent
GLASS = fp.RigidBase()


def write(name: str, titles: list[str], columns: list[np.ndarray]) -> None:
    """One CSV file."""
    np.savetxt(HERE / name, np.column_stack(columns), "%.6g", ",", header=",".join(titles), comments="")


def sticky_gel() -> None:
    """Approach and retract behind a cantilever: jump into contact at depth 0, snap off where dF/dd = -k."""
    gel, bead = fp.Medium([fp.Layer(4e3, 0.5, 3e-6)], base=GLASS), fp.Sphere(5e-6)
    work, k, rng = 2e-4, 0.06, np.random.default_rng(7)
    lost = fp.pull_off(gel, bead, work_of_adhesion=work).depth_minimum.depth
    depth = np.linspace(lost * (1 - 1e-6), 600e-9, 6000)
    force = fp.indent(gel, bead, depth=depth, work_of_adhesion=work, angles=8)["force"].values
    piezo = depth + force / k
    snap = int(np.argmin(piezo))
    way = np.linspace(-500e-9, piezo[-1], 700)
    # both branches are read off at the piezo's position; on the approach nothing happens before the surfaces meet
    stuck = np.where(way >= piezo[snap], np.interp(way, piezo[snap:], force[snap:]), 0.0)
    pressed = np.where(way >= 0, stuck, 0.0)
    cycle, load = np.concatenate([way, way[::-1]]), np.concatenate([pressed, stuck[::-1]])
    load = load + 0.15e-9 + 40e-12 * rng.normal(size=load.size)
    write("sticky_gel.csv", ["piezo (nm)", "force (nN)"], [1e9 * (cycle + 150e-9), 1e9 * load])


def relaxing_cell() -> None:
    """Half a second down, four seconds of hold, one back."""
    cell, bead = fp.Medium([fp.Layer(2e3, 0.5, 4e-6)], base=GLASS), fp.Sphere(2.5e-6)
    law, rng = fp.StandardLinearSolid(0.35, 0.8), np.random.default_rng(8)
    time = np.linspace(0, 6, 1500)
    depth = np.interp(time, [0, 0.5, 1, 5, 6], [-500e-9, 0, 500e-9, 500e-9, -500e-9])
    force = fp.indent(cell, bead, time=time, depth=depth, relaxation=law, angles=8)["force"].values
    force = force + 20e-12 + 8e-12 * rng.normal(size=force.size)
    write("relaxing_cell.csv", ["time (s)", "depth (nm)", "force (nN)"], [time, 1e9 * depth + 200, 1e9 * force])


def hard_film() -> None:
    """Continuous stiffness of a nitride film on steel: hardness sets the force, the layered body the stiffness."""
    film = fp.Medium([fp.Layer(350e9, 0.25, 1e-6)], base=fp.HalfSpace(210e9, 0.3))
    tip, hardness, rng = Tip.from_coefficients([24.5, 180.0]), 22e9, np.random.default_rng(9)
    contact_depth = np.linspace(20e-9, 300e-9, 150)
    area = tip.area(contact_depth)
    radius = np.sqrt(area / np.pi)
    modulus = np.array([fp.flat_punch(film, a).stiffness / (2 * a) for a in radius])
    diamond = 1141e9 / (1 - 0.07**2)
    stiffness = 2 * tip.beta * radius / (1 / modulus + 1 / diamond)
    force = hardness * area
    depth = contact_depth + tip.epsilon * force / stiffness
    stiffness = stiffness * np.exp(0.01 * rng.normal(size=stiffness.size))
    titles = ["depth (nm)", "force (mN)", "stiffness (kN/m)"]
    write("hard_film.csv", titles, [1e9 * depth, 1e3 * force, 1e-3 * stiffness])


def gel_map() -> None:
    """Nine places of one gel, whose modulus varies by a fifth and thickness is known; at the ninth the tip touched nothing."""
    bead, rng = fp.Sphere(5e-6), np.random.default_rng(10)
    (HERE / "gel_map").mkdir(exist_ok=True)
    depth = np.linspace(-300e-9, 600e-9, 150)
    for place, young in enumerate(2.6e3 * np.exp(0.2 * rng.normal(size=9)), start=1):
        gel, force = fp.Medium([fp.Layer(young, 0.5, 2e-6)], base=GLASS), 60e-12 * rng.normal(size=depth.size)
        if place < 9:
            force[depth > 0] += fp.indent(gel, bead, depth=depth[depth > 0], angles=8)["force"].values
        write(f"gel_map/place_{place}.csv", ["depth (nm)", "force (nN)"], [1e9 * depth + 100, 1e9 * force + 0.1])


if __name__ == "__main__":
    gel_map()
    sticky_gel()
    relaxing_cell()
    hard_film()
