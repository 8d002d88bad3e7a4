"""The contract of the commands: lazy groups, exit statuses, JSON, progress."""

from __future__ import annotations

import difflib
import errno
import gc
import importlib
import json
import logging
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

import click

from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.paths import allow_outside

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

_TERMINAL_NAMED = ("FORCE_COLOR", "TTY_COMPATIBLE")  # variables by which rich takes a pipe for a terminal
Command = TypeVar("Command", bound=Callable[..., Any])

CHECK_FAILED, INPUT_WRONG, INTERRUPTED = 1, 2, 130  # exit statuses; 130 is a shell's for SIGINT
# Packages that only some commands need, with the extra that installs them.
EXTRAS = {
    "casadi": "fit",
    "numba": "spectroscopy",
    "hapi": "spectroscopy",
    "netCDF4": "spectroscopy",
    "distributed": "dask",
    "lxml": "exchange",
    "embreex": "render",
    "sklearn": "train",
    "xarray": "xarray",
}
LINES = logging.Formatter("%(asctime)s %(message)s", "%H:%M:%S")  # lines of `mat build --verbose`
# Objects between garbage collections of a command: imports make many that stay, and to look through them again and
# again takes a fifth of the start.
_COLLECTED = 50_000
PIPE_WIDTH = 200  # columns of a table that no terminal shows


class CommandGroup(click.Group):
    """A click group whose commands load when they are called.

    Parameters
    ----------
    package : str
        Package that contains one module a command, each with a click command named ``command``.
    commands : dict of str to str
        Command names with the line that ``--help`` shows for each.
    moved : dict of str to str, optional
        Names that users of other tools or earlier versions may type, with the command that does it now.

    Notes
    -----
    Exit status: 0 done, 1 a check failed, 2 the input is wrong (one line on standard error), 130 interrupted.
    """

    def __init__(
        self, name: str, *, package: str, commands: dict[str, str], moved: dict[str, str] | None = None, **settings: Any
    ):
        super().__init__(name=name, **settings)
        self.package, self.lines, self.moved = package, commands, moved or {}
        self.context_settings.setdefault("help_option_names", ["-h", "--help"])

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.lines)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name in self.moved:
            ctx.fail(f"No such command '{name}'; type: {self.name} {self.moved[name]}")
        if name not in self.lines:
            close = difflib.get_close_matches(name, self.lines, n=1, cutoff=0.5)
            if close:
                ctx.fail(f"No such command '{name}'; did you mean '{close[0]}'?")
            return None
        gc.set_threshold(_COLLECTED)
        command: click.Command = importlib.import_module(f"{self.package}.{name}").command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(self.lines.items()))

    def main(self, *args: Any, **settings: Any) -> NoReturn:
        settings["standalone_mode"] = False
        try:
            status = self._run(*args, **settings)
        except BrokenPipeError:
            sys.stderr.close()
            status = 0
        except OSError as error:
            if error.filename is not None or error.errno not in (errno.ENOSPC, errno.EIO, errno.EDQUOT):
                raise
            status = self._complain(f"the output cannot be written: {error.strerror}; check free space", INPUT_WRONG)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is still in the buffer is not written again at the end
        sys.exit(status if isinstance(status, int) else 0)

    def _run(self, *args: Any, **settings: Any) -> Any:
        """Run a command; what a user can mend becomes a line and a status."""
        try:
            return super().main(*args, **settings)
        except InputError as error:
            return self._complain(str(error), INPUT_WRONG)
        except CheckFailed as error:
            return self._complain(str(error), CHECK_FAILED)
        except ModuleNotFoundError as error:
            package = str(error.name).partition(".")[0]
            if package not in EXTRAS:
                raise
            return self._complain(
                f"this command needs the package '{package}'; install it with: pip install"
                f" 'skyshine[{EXTRAS[package]}]'",
                INPUT_WRONG,
            )
        except click.exceptions.NoArgsIsHelpError as error:
            click.echo(error.ctx.get_help())
            return INPUT_WRONG
        except click.ClickException as error:
            context = getattr(error, "ctx", None)
            where = context.command_path if context else self.name
            message = " ".join(error.format_message().split())
            return self._complain(f"{message} (see '{where} --help')", INPUT_WRONG)
        except (click.Abort, KeyboardInterrupt):
            return self._complain("interrupted; finished parts are kept", INTERRUPTED)

    def _complain(self, message: str, status: int) -> int:
        click.echo(f"{self.name}: {message}", err=True)
        return status


def json_option(function: Command) -> Command:
    """Adds ``--json`` to a command, as the parameter `as_json`."""
    return click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")(function)


def allow_outside_option(function: Command) -> Command:
    """Adds ``--allow-outside`` to a command: its jobs may name paths outside their folders."""

    def allow(_context: click.Context, _parameter: click.Parameter, enabled: bool) -> None:
        if enabled:
            allow_outside()

    text = "Let the job name paths that lead out of its folder."
    return click.option("--allow-outside", is_flag=True, expose_value=False, callback=allow, help=text)(function)


def emit_json(result: dict[str, Any]) -> None:
    """Print a result as JSON on standard output."""
    click.echo(json.dumps(result, indent=2, allow_nan=False, ensure_ascii=False))


def echo_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print rows of text in aligned columns on standard output; nothing where there are no rows."""
    if not rows:
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(*header, box=None, pad_edge=False, title=None)
    for row in rows:
        table.add_row(*row)
    console = Console(width=None if sys.stdout.isatty() else PIPE_WIDTH)
    console.print(table, markup=False, highlight=False)
    click.echo()


@contextmanager
def progress(total: float, description: str) -> Iterator[Callable[[float], None]]:
    """Show progress on standard error while the body runs, where that is a terminal: what the log said last, how much
    is done and the time that is left.

    Yields
    ------
    advance : callable
        ``advance(n)`` says that n more of `total` are done.
    """
    if not (sys.stderr.isatty() or any(name in os.environ for name in _TERMINAL_NAMED)):
        yield lambda amount: None
        return
    from rich.console import Console

    with progress_on(Console(stderr=True), total, description) as (_, advance):
        yield advance


@contextmanager
def progress_on(console: Console, total: float, description: str) -> Iterator[tuple[Progress, Callable[[float], None]]]:
    """The bar of `progress` on a console, nothing where that is no terminal; yields the bar and `advance`."""
    from rich.markup import escape
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    text = TextColumn("{task.description}")
    columns = (text, BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(escape(description), total=total)

        def advance(amount: float = 1) -> None:
            bar.advance(task, amount)

        def describe(record: logging.LogRecord) -> None:
            bar.update(task, description=escape(record.getMessage().split(";")[0]))

        with _heard(_Listener(describe)) if console.is_terminal else nullcontext():
            yield bar, advance


@contextmanager
def log_lines(total: float, description: str) -> Iterator[Callable[[float], None]]:
    """In place of a bar, the lines of the log on standard error, each with the time of the day."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(LINES)
    with _heard(handler):
        yield lambda amount: None


class _Listener(logging.Handler):
    """Hands the records of the log to a function."""

    def __init__(self, function: Callable[[logging.LogRecord], None]) -> None:
        super().__init__()
        self.function = function

    def emit(self, record: logging.LogRecord) -> None:
        self.function(record)


@contextmanager
def _heard(handler: logging.Handler) -> Iterator[None]:
    """Let a handler hear what the project logs while the body runs."""
    log = logging.getLogger("skyshine")
    before = log.level
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(before)
