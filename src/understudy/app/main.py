"""Entry point of the `understudy` command: picks a command, prints its outcome, sets the status.

Only the standard library is imported here, so that `understudy --help` answers at once.
"""

from __future__ import annotations

import contextlib
import difflib
import importlib
import io
import json
import os
import re
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from understudy import __version__
from understudy.app.outcome import Interrupted, Outcome, plain
from understudy.app.streams import lasting, stoppable
from understudy.errors import Diverged, NotFound, UnderstudyError

OK, PARTLY, BAD_INPUT, DEFECT, INTERRUPTED = 0, 1, 2, 3, 130

COMMANDS = {
    "track": "Make a simulated body perform motion clips, and report how well it did.",
    "perform": "Run an edit file: clips, bodies, props, tasks and pushes in one text.",
    "info": "Say what is in a clip: skeleton, rate, roles, repairs, the body it would get.",
    "convert": "Read a clip, edit it if asked, and write it in another format.",
    "tune": "Search for the servo stiffness that follows a clip best.",
    "athlete": "Simulate an athlete that runs, with no clip: only a controller and a body.",
    "train": "Search an athlete's gains over many scenarios.",
    "vary": "Make a family of varied, physically simulated motions from one clip.",
    "score": "Print the certificate of a saved take.",
    "render": "Make a video, a contact sheet or an HTML player from a saved take.",
    "samples": "List the bundled sample motions, or write them as files.",
    "fetch": "Download a named motion from its public source.",
    "reproduce": "Run a paper's experiments again, beside its published numbers.",
}

USAGE = """\
usage: understudy COMMAND [ARGUMENTS]

Turns a recorded motion into a physically simulated performance.

{commands}

  understudy COMMAND --help    options and an example
  understudy --version

Every command takes --json: one JSON object on standard output, errors included.
Status: 0 done; 1 some clips failed or a simulation diverged; 2 bad input, nothing was made;
3 a defect in understudy; 130 interrupted; 143 told to end.

Example:
  understudy track sample:gesture --out out/gesture
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    words = list(sys.argv[1:] if argv is None else argv)
    with lasting() as (out, err), stoppable():
        status = _dispatch(words)
        out.flush()
        # Where the reader of our output went away, as `head` does, nothing is amiss.
        if out.problem is not None and not isinstance(out.problem, BrokenPipeError):
            reason = out.problem.strerror or out.problem
            print(f"understudy: standard output cannot be written: {reason}.", file=err)
            return status or PARTLY
        return status


def _dispatch(words: list[str]) -> int:
    if not words or words[0] in ("-h", "--help", "help"):
        print(usage(), end="")
        return OK if words else BAD_INPUT
    if words[0] in ("-V", "--version"):
        print(f"understudy {__version__}")
        return OK
    name, arguments = words[0], words[1:]
    as_json = "--json" in words
    valued = [word for word in arguments if word.startswith("--json=")]
    if valued and name in COMMANDS:
        message = f"--json takes no value; write --json instead of {valued[0]}."
        return _fail(f"understudy {name}", message, BAD_INPUT, as_json)
    if name == "--json":
        message = f"give a command before --json. Valid: {', '.join(COMMANDS)}."
        return _fail("understudy", message, BAD_INPUT, as_json)
    if name not in COMMANDS:
        near = difflib.get_close_matches(name, COMMANDS, n=1)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        return _fail(
            "understudy",
            f"no command named {name!r}.{hint} Valid: {', '.join(COMMANDS)}.",
            BAD_INPUT,
            as_json,
        )
    return _run(name, arguments, as_json)


def usage() -> str:
    """The text of `understudy --help`."""
    return USAGE.format(commands="\n".join(f"  {k:<9} {v}" for k, v in COMMANDS.items()))


def parse(name: str, arguments: Sequence[str]) -> Any:
    """Options of one command from its words.

    Raises:
        UnderstudyError: The words do not parse; the text is one line.
        SystemExit: Help was asked for, and printed.
    """
    import tyro

    module = importlib.import_module(f"understudy.app.{name}")
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            return tyro.cli(
                module.Options,
                prog=f"understudy {name}",
                args=list(arguments),
                config=(tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes),
            )
    except SystemExit as end:
        if not end.code:
            print(f"\nExample:\n{module.EXAMPLE}")
            raise
        raise UnderstudyError(_one_line(said.getvalue(), name)) from None


def _one_line(boxed: str, name: str) -> str:
    """The parser's boxed message, drawn with lines or in ASCII, as one line that names the help."""
    lines = [line.strip("│ ") for line in boxed.splitlines()]
    drawn = any(line.startswith("╭") for line in lines)
    paragraphs: list[list[str]] = [[]]
    for line in lines:
        if line and set(line) <= set("─-"):
            paragraphs.append([])
        elif line and not line.startswith(("╭", "╰")):
            paragraphs[-1].append(line)
    message, *rest = paragraphs if drawn else paragraphs[1:] or [[]]  # in ASCII the title is first
    near = [line.split()[0] for part in rest for line in part if line.startswith("--")]
    meant = near and any(part[:1] == ["Perhaps you meant:"] for part in rest)
    text = " ".join(message).rstrip(".") or "the arguments do not parse"
    if text.startswith("Missing from") and len(message) > 1:
        text = f"{message[1]} is missing"
    # A value of none of an option's types: which types were tried is no help to a person.
    text = _choices(text)
    text = re.sub(r"argument '(--[\w-]+)'", r"\1", text)
    text = re.sub(
        r"Error parsing (--[\w-]+): (?:could not convert string to float|invalid literal for "
        r"int\(\) with base 10): '(.*)'",
        _no_number,
        text,
    )
    text = re.sub(
        r": no type matching .* instantiated from \[(.*?)\].*", r": it cannot be \1", text
    )
    text = re.sub(r"Error parsing (--[\w-]+): it cannot be ''", r"\1 needs a value", text)
    text += "" if text.endswith("?") else "."
    return f"{text}{f' Did you mean {near[0]}?' if meant else ''} See: understudy {name} --help"


def _choices(text: str) -> str:
    """A refused choice: the choices in order, None left out, and the nearest one."""
    found = re.search(r"invalid choice '(.*?)' for .*?\. Expected one of \((.*?)\)", text)
    if not found:
        return text
    valid = sorted(set(re.findall(r"'(.*?)'", found[2])) - {"None"})
    folded = {choice.lower(): choice for choice in valid}
    near = difflib.get_close_matches(found[1].lower(), folded, n=1)
    listed = ", ".join(repr(choice) for choice in valid)
    meant = f". Did you mean {folded[near[0]]!r}?" if near else ""
    return text.replace(f"Expected one of ({found[2]})", f"Expected one of {listed}{meant}")


def _no_number(found: re.Match[str]) -> str:
    """A word that is no number, or no whole one."""
    if not found[2]:
        return f"{found[1]} needs a value"
    kind = "whole number" if "int()" in found[0] else "number"
    return f"{found[1]} is {found[2]!r}, which is no {kind}"


def _run(name: str, arguments: list[str], as_json: bool) -> int:
    who = f"understudy {name}"
    try:
        with _only_json_on_stdout(as_json):
            options = parse(name, arguments)
            outcome: Outcome = importlib.import_module(f"understudy.app.{name}").run(options)
    except SystemExit as end:
        return int(end.code or OK)
    except KeyboardInterrupt as stop:
        status = getattr(stop, "status", INTERRUPTED)
        word = "interrupted" if status == INTERRUPTED else "told to end"
        done = getattr(stop, "result", {})
        kept = getattr(stop, "kept", Interrupted().kept)
        return _fail(who, f"{word}; {kept}.", status, as_json, done)
    except Exception as error:
        if os.environ.get("UNDERSTUDY_DEBUG"):
            raise
        return _fail(who, *explained(error), as_json)
    if as_json:
        print(json.dumps(plain(outcome.result), indent=2, allow_nan=False))
    elif outcome.text:
        print(outcome.text)
    return outcome.status


def explained(error: Exception) -> tuple[str, int]:
    """One line for a person and the exit status, for anything a command can raise.

    With UNDERSTUDY_DEBUG the traceback goes to standard error first.
    """
    if os.environ.get("UNDERSTUDY_DEBUG"):
        traceback.print_exception(error)
    if isinstance(error, Diverged | NotFound):
        return str(error), PARTLY
    if isinstance(error, UnderstudyError):
        return str(error), BAD_INPUT
    if isinstance(error, OSError):
        try:
            Path.cwd()
        except OSError:
            return "the current folder is there no more; change to another.", BAD_INPUT
        reason = error.strerror or " ".join(str(error).split()) or type(error).__name__
        where = "" if error.filename is None else f"{error.filename}: "
        return f"{where}{reason}.", BAD_INPUT
    if isinstance(error, MemoryError):
        return "not enough memory for this clip; trim it or resample it first.", PARTLY
    text = " ".join(str(error).split())
    return (
        f"unexpected {type(error).__name__}: {text} (a defect in understudy; "
        "UNDERSTUDY_DEBUG=1 shows where).",
        DEFECT,
    )


def _fail(
    who: str,
    message: str,
    status: int,
    as_json: bool,
    done: Mapping[str, Any] | None = None,
) -> int:
    """Say what went wrong, under --json beside what was done before; the status."""
    message = " ".join(message.split())
    if as_json:
        print(json.dumps({**plain(done or {}), "error": message, "status": status}))
    else:
        print(f"{who}: {message}", file=sys.stderr)
    return status


@contextlib.contextmanager
def _only_json_on_stdout(wanted: bool) -> Iterator[None]:
    """Send everything printed meanwhile, by Python or by a C library, to standard error."""
    if not wanted:
        yield
        return
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        os.dup2(2, 1)
        with contextlib.redirect_stdout(sys.stderr):
            yield
        sys.stdout.flush()
    finally:
        os.dup2(kept, 1)
        os.close(kept)


if __name__ == "__main__":
    sys.exit(main())
