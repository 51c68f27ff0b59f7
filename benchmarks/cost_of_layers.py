"""Measure and draw how the cost grows with the number of layers: the table and the picture of docs/cost.md.

    python benchmarks/cost_of_layers.py docs/images/cost_of_layers.png

CPU time of one process, each time for a medium that it has not seen before: layers of equal thickness with random moduli within a
factor of ten, a contact as wide as the stack is thick, and 1000 depths for the curves. The least of three media is shown.
"""

import sys
import time
from collections.abc import Callable
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

LAYERS = (1, 3, 10, 30, 100, 300)
THICKNESS = 1e-6


def stack(layers: int, seed: int) -> fp.Medium:
    """Layers of equal thickness with random moduli."""
    young = 1e9 * 10 ** np.random.default_rng((layers, seed)).uniform(0, 1, layers)
    return fp.Medium([fp.Layer(e, 0.3, THICKNESS) for e in young], base=fp.HalfSpace(young=3e9, poisson=0.3))


def curve(tip: Any, **settings: Any) -> Callable[[fp.Medium], object]:
    """1000 depths up to where the contact is about as wide as the stack is thick."""

    def solved(medium: fp.Medium) -> object:
        depths = np.linspace(1e-3, 0.2, 1000) * len(medium.layers) * THICKNESS
        return fp.indent(medium, tip, depth=depths, **settings)

    return solved


PYRAMID = fp.Pyramid(sides=4, inclination=0.2)
JOBS: dict[str, Callable[[fp.Medium], object]] = {
    "flat punch": lambda medium: fp.flat_punch(medium, len(medium.layers) * THICKNESS),
    "cone": curve(fp.Cone(0.2)),
    "four-sided pyramid, second order": curve(PYRAMID, method="second-order"),
    "four-sided pyramid, fourth order": curve(PYRAMID, method="fourth-order"),
}


def cost(job: Callable[[fp.Medium], object], layers: int) -> float:
    """CPU time [s], the least of three media."""
    times = []
    for seed in range(3):
        medium = stack(layers, seed)
        start = time.process_time()
        job(medium)
        times.append(time.process_time() - start)
    return min(times)


def main(path: str) -> None:
    """Print the table and draw the picture."""
    found = {name: [cost(job, layers) for layers in LAYERS] for name, job in JOBS.items()}
    print("| layers |", " | ".join(JOBS), "|")
    for i, layers in enumerate(LAYERS):
        print(f"| {layers} |", " | ".join(f"{times[i]:.2g} s" for times in found.values()), "|")
    _, ax = plt.subplots(figsize=(4.4, 3.4), layout="constrained")
    for (name, times), mark in zip(found.items(), "os^v", strict=True):
        ax.loglog(LAYERS, times, marker=mark, markersize=4, label=name)
    ax.loglog(LAYERS[2:], 1e-4 * np.array(LAYERS[2:]), color="0.6", linewidth=0.8, linestyle="--")
    ax.annotate("proportional to the number", (40, 3e-3), fontsize=7, color="0.4")
    ax.set(xlabel="Layers", ylabel="CPU time (s)")
    ax.legend(fontsize=7, frameon=False)
    ax.grid(True, which="major", alpha=0.25, linewidth=0.6)
    plt.savefig(path, dpi=200)


if __name__ == "__main__":
    main(sys.argv[1])
