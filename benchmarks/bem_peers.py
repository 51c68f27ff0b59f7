"""Boundary elements here and in other packages: same grid, same force, same residual, one run on one machine.

    python benchmarks/bem_peers.py [--sizes 512 1024] [--threads 2] [--peers tamaas aspher ...] [--environment DIR]

Installs the peers into a virtual environment of their own, and slippy, which needs NumPy 1.20, into another one made by a
Python 3.7 to 3.9 (the first on the path or under pyenv; or --old-python). aspher needs a C++ compiler, CMake and Eigen. What
cannot be installed is left out and named. Everyone solves the free-space contact of a homogeneous half-space
at given force. The residual in the table is the same for all: the pressure is convolved with the exact coefficients, and
the largest deviation of the gap from its mean in contact, and the largest penetration, are divided by the depth. Each peer's own
tolerance is lowered until that is at most 1e-8 or stops falling; the times are those of the last solve alone. On a machine that
does other work besides, compare the processor time.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

TARGET = 1e-8
TOLERANCES = (1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
OLD = ("slippy",)
"""Peers that need an old Python."""

PEERS = ("tamaas", "slippy", "aspher", "ContactMechanics")
SIDE = 2.5
"""Side of the grid over the radius of Hertz's contact."""


def heights(shape: str, n: int) -> np.ndarray:
    """Gap at first touch on n x n cells; every contact fills about 0.8 of the grid's width."""
    x = (np.arange(n) - (n - 1) / 2) * SIDE / n
    return heights_at(shape, x, x[:, None])


def heights_at(shape: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The same at coordinates, broadcast together."""
    if shape == "sphere":
        return (x**2 + y**2) / 2
    if shape == "ellipsoid":
        return x**2 / 2 + y**2 * 1.5
    return np.maximum(np.abs(x), np.abs(y)) + 0 * y


FORCES = {"sphere": 4 / 3, "ellipsoid": 0.6, "pyramid": 0.7376}


def now() -> np.ndarray:
    """Wall clock and processor time [s]."""
    return np.array([time.perf_counter(), time.process_time()])


def solve_tamaas(f, force, tolerance, threads):
    import tamaas as tm

    n = f.shape[0]
    tm.initialize(threads)
    tm.set_log_level(tm.LogLevel.error)
    start = now()
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [SIDE, SIDE], [n, n])
    model.E, model.nu = 1.0, 0.0
    tm.ModelFactory.registerNonPeriodic(model, "free")
    solver = tm.PolonskyKeerRey(model, -f, tolerance)
    solver.setIntegralOperator("free")
    solver.max_iter = 5000
    solver.solve(force / SIDE**2)
    return now() - start, np.array(model.traction)


def solve_aspher(f, force, tolerance, threads, backend="h2"):
    import aspher

    n = f.shape[0]
    coarsest = n
    while coarsest % 2 == 0 and coarsest > 64:
        coarsest //= 2
    start = now()
    result = aspher.solve_nested(
        n, f, force / SIDE**2, domain_size=SIDE, E_star=1.0, tol=tolerance, coarsest=coarsest, backend=backend
    )
    return now() - start, np.array(result.pressure)


def solve_aspher_fft(f, force, tolerance, threads):
    return solve_aspher(f, force, tolerance, threads, backend="fft")


def solve_contactmechanics(f, force, tolerance, threads):
    import ContactMechanics as cm
    import SurfaceTopography as st

    n = f.shape[0]
    start = now()
    substrate = cm.FreeFFTElasticHalfSpace((n, n), 1.0, (SIDE, SIDE))
    system = cm.make_system(substrate=substrate, surface=st.Topography(-f, (SIDE, SIDE)))
    result = system.minimize_proxy(external_force=force, pentol=tolerance, maxiter=5000)
    elapsed = now() - start
    return elapsed, np.array(result.jac) * (n / SIDE) ** 2


def solve_slippy(f, force, tolerance, threads):
    import slippy.contact as c
    import slippy.surface as s

    n = f.shape[0]
    start = now()
    flat, tip = s.FlatSurface(shift=(0, 0)), s.Surface(profile=-f, grid_spacing=SIDE / n)
    flat.material = c.Elastic("substrate", {"E": 1.0, "v": 0.0})
    tip.material = c.Rigid("tip")
    model = c.ContactModel("peer", tip, flat)
    model.add_step(c.StaticStep("load", normal_load=force, tolerance=tolerance, max_it=5000))
    state = model.solve(skip_data_check=True)
    return now() - start, np.array(state["loads_z"])


SOLVERS = {
    "tamaas": solve_tamaas,
    "aspher": solve_aspher,
    "aspher (fft)": solve_aspher_fft,
    "ContactMechanics": solve_contactmechanics,
    "slippy": solve_slippy,
}


def worker(arguments) -> None:
    """One solve in the peers' environment: reads heights, writes pressure and time."""
    name, path, force, tolerance, threads = arguments
    data = np.load(path)
    elapsed, pressure = SOLVERS[name](data["f"], float(force), float(tolerance), int(threads))
    np.savez(path, f=data["f"], pressure=pressure, elapsed=elapsed)


def old_python() -> str | None:
    """An interpreter old enough for the peers that need one."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for version in ("3.9", "3.8", "3.7"):
        found = [shutil.which(f"python{version}"), *map(str, sorted(pyenv.glob(f"{version}.*/bin/python")))]
        for python in filter(None, found):
            if subprocess.run([python, "--version"], capture_output=True, check=False).returncode == 0:
                return python
    return None


def install(folder: Path, wanted: list[str], old: str | None) -> tuple[dict[str, Path], dict[str, str]]:
    """Interpreter of each peer, and why a peer is missing."""
    pythons, missing = {}, {}
    for peer in wanted:
        base, home = (old, folder.with_name(folder.name + "-old")) if peer in OLD else (sys.executable, folder)
        if base is None:
            missing[peer] = "no Python 3.7 to 3.9 found"
            continue
        python = home / "bin" / "python"
        if not python.exists():
            subprocess.run([base, "-m", "venv", str(home)], check=True)
        done = subprocess.run([python, "-m", "pip", "install", "-q", peer], capture_output=True, text=True, check=False)
        if done.returncode:
            lines = [line.strip() for line in (done.stdout + done.stderr).splitlines() if "rror" in line]
            missing[peer] = lines[0] if lines else "pip failed"
        else:
            pythons[peer] = python
    return pythons, missing


def peer_run(python: Path, name: str, shape: str, n: int, tolerance: float, threads: int):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.npz"
        np.savez(path, f=heights(shape, n))
        environment = dict(os.environ, OMP_NUM_THREADS=str(threads), OPENBLAS_NUM_THREADS="1")
        command = [python, __file__, "--worker", name, path, str(FORCES[shape]), str(tolerance), str(threads)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(done.stderr.strip().splitlines()[-1])
        data = np.load(path)
        return data["elapsed"], data["pressure"]


def residual(shape: str, pressure: np.ndarray) -> float:
    """Largest deviation of the gap in contact, or penetration outside, over the depth; by the exact coefficients."""
    from flatpunch.bem.operator.convolution import build_operator

    n = pressure.shape[0]
    u = build_operator(*half_space(n)).apply(pressure) * SIDE / n
    inside = pressure > 0
    sunk = u + heights(shape, n)
    # the mean of the extremes is the depth that suits the solution best
    depth = (sunk[inside].max() + sunk[inside].min()) / 2
    return max(np.abs(sunk[inside] - depth).max(), -(sunk[~inside] - depth).min()) / depth


def half_space(n: int):
    from flatpunch import media
    from flatpunch.bem import Grid
    from flatpunch.compliances import compliance

    return compliance(media.HalfSpace(1.0, 0.0)), Grid(n, n, SIDE / n)


def own_run(shape: str, n: int, threads: int, force_control: bool, whole: bool = False):
    """Wall and processor time, and pressure; `whole` keeps it from solving on a quarter of the grid, as peers do not either."""
    from flatpunch.bem.solver.levels import Levels
    from flatpunch.bem.solver.nested import solve_depth, solve_force

    kernel, grid = half_space(n)
    os.environ["OMP_NUM_THREADS"] = str(threads)
    # a tilt of this size is far below the residual, but makes the contact no mirror image of itself
    tilt = 1e-11 if whole else 0.0

    def height(g):
        x, y = g.x, g.y[:, None]
        return heights_at(shape, x, y) + tilt * (x + y)

    start = now()
    levels = Levels(kernel, grid)
    if force_control:
        state, _ = solve_force(levels, height, FORCES[shape], 1.0, 0.9e-8, 1000)
    else:
        depth = {"sphere": 1.0, "ellipsoid": 0.9, "pyramid": 1.0}[shape]
        state, _ = solve_depth(levels, height, depth, 0.9e-8, 1000)
    return now() - start, np.asarray(state.pressure)


def tightened(python: Path, name: str, shape: str, n: int, threads: int):
    best = None
    for tolerance in TOLERANCES:
        elapsed, pressure = peer_run(python, name, shape, n, tolerance, threads)
        error = residual(shape, pressure)
        if best is not None and error > 0.9 * best[1]:
            return best
        best = elapsed, error, tolerance, pressure.sum() * (SIDE / n) ** 2
        if error <= TARGET:
            break
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[512, 1024])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--peers", nargs="*", default=list(PEERS))
    parser.add_argument("--shapes", nargs="+", default=list(FORCES))
    parser.add_argument("--environment", type=Path, default=Path(tempfile.gettempdir()) / "flatpunch-peers")
    parser.add_argument("--old-python", help="interpreter of Python 3.7 to 3.9 for " + ", ".join(OLD))
    parser.add_argument("--worker", nargs=5, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        worker(options.worker)
        return
    pythons, missing = install(options.environment, options.peers, options.old_python or old_python())
    for peer, reason in missing.items():
        print(f"{peer}: not installed ({reason})")
    names = list(pythons)
    if "aspher" in names:
        names.insert(names.index("aspher") + 1, "aspher (fft)")
        pythons["aspher (fft)"] = pythons["aspher"]
    print("load of the machine at the start: {:.1f} {:.1f} {:.1f}".format(*os.getloadavg()))
    header = f"{'shape':10s} {'cells':>10s} {'code':30s} {'wall/s':>8s} {'cpu/s':>8s} {'residual':>9s} {'own tol':>8s}"
    print(f"{header}   threads {options.threads}")
    for n in options.sizes:
        for shape in options.shapes:
            for control, whole in ((True, False), (False, False), (True, True)):
                elapsed, pressure = own_run(shape, n, options.threads, control, whole)
                label = "flatpunch, " + ("force" if control else "depth") + (", whole grid" if whole else "")
                row(shape, n, label, elapsed, residual(shape, pressure), "0.9e-8")
            for name in names:
                try:
                    elapsed, error, tolerance, _ = tightened(pythons[name], name, shape, n, options.threads)
                except RuntimeError as failure:
                    print(f"{shape:10s} {n:5d}^2    {name:30s} failed: {failure}", flush=True)
                    continue
                row(shape, n, name, elapsed, error, f"{tolerance:.0e}")


def row(shape: str, n: int, name: str, elapsed: np.ndarray, error: float, tolerance: str) -> None:
    wall, cpu = elapsed
    print(f"{shape:10s} {n:6d}^2   {name:30s} {wall:8.2f} {cpu:8.2f} {error:9.1e} {tolerance:>8s}", flush=True)


if __name__ == "__main__":
    main()
