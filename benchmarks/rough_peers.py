"""Periodic rough contact here and in other packages: one random surface, one mean pressure, one residual.

    python benchmarks/rough_peers.py [--size 1024] [--share 0.05] [--peers-python /path/to/python]

The interpreter of the peers has tamaas and ContactMechanics; without it flatpunch is timed alone. The residual is the same for
all: displacements of the pressure by the operator C(k), largest gap in contact (from its mean there) and largest penetration,
over the rms height. Tolerances of the peers are lowered until it is at most 1e-6 or stops falling; processor times are those of
the last solve alone.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

STAR = 1.0
TARGET = 1e-6
TOLERANCES = 10.0 ** -np.arange(5, 13)


def residual(heights: np.ndarray, pressure: np.ndarray) -> float:
    """Largest gap in contact and penetration, over the rms height; cells have side 1."""
    n = heights.shape[0]
    k = 2 * np.pi * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n))
    k[0, 0] = np.inf
    gap = np.fft.irfft2(np.fft.rfft2(pressure) * 2 / (STAR * k), heights.shape) - heights
    gap -= gap[pressure > 0].mean()
    return float(max(np.abs(gap[pressure > 0]).max(), -gap.min()) / heights.std())


def solve_tamaas(heights: np.ndarray, mean: float, tolerance: float) -> np.ndarray:
    """Polonsky and Keer in Tamaas."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [float(n) for n in heights.shape], list(heights.shape))
    model.E, model.nu = STAR, 0.0
    solver = tm.PolonskyKeerRey(model, heights, tolerance)
    solver.max_iter = 20_000
    solver.solve(mean)
    return np.array(model.traction)


def solve_contact_mechanics(heights: np.ndarray, mean: float, tolerance: float) -> np.ndarray:
    """Constrained conjugate gradients in ContactMechanics."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from ContactMechanics.Factory import make_system
    from SurfaceTopography import Topography

    size = tuple(float(n) for n in heights.shape)
    substrate = PeriodicFFTElasticHalfSpace(heights.shape, STAR, size)
    system = make_system(substrate=substrate, surface=Topography(heights, size, periodic=True))
    found = system.minimize_proxy(external_force=mean * heights.size, pentol=tolerance * heights.std(), maxiter=20_000)
    return np.abs(np.asarray(found.jac))


PEERS = {"tamaas": solve_tamaas, "ContactMechanics": solve_contact_mechanics}


def timed(solve, heights: np.ndarray, mean: float) -> tuple[float, float, float]:
    """Processor time [s], residual and share of cells in contact of the last solve."""
    last = np.inf
    for tolerance in TOLERANCES:
        start = time.process_time()
        pressure = solve(heights, mean, tolerance)
        took = time.process_time() - start
        now = residual(heights, pressure)
        if now <= TARGET or now >= 0.9 * last:
            break
        last = now
    return took, now, float((pressure > 0).mean())


def as_peer(name: str, path: str, mean: float) -> None:
    """What the interpreter of the peers runs."""
    print("result", *timed(PEERS[name], np.load(path), mean))


def solve_here(heights: np.ndarray, mean: float, tolerance: float) -> np.ndarray:
    """flatpunch, with the steps after the solution (stiffness, patches)."""
    import flatpunch as fp

    rough = fp.Topography(heights, 1.0)
    return fp.rough_contact(
        fp.HalfSpace(STAR, 0.0), rough, pressure=mean, fields=True, tolerance=tolerance
    ).pressure.values[0]


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=1024)
    parser.add_argument("--share", type=float, default=0.05, help="share of the area in contact, about")
    parser.add_argument("--peers-python")
    chosen = parser.parse_args()
    import flatpunch as fp

    n = chosen.size
    rough = fp.self_affine(n, 1.0, rms_slope=0.1, roll_off=n / 8, cut_off=8.0)
    mean = chosen.share / 2 * STAR * rough.rms_slope
    solve_here(fp.self_affine(64, 1.0, rms_slope=0.1, cut_off=8.0).heights, mean, 1e-6)
    took, left, share = timed(solve_here, rough.heights, mean)
    print(f"flatpunch: {took:.2f} s, residual {left:.1e}, {share:.4f} in contact", flush=True)
    layer = fp.Medium([fp.Layer(STAR, 0.0, 12.0)], base=fp.HalfSpace(3 * STAR, 0.3))
    start = time.process_time()
    fp.rough_contact(layer, rough, pressure=mean)
    print(f"flatpunch, a layer of twelve cells: {time.process_time() - start:.2f} s", flush=True)
    if chosen.peers_python:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "heights.npy"
            np.save(path, rough.heights)
            code = (
                "import sys; sys.path.insert(0, sys.argv[1]); import rough_peers as r; "
                "r.as_peer(sys.argv[2], sys.argv[3], float(sys.argv[4]))"
            )
            for name in PEERS:
                words = [chosen.peers_python, "-c", code, str(Path(__file__).parent), name, str(path), str(mean)]
                done = subprocess.run(words, capture_output=True, text=True, check=False)
                line = next((line for line in done.stdout.splitlines() if line.startswith("result")), None)
                if line is None:
                    print(f"{name}: {done.stderr.strip().splitlines()[-1:]}")
                else:
                    took, left, share = map(float, line.split()[1:])
                    print(f"{name}: {took:.2f} s, residual {left:.1e}, {share:.4f} in contact", flush=True)


if __name__ == "__main__":
    sys.exit(main())
