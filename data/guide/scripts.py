"""Python scripts of cells, as pages of the guide and as notebooks.

A script begins with a docstring: title, summary, and further paragraphs. A line `# %% Heading` begins
a cell; the heading may be missing. The comment lines that follow it are the text of the cell, in
Markdown; the rest is its code. A line of code such as

    picture.save("head.png")  # a head with transparent skin

saves a picture, which is shown below the cell; the comment is its alternative text.
"""
import ast
import dataclasses
import json
import re
import subprocess
import sys

MARK = re.compile(r"# %%(?: (.*))?$")
PICTURE = re.compile(r'\.save\("([^"]+\.png)".*\)  # (.+)$')

# Runs cells in one Python, and prints the output of each, or the error and its line, as JSON.
RUNNER = r"""
import contextlib, io, json, sys, traceback
name, cells = json.load(sys.stdin)
outputs, names = [], {"__name__": "__main__"}
try:
    for line, code in cells:
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            exec(compile("\n" * (line - 1) + code, name, "exec"), names)
        outputs.append(output.getvalue())
    result = {"outputs": outputs}
except Exception as error:
    here = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == name]
    result = {"line": here[-1] if here else line, "error": f"{type(error).__name__}: {error}",
              "missing": error.name if isinstance(error, ModuleNotFoundError) else None}
print(json.dumps(result))
"""


class Failed(Exception):
    """A script ended with an error. `missing` is the module that it could not import, or None."""

    def __init__(self, line, words, missing=None):
        super().__init__(words)
        self.line, self.missing = line, missing


@dataclasses.dataclass
class Cell:
    line: int  # of the first line of the text or of the code
    heading: str
    text: list[str]
    code: list[str]

    def code_line(self):
        return self.line + len(self.text)

    def pictures(self):
        """Name and alternative text of each picture that the code saves."""
        found = (PICTURE.search(line) for line in self.code)
        return [(match[1], match[2][0].upper() + match[2][1:]) for match in found if match]


@dataclasses.dataclass
class Script:
    name: str
    title: str
    introduction: list[str]
    cells: list[Cell]


def read(path):
    source = path.read_text(encoding="utf-8")
    lines, module = source.splitlines(), ast.parse(source)
    title, *introduction = (ast.get_docstring(module) or "").splitlines()
    starts = [number for number, line in enumerate(lines) if MARK.match(line)]
    cells = []
    for start, end in zip(starts, [*starts[1:], len(lines)]):
        at = start + 1
        while at < end and lines[at].startswith("#"):
            at += 1
        code = lines[at:end]
        while code and not code[-1].strip():
            code.pop()
        text = [line[2:] for line in lines[start + 1:at]]
        cells.append(Cell(start + 2, MARK.match(lines[start])[1] or "", text, code))
    return Script(path.name, title, introduction, cells)


def run(script, folder, environment, time_limit_s):
    """Runs the cells of a script in a folder. Returns the output of each."""
    given = json.dumps([script.name, [[cell.code_line(), "\n".join(cell.code)] for cell in script.cells]])
    try:
        done = subprocess.run([sys.executable, "-c", RUNNER], input=given, cwd=folder, env=environment,
                              capture_output=True, text=True, timeout=time_limit_s, check=False)
    except subprocess.TimeoutExpired:
        raise Failed(1, f"stopped after {time_limit_s} seconds") from None
    if done.returncode != 0:
        raise Failed(1, f"ended with exit code {done.returncode}: {' | '.join(done.stderr.splitlines()[-3:])}")
    result = json.loads(done.stdout.splitlines()[-1])
    if "error" in result:
        raise Failed(result["line"], " | ".join(result["error"].splitlines()), result["missing"])
    return result["outputs"]


def page_lines(script):
    """The script as (number of the line in the script, line of Markdown). Code is in blocks ```python cell=N."""
    lines = [(1, f"# {script.title}"), *((1, line) for line in script.introduction), (1, "")]
    for number, cell in enumerate(script.cells):
        if cell.heading:
            lines.append((cell.line - 1, f"## {cell.heading}"))
        lines += [(cell.line + offset, line) for offset, line in enumerate([*cell.text, ""])]
        if cell.code:
            begin = cell.code_line()
            lines.append((begin, f"```python cell={number}"))
            lines += [(begin + offset, line) for offset, line in enumerate(cell.code)]
            lines.append((begin + len(cell.code), "```"))
        for name, text in cell.pictures():
            lines += [(cell.code_line(), line) for line in ("", f"![{text}]({name})", "")]
    return lines


def notebook(script):
    """The script as a notebook: a dict, as .ipynb files hold it in JSON."""
    cells = [("markdown", [f"# {script.title}", *script.introduction])]
    for cell in script.cells:
        text = ([f"## {cell.heading}", ""] if cell.heading else []) + cell.text
        cells += [("markdown", text)] if text else []
        cells += [("code", cell.code)] if cell.code else []
    common = {"markdown": {}, "code": {"outputs": [], "execution_count": None}}
    return {"nbformat": 4, "nbformat_minor": 5,
            "metadata": {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}},
            "cells": [{"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": "\n".join(lines),
                       **common[kind]} for number, (kind, lines) in enumerate(cells)]}
