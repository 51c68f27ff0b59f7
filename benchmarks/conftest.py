"""What is kept of the benchmarks of a version: the fastest round of each with its target, and where it was measured."""

import os
import platform

from flatpunch import __version__


def pytest_benchmark_update_json(config, benchmarks, output_json):
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    machine = {"cpu": output_json["machine_info"]["cpu"].get("brand_raw", platform.machine()), "cores": os.cpu_count()}
    times = {
        one["name"]: {
            "fastest_ms": round(1e3 * one["stats"]["min"], 3),
            "median_ms": round(1e3 * one["stats"]["median"], 3),
            "target_ms": round(one["extra_info"]["target_ms"], 3) if "target_ms" in one["extra_info"] else None,
        }
        for one in output_json["benchmarks"]
    }
    about = {"version": __version__, "date": output_json["datetime"][:10], "python": platform.python_version()}
    output_json.clear()
    output_json.update({**about, **machine, "load": load, "benchmarks": times})
