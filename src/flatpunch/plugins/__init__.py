"""The bodies of this package in other programs: one module a host.

`contactmechanics`, `tamaas` and `micromechanics` are imported where both packages are installed; `nanite`, `softmech` and
`slippy` write a module that carries one case. `flatpunch plugin write` puts either into a file.
"""
