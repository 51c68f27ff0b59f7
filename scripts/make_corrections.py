"""Make src/flatpunch/contact/refined/data/corrections.npz: corrections of standard tips on one layer on a rigid base.

python scripts/make_corrections.py

About eight hundred boundary element solutions, some ten minutes. src/flatpunch/contact/refined/table.py describes the table.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.perturbation.power_law_series import power_expansion
from flatpunch.contact.refined.refinement import Refinement
from flatpunch.contact.refined.table import ANGLES, layer, reference_outline, sector

FILE = Path(__file__).parent.parent / "src/flatpunch/contact/refined/data/corrections.npz"
SIDES = (3, 4, 6)
BETAS = 10.0 ** np.array([-2, -1.5, -1, -0.75, -0.5, -0.25, 0, 0.25, 0.5, 0.75, 1, 1.25])
"""Base radius of the second-order series over the thickness."""
ROOTS = np.array([0.0, 0.1, 0.25, 0.45, 0.67, 0.87, 1.0])
"""q = sqrt(1 - 2 nu) of bonded layers."""
SQUARES = np.array([0.12, 0.3, 0.47, 0.6, 0.7])
"""s^2 of the ellipses; at 0 there is nothing to correct."""
CELLS = 512
"""Cells per side: ten in the thinnest layer under the widest contact of pyramids."""


def rows(medium: fp.Medium, tip: object, name: str, cells: int) -> np.ndarray:
    """Logarithms of the ratios at all nodes of beta, the outline averaged over the symmetric sectors."""
    kernel = compliance(medium)
    solutions = Refinement(kernel, tip, ANGLES, cells, None)
    series = power_expansion(kernel, tip, "second", terms=False)
    contact = series.evaluate(BETAS)
    positions = np.log(contact.depth).tolist()
    solutions.solve(positions)
    force = np.array([solutions.samples[x].force for x in positions]) + np.log(kernel.modulus / contact.force)
    shape = np.array([solutions.samples[x].shape for x in positions])
    radius, area = shape[:, 0] - np.log(BETAS), 2 * (shape[:, 1] - np.log(BETAS))
    phi = 2 * np.pi * np.arange(ANGLES) / ANGLES
    outline = shape[:, 2:] - np.log(reference_outline(series, contact, phi))
    count = sector(name)
    period = 2 * (count - 1)
    outline = outline.reshape(len(BETAS), -1, period).mean(axis=1)
    mirrored = (outline + outline[:, -np.arange(period) % period]) / 2
    return np.column_stack([force, radius, area, mirrored[:, :count]])


def main() -> None:
    """Solve everything and write the table."""
    layers = [layer(root) for root in (*ROOTS, None)]
    tables = {}
    for sides in SIDES:
        tables[str(sides)] = np.array([rows(medium, fp.Pyramid(sides, 0.4), str(sides), CELLS) for medium in layers])
        print(sides, "sides", np.abs(tables[str(sides)][..., 0]).max(), flush=True)
    ellipses = [fp.EllipticParaboloid(1 - s, 1 + s) for s in np.sqrt(SQUARES)]
    tables["ellipse"] = np.array([[rows(medium, tip, "ellipse", CELLS) for tip in ellipses] for medium in layers])
    FILE.parent.mkdir(exist_ok=True)
    # single precision holds 1e-7 of logarithms below one
    rounded = {name: table.astype(np.float32) for name, table in tables.items()}
    np.savez_compressed(FILE, **rounded, betas=BETAS, roots=ROOTS, squares=SQUARES)
    print(FILE.stat().st_size, "bytes")


if __name__ == "__main__":
    main()
