"""Follow a page of the documentation literally: its Python blocks print what they promise, its shell blocks end well.

    python scripts/follow_page.py docs/tutorial.md

Run it with the interpreter of an environment made as the page says (`make tutorial` does); it uses nothing but the standard
library and what that environment holds. Blocks run in a folder of their own beside a copy of the examples.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def follow(page: Path) -> int:
    """Run all blocks of a page in order; return how many there are."""
    blocks = re.findall(r"^```(python|sh)\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    for language, block in blocks:
        if language == "python":
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile(block, str(page), "exec"), {"__name__": "page"})
            promised = re.findall(r"# prints: (.*)", block)
            if printed.getvalue().splitlines() != promised:
                raise SystemExit(f"{page}: promised\n{promised}\nprinted\n{printed.getvalue()}")
            continue
        for line in block.splitlines():
            # the environment is made before, as the page says
            if line.split("#")[0].strip() and not line.startswith(("make ", "python ", ".venv/", "pip ")):
                subprocess.run(line, shell=True, check=True, stdout=subprocess.DEVNULL)
    return len(blocks)


if __name__ == "__main__":
    pages = [Path(name).resolve() for name in sys.argv[1:]]
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "examples", Path(folder) / "examples")
        os.chdir(folder)
        for each in pages:
            print(f"{each.name}: {follow(each)} blocks run and print what they promise")
        os.chdir(ROOT)
