"""The bodies of this package in other programs: one module a host, but for the two that fit force curves.

`contactmechanics`, `tamaas` and `micromechanics` are imported where both packages are installed; `force_models` (nanite and
SoftMech) and `slippy` write a module that carries one case. `flatpunch plugin write` puts either into a file.
"""
