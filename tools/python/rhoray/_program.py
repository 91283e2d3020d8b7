"""The program `rhoray`: where it is, how a call runs it, and what its messages become."""
import json
import os
import re
import shutil
import signal

from rhoray import _progress
from rhoray._errors import FileError, UsageError, error_of

_longest_end_s = 10  # how long the program may take to remove its temporary files


def path():
    """The program: RHORAY_PROGRAM, or that of the prefix or build folder of this module, or one in PATH."""
    named = os.environ.get("RHORAY_PROGRAM")
    if named:
        if not _is_program(named):
            raise FileError(f"{named}: no such program; RHORAY_PROGRAM names it", 3)
        return named
    package = os.path.dirname(os.path.realpath(__file__))
    for prefix in ("../../../..", "../.."):  # of lib/python3/dist-packages/rhoray, of build/release/python/rhoray
        program = os.path.normpath(os.path.join(package, prefix, "bin", "rhoray"))
        if _is_program(program):
            return program
    program = shutil.which("rhoray")
    if program is None:
        raise FileError("this needs the program rhoray, which is not in PATH", 3,
                        "the Debian package rhoray contains it; RHORAY_PROGRAM names another place")
    return program


def _is_program(name):
    return os.path.isfile(name) and os.access(name, os.X_OK)


def option_words(options):
    """Options by name as words of a command line: {"max_error": 0.1} as ["--max-error=0.1"].

    None and False: not given. True: a flag. Numbers of a sequence are joined; a sequence of sequences
    gives the option several times.
    """
    words = []
    for name, value in options.items():
        if name in ("output", "force", "json", "quiet", "verbose", "help", "help_all"):
            raise UsageError(f"unknown option {name}")
        value = _plain(value)
        if value is None or value is False:
            continue
        option = "--" + name.replace("_", "-")
        if value is True:
            words.append(option)
            continue
        separator = "x" if name == "size" else ","
        several = value if isinstance(value, list) and value and isinstance(value[0], list) else [value]
        words += [f"{option}={_text_of(one, separator)}" for one in several]
    return words


def _plain(value):
    """Numbers and arrays of numpy as those of Python."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return [_plain(one) for one in value] if isinstance(value, (list, tuple)) else value


def _text_of(value, separator):
    return separator.join(map(str, value)) if isinstance(value, list) else str(value)


def run(command, files, words, progress=None, *, accept=None, keeps_results=False):
    """Runs `rhoray COMMAND WORDS -- FILES` and returns the JSON document that it prints.

    accept: an exit code, besides 0, at which the document is returned.
    keeps_results: on Ctrl+C the program first writes the results that it has; a second one ends it.

    Ctrl+C, and an exception in `progress`, end the program before they leave this function. The system
    ends it when Python is killed.
    """
    import subprocess  # only here and in _end: importing it takes time
    with _progress.shown(progress) as show, open(os.memfd_create("rhoray"), "w+b") as output:
        words = [*_ends_with_python(), path(), command, "--json", "--progress=json" if show else "--quiet", *words,
                 "--", *files]
        try:
            # In a process group of its own, which a terminal does not interrupt: this function
            # does.
            process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.PIPE,
                                       process_group=0)
        except OSError as error:
            raise FileError(f"{path()}: cannot be started: {error.strerror}", 3) from None
        with process:
            try:
                messages = _messages_of(process, show)
                code = process.wait()
            except BaseException:
                _end(process, keeps_results)
                raise
        output.seek(0)
        document = output.read()
    if code != 0 and not (code == accept and document):
        raise error_in(messages, code)
    return json.loads(document)


def _ends_with_python():
    """The beginning of a command line whose program gets SIGTERM when Python is killed.

    This is done in a program of its own because code between fork and exec is not safe beside threads.
    """
    setpriv = shutil.which("setpriv")
    return [setpriv, "--pdeathsig", "TERM", "--"] if setpriv else []


def _messages_of(process, show):
    """What the program prints on stderr until it ends, without its progress."""
    messages = []
    for line in process.stderr:
        if show and line.startswith(b"{"):
            step = json.loads(line)
            show(step["phase"], step["done"], step["total"])
        else:
            messages.append(line.decode(errors="replace"))
    return "".join(messages)


def _end(process, keeps_results):
    """Ends the program and waits for it."""
    import subprocess
    try:
        process.send_signal(signal.SIGINT)
        if keeps_results:
            process.wait()
    finally:
        process.terminate()  # ends what still runs at the second signal
        try:
            process.wait(_longest_end_s)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def error_in(messages, code):
    """The exception for the messages that the program printed on stderr, and its exit code."""
    told = list(re.finditer(r"^rhoray(?: [a-z]+)?: ", messages, re.MULTILINE))
    if told:
        fact, _, hint = messages[told[-1].end():].strip().partition("\nhint: ")
        return error_of(code, fact, hint)
    if code < 0:
        fact, code = f"the program rhoray was ended by signal {-code} ({signal.strsignal(-code)})", 128 - code
    else:
        fact = f"the program rhoray ended with exit code {code}"
    last = messages.strip().rpartition("\n")[2]
    return error_of(code, fact + (f": {last}" if last else ""), "")
