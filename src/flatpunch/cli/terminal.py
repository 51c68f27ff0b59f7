"""What the commands share: their registration, messages for bad input and interrupts, the progress bar, printing and writing.

Output may be closed, full, a pipe that nobody reads, or in an alphabet without Greek letters.

Bad input ends with status 2 and one readable message, an interrupt (Ctrl-C) with status 130; neither leaves a half-written file.
Heavy imports happen inside the commands, so that `--help` and mistakes in the command itself are answered at once.
"""

from __future__ import annotations

import codecs
import functools
import io
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, TextIO, get_type_hints

import typer
from rich.console import Console

from flatpunch._support.checks import FlatpunchWarning
from flatpunch._support.endings import RESULTS, listed
from flatpunch._support.messages import message, wants_traceback
from flatpunch._support.reading import Conflict, command_files
from flatpunch.cli.examples import examples

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    help="Press rigid indenters into layered and graded elastic bodies.\n\n"
    "A case file (TOML) describes the layers from the surface down, what is below them, the indenter, and the depths, "
    'forces or radii to solve for. All quantities carry units: [bold]young = "5 kPa"[/bold].\n\n'
    "Start with [bold]flatpunch demo[/bold]: it solves the cases that come with the package and leaves their files behind "
    "for you to change.",
)

PICTURES = (".png", ".pdf", ".svg")
"""Endings of pictures."""


@dataclass(frozen=True)
class Output:
    """Marks the option of a file that a command writes, with the endings that it may have."""

    endings: tuple[str, ...]


CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)]
StyleOption = Annotated[
    Literal["screen", "one-column", "two-columns"],
    typer.Option("--style", help="Sizes of the picture: for the screen, or one or two columns of a journal."),
]
PlotOption = Annotated[Path | None, typer.Option("--plot", help="Picture: .png, .pdf or .svg."), Output(PICTURES)]
ResultOption = Annotated[
    Path | None, typer.Option("--output", "-o", help=f"Result file: {listed(RESULTS)}."), Output(tuple(RESULTS))
]
NetCDFOption = Annotated[
    Path | None, typer.Option("--output", "-o", help="Result file: .nc (NetCDF)."), Output((".nc",))
]
REPLACED = (
    "Outputs replace files of the same name without asking, but never a file that the command reads or one that is "
    "write-protected."
)
"""What the help of every command with outputs says."""

INTERRUPTED = 128 + signal.SIGINT
"""Status after Ctrl-C, as shells report it."""

_SILENCE = 30.0
"""Seconds without a word after which a command that is not on a terminal says what it does."""

Command = Callable[..., None]


def command(
    name: str, into: typer.Typer = app, *, interrupted: str = "No file was left half-written."
) -> Callable[[Command], Command]:
    """Register a command under its name, "atlas show", with its examples and with readable messages for all that goes wrong.

    Its outputs, options marked as `Output`, are announced before it begins.
    """

    def register(function: Command) -> Command:
        outputs = outputs_of(function)

        @functools.wraps(function)
        def run(*arguments: Any, **options: Any) -> None:
            from flatpunch._support.whole_file import check_target

            with friendly(interrupted), command_files():
                for option, (flag, endings) in outputs.items():
                    if options.get(option) is not None:
                        check_target(flag, options[option], endings)
                function(*arguments, **options)

        # the terminal wraps paragraphs at its own width; of the lines of a docstring it would keep the ends too
        text = "\n\n".join(" ".join(part.split()) for part in (function.__doc__ or "").split("\n\n"))
        text += f"\n\n{REPLACED}" if outputs else ""
        into.command(name.rpartition(" ")[2], epilog=examples(name), help=text)(run)
        return function

    return register


def outputs_of(function: Command) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Outputs of a command: parameter -> option and endings."""
    hints = get_type_hints(function, include_extras=True)
    return {
        name: (f"--{name}", mark.endings)
        for name, hint in hints.items()
        for mark in getattr(hint, "__metadata__", ())
        if isinstance(mark, Output)
    }


class Step(Protocol):
    """What a command calls when it begins with something."""

    def __call__(self, what: str, advance: int = 1) -> None:
        """Show what is being done; `advance` steps were done before it."""


@contextmanager
def friendly(
    interrupted: str = "No file was left half-written.", *, program: Path = Path(__file__).parent
) -> Iterator[None]:
    """Turn bad input into one message and status 2, and Ctrl-C into one line, which ends with `interrupted`, and status 130.

    Errors of the package itself, and of the program in the given folder, are reported in one line; see `_support.messages`.
    """
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(f"\nInterrupted. {interrupted}".rstrip(), err=True)
        raise typer.Exit(INTERRUPTED) from None
    except (typer.Exit, typer.Abort, BrokenPipeError):
        raise
    except (Exception, Conflict) as error:
        if wants_traceback():
            raise
        for each in getattr(error, "exceptions", (error,)):
            typer.echo(f"Error: {message(each, program)}", err=True)
        raise typer.Exit(2) from None


@contextmanager
def progress(title: str, total: int) -> Iterator[Step]:
    """Show a bar on the terminal while the work lasts; a pipe or a log gets a line now and then."""
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with (
        Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar,
        ExitStack() as ends,
    ):
        task = bar.add_task(title, total=total)
        started, doing = False, title

        def step(what: str, advance: int = 1) -> None:
            nonlocal started, doing
            doing = f"{title}: {what}"
            bar.update(task, description=doing, advance=advance if started else 0)
            started = True

        if not console.is_terminal:
            ends.enter_context(_repeated(lambda seconds: typer.echo(f"{doing}, {seconds:.0f} s so far", err=True)))
        yield step


@contextmanager
def _repeated(tell: Callable[[float], None]) -> Iterator[None]:
    """Tell every half minute how many seconds have passed."""
    over, start = threading.Event(), time.monotonic()

    def run() -> None:
        if hasattr(signal, "pthread_sigmask"):
            # interrupts are for the main thread, which holds them back while workers start
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        while not over.wait(_SILENCE):
            tell(time.monotonic() - start)

    threading.Thread(target=run, daemon=True).start()
    try:
        yield
    finally:
        over.set()


def say(text: str) -> None:
    """Print a line as it is: not wrapped, no markup."""
    Console().print(text, markup=False, highlight=False, soft_wrap=True)


def write_all(*wanted: tuple[Path | None, Callable[[Path], object]], bar: bool = True) -> None:
    """Write the files that were asked for, each by its function, and print which were written.

    Each is tried, whatever has become of the others; what goes wrong is raised at the end.
    """
    given = [(path, write) for path, write in wanted if path is not None]
    failed: dict[Path, Exception] = {}
    with progress("Output", len(given)) if bar and given else nullcontext(quiet) as step:
        for path, write in given:
            step(f"{'drawing' if path.suffix.lower() in PICTURES else 'writing'} {path.name}")
            try:
                write(path)
            except Exception as error:
                failed[path] = error
    for title, paths in (("Written", [p for p, _ in given if p not in failed]), ("Not written", list(failed))):
        if paths:
            say(f"{title}: {', '.join(map(str, paths))}")
    if failed:
        errors = list(failed.values())
        raise errors[0] if len(errors) == 1 else ExceptionGroup("files that were not written", errors)


def drawn(function: str, *arguments: Any, **options: Any) -> Callable[[Path], object]:
    """Draw with a function of the package, "fits.pictures:fit_figure", which is loaded when there is a picture to write."""

    def write(path: Path) -> object:
        from flatpunch.plots.result import save_figure

        module, name = function.split(":")
        return save_figure(getattr(import_module(f"flatpunch.{module}"), name)(*arguments, **options), path)

    return write


def quiet(what: str, advance: int = 1) -> None:
    """Show nothing: the step of commands without a bar."""


def say_table(
    title: str | None,
    headings: Sequence[str],
    rows: Iterable[Sequence[str]],
    caption: str = "",
    *,
    left: Sequence[int] = (),
) -> None:
    """Print a table; columns are flush right but for those in `left`."""
    from rich.table import Table

    table = Table(title=title, title_justify="left", caption=caption or None)
    for i, heading in enumerate(headings):
        table.add_column(heading, justify="left" if i in left else "right")
    for row in rows:
        table.add_row(*row)
    Console().print(table)


def say_notes(lines: Iterable[str]) -> None:
    """Print the limits of a result."""
    for line in lines:
        Console().print(f"Note: {line}", style="yellow", markup=False, highlight=False)


_ASCII = {"µ": "u", "²": "^2", "°": " deg", "·": "*", "–": "-", "…": "..."}
_HANDLER = "flatpunch"


def prepare() -> None:
    """Make both streams take everything that is printed."""
    codecs.register_error(_HANDLER, _in_ascii)
    # closed ones are None
    sys.stdout = _usable(sys.stdout)
    sys.stderr = _usable(sys.stderr)
    warnings.showwarning = _note


class _Lasting(io.TextIOWrapper):
    """A stream whose reader may be gone, or its disk full: the command goes on and writes its files, what it prints is lost."""

    error: OSError | None = None

    def write(self, text: str) -> int:
        return int(self._tried(functools.partial(super().write, text), len(text)))

    def flush(self) -> None:
        self._tried(super().flush, None)

    def _tried(self, write: Callable[[], Any], lost: Any) -> Any:
        if self.error is None:
            try:
                return write()
            except OSError as error:
                self.error = error
                # nothing is left to Python to write when it ends
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, self.fileno())
                os.close(nowhere)
        return lost


def finish() -> int:
    """Write out what is buffered; return a status other than 0 if a stream could not be written, and say so on the other one."""
    status = 0
    for name, stream, other in (("output", sys.stdout, sys.stderr), ("error", sys.stderr, sys.stdout)):
        stream.flush()
        error = getattr(stream, "error", None)
        if isinstance(error, BrokenPipeError) and name == "output":
            # whoever read the output has had enough, as `head` has
            return INTERRUPTED - signal.SIGINT + getattr(signal, "SIGPIPE", signal.SIGINT)
        if error is not None:
            print(f"Error: standard {name}: {error.strerror or type(error).__name__}.", file=other, flush=True)
            status = 2
    return status


def _note(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Show a warning of the package as a note; those of libraries help nobody without the place, which goes with tracebacks."""
    if issubclass(category, FlatpunchWarning):
        print(f"Note: {message}", file=sys.stderr)
    elif wants_traceback():
        print(f"{filename}:{lineno}: {category.__name__}: {message}", file=sys.stderr)


def _usable(stream: TextIO | None) -> TextIO:
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8")
    if not isinstance(stream, io.TextIOWrapper):
        # of a program that has put its own in their place
        return stream
    encoding, buffering, through = stream.encoding, stream.line_buffering, stream.write_through
    return _Lasting(stream.detach(), encoding, _HANDLER, line_buffering=buffering, write_through=through)


def _in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Letters that the alphabet of the terminal lacks, in ones that it has."""
    assert isinstance(error, UnicodeEncodeError)
    lost = error.object[error.start : error.end]
    return "".join(_ASCII.get(letter, "?") for letter in lost), error.end
