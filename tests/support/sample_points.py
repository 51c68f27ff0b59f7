"""Functions that other processes load: well behaved ones, and all kinds of others."""

import os
import signal
import time
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info


def square(x):
    return {"square": x * x, "row": np.arange(3) * x, "name": f"x = {x}"}


def square_but_not_of_three(x):
    if x == 3:
        raise ValueError(f"x = {x} is refused")
    return square(x)


def slowly(point):
    """(seconds, folder, name): leaves a mark in the folder when it begins."""
    seconds, folder, name = point
    Path(folder, f"begun-{name}-{os.getpid()}").touch()
    time.sleep(seconds)
    return {"pid": os.getpid()}


def deadly(point):
    """(x, folder): "always" kills its process each time, "once" the first time only."""
    x, folder = point
    mark = Path(folder, f"been-here-{x}")
    if x == "always" or (x == "once" and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"x": x}


def threads(_):
    import scipy.linalg

    scipy.linalg.solve(np.eye(3), np.ones(3))
    pools = [pool["num_threads"] for pool in threadpool_info()]
    return {"threads": max(pools), "pools": len(pools), "omp": int(os.environ["OMP_NUM_THREADS"])}


def unkeepable(x):
    return {"thing": object()}


def slowly_in_process(point):
    time.sleep(0.15)
    return {"pid": os.getpid()}


def slowly_named(point):
    """(seconds, name)."""
    time.sleep(point[0])
    return {"name": point[1]}


def which_process(point):
    time.sleep(0.02)
    return {"pid": os.getpid(), "at": time.monotonic()}


def group_of(point):
    return point[0]


def cost_of(point):
    return point[1]


def deadly_job(name, arguments):
    """(folder, deaths): kills its process so many times, each of which leaves a mark; a job of the page."""
    folder, deaths = arguments
    marks = len(list(Path(folder).iterdir()))
    if marks < deaths:
        Path(folder, f"death-{marks}").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done", marks
