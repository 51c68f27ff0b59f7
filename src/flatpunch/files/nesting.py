"""Nesting of TOML before it is parsed: the parser recurses, and takes time with the square of dotted keys."""

from __future__ import annotations

import re

DEEPEST = 30
"""Brackets within brackets, and parts of a dotted key; case files have four."""

_TOKEN = re.compile(
    # a text that is not closed is a token to its end: the parser refuses it, and each of its quotes would begin another search
    r'"""(?:[^"\\]|\\.|"(?!""))*+(?:"{3,5})?'
    r"|'''(?:[^']|'(?!''))*+(?:'{3,5})?"
    r'|"(?:[^"\\\n]|\\.)*+"?'
    r"|'[^'\n]*+'?"
    r"|\#[^\n]*"
    r"|(?P<open>[\[{])|(?P<close>[\]}])|(?P<dot>\.)|(?P<end>[=\n,])",
    re.DOTALL,
)


def check_nesting(text: str) -> None:
    """Refuse text that is nested deeper than any case file, by a ValueError with the line."""
    depth = dots = 0
    for token in _TOKEN.finditer(text):
        kind = token.lastgroup
        depth = depth + 1 if kind == "open" else max(depth - 1, 0) if kind == "close" else depth
        dots = dots + 1 if kind == "dot" else 0 if kind in ("end", "open", "close") else dots
        if depth > DEEPEST or dots > DEEPEST:
            what = "brackets" if depth > DEEPEST else "dots"
            line = text.count("\n", 0, token.start()) + 1
            raise ValueError(f"line {line} is nested deeper than {DEEPEST} levels of {what}. Case files have four.")
