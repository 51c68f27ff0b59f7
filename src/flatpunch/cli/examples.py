"""Two examples of every command, as its `--help` shows them; the tests run each.

They work on the files that `flatpunch demo` leaves behind, so that everybody has them.
"""

from __future__ import annotations

_CASE, _FIT = "demo-results/afm_pyramid_on_gel.toml", "demo-results/fit"

EXAMPLES: dict[str, tuple[str, str]] = {
    "solve": (
        f"flatpunch solve {_CASE}",
        f"flatpunch solve {_CASE} -o gel.nc --csv gel.csv --plot gel.pdf --style two-columns",
    ),
    "check": (f"flatpunch check {_CASE}", f"flatpunch check {_FIT}/thin_gel.toml"),
    "demo": ("flatpunch demo", "flatpunch demo --output my-cases"),
    "show-tip": (
        f"flatpunch show-tip {_CASE} --output tip.png",
        f'flatpunch show-tip {_FIT}/hard_film.toml --extent "200 nm" --output berkovich.svg',
    ),
    "show-medium": (
        f"flatpunch show-medium {_CASE} --output gel.png",
        "flatpunch show-medium demo-results/elliptic_tip_on_graded_nitride.toml --output nitride.pdf --style one-column",
    ),
    "fit": (
        f"flatpunch fit {_FIT}/thin_gel.csv {_FIT}/thin_gel.toml --plot fit.png",
        f"flatpunch fit {_FIT}/relaxing_cell.csv {_FIT}/relaxing_cell.toml -o cell.csv",
    ),
    "read": (
        f"flatpunch read {_FIT}/thin_gel.csv",
        f"flatpunch read {_FIT}/thin_gel.csv {_FIT}/thin_gel.toml --plot read.png",
    ),
    "fit-film": (
        f"flatpunch fit-film {_FIT}/hard_film.csv {_FIT}/hard_film.toml",
        f"flatpunch fit-film {_FIT}/hard_film.csv {_FIT}/hard_film.toml -o points.csv --plot film.pdf",
    ),
    "correct": (
        f'flatpunch correct {_FIT}/thin_gel.toml --reported "8 kPa" --depth "300 nm"',
        f'flatpunch correct {_FIT}/thin_gel.toml --reported "8 kPa" --depth "300 nm" --model hertz --over depth',
    ),
    "compare": (
        "flatpunch compare demo-results/afm_pyramid_on_gel.toml --plot formulas.png",
        "flatpunch compare demo-results/afm_pyramid_on_gel.toml -o formulas.csv",
    ),
    "sweep": (
        f"flatpunch sweep {_CASE} --vary layers.0.thickness=0.8um:5um:8:log --plot thickness.png",
        f'flatpunch sweep {_CASE} --vary "indenter.half_opening_angle=15deg, 25deg, 35deg" --quantity stiffness --csv angles.csv',
    ),
    "stress": (
        "flatpunch stress demo-results/knee_insert_sliding_on_tray.toml --plot knee.png",
        "flatpunch stress demo-results/hard_coating_on_steel.toml -o coating.nc --csv coating.csv",
    ),
    "slip": (
        "flatpunch slip demo-results/sphere_fretting_on_coating.toml",
        "flatpunch slip demo-results/sphere_fretting_on_coating.toml -o fretting.csv --plot fretting.png",
    ),
    "rough": (
        "flatpunch rough demo-results/rough/rough_carbon_on_steel.toml --plot carbon.png",
        "flatpunch rough demo-results/rough/beads_on_gel.toml -o beads.nc --plot beads.png",
    ),
    "cite": (
        "flatpunch cite demo-results/afm_pyramid_on_gel.nc",
        "flatpunch cite demo-results/sphere_sticking_to_gel_in_water.nc -o gel.bib",
    ),
    "design": (
        "flatpunch design demo-results/coating_for_a_stiffness.toml",
        "flatpunch design demo-results/coating_for_a_stiffness.toml --csv coating.csv --plot coating.pdf",
    ),
    "app": ("flatpunch app", "flatpunch app --port 0 --no-browser"),
    "plugin list": ("flatpunch plugin list", "flatpunch plugin list | cat"),
    "plugin write": (
        f"flatpunch plugin write nanite {_FIT}/thin_gel.toml -o model_thin_gel.py",
        f'flatpunch plugin write slippy {_CASE} --depths "0.2um, 1um" --spacing 50nm --cells 128',
    ),
    "atlas list": ("flatpunch atlas list", "flatpunch atlas list | head -3"),
    "atlas show": ("flatpunch atlas show bonded-layer", "flatpunch atlas show sliding-coating"),
    "atlas query": (
        "flatpunch atlas query bonded-layer --beta 0.1:10:5:log --set poisson=0.45",
        "flatpunch atlas query sliding-layer --beta 1",
    ),
    "atlas export": (
        "flatpunch atlas export sliding-layer --csv sliding.csv",
        "flatpunch atlas export bonded-layer --csv bonded.csv --beta 0.1:10:20:log --set poisson=0.3,0.5 --terms 8",
    ),
}


def examples(command: str) -> str:
    """The end of a command's help."""
    shown = "\n\n".join(f"[bold]{line}[/bold]" for line in EXAMPLES[command])
    return f"Examples, with the files that [bold]flatpunch demo[/bold] leaves behind:\n\n{shown}"
