"""How the program is found, watched and ended."""
import multiprocessing
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time
from concurrent import futures

import numpy
import pytest
import rhoray as rr
from rhoray import _program

NOTHING_LEFT_S = 10  # in which a program that was told to end has ended, on a busy machine


@pytest.fixture
def fake_program(tmp_path, monkeypatch):
    """Makes a shell script that takes the place of the program."""
    def make(script):
        path = tmp_path / "fake"
        path.write_text("#!/bin/sh\n" + script)
        path.chmod(0o755)
        monkeypatch.setenv("RHORAY_PROGRAM", str(path))
    return make


def children(process):
    """Ids of the processes that any thread of a process started."""
    return [child for task in pathlib.Path(f"/proc/{process}/task").iterdir()
            for child in (task / "children").read_text().split()]


def is_running(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_importing_the_module_loads_only_what_most_calls_need():
    code = ("import sys, numpy; before = set(sys.modules); import rhoray; "
            "print(*set(sys.modules) - before); print(open('/proc/self/maps').read())")
    modules, maps = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                                   check=True).stdout.split("\n", 1)
    assert "rhoray._view" in modules.split()
    assert {"subprocess", "html", "socket"}.isdisjoint(modules.split())
    assert "librhoray" in maps and "libOpenImageIO" not in maps


# ---- found ---------------------------------------------------------------------------------------

def test_a_missing_program_is_told_with_its_package(tmp_path, monkeypatch, ball):
    monkeypatch.setenv("RHORAY_PROGRAM", str(tmp_path / "none"))
    with pytest.raises(rr.FileError, match="none: no such program; RHORAY_PROGRAM"):
        rr.info(ball)
    monkeypatch.delenv("RHORAY_PROGRAM")
    monkeypatch.setattr(_program, "__file__", str(tmp_path / "lib/python3/dist-packages/rhoray/_program.py"))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(rr.FileError, match="this needs the program rhoray.*\nhint: the Debian package rhoray"):
        rr.info(ball)
    for place in ("rhoray", "bin/rhoray"):  # that of the prefix comes before that in PATH
        path = tmp_path / place
        path.parent.mkdir(exist_ok=True)
        path.write_text("#!/bin/sh\n")
        path.chmod(0o755)
        assert _program.path() == str(path)


def test_a_missing_worker_is_told_with_its_package(tmp_path, monkeypatch, box):
    monkeypatch.setenv("RHORAY_WORKER_DIR", str(tmp_path))
    with pytest.raises(rr.Error, match="the program rhoray-validate-worker.*\nhint: the package rhoray-mesh") as caught:
        rr.validate(box, 1.5)
    assert caught.value.code == 7


@pytest.mark.parametrize("script, error, words", [
    ("kill -9 $$", rr.Error, r"ended by signal 9 \(Killed\)"),
    ("echo cannot load a library >&2; exit 127", rr.Error, "ended with exit code 127: cannot load a library"),
    ("echo rhoray: no room >&2; exit 5", rr.ResourceError, "^no room$"),
    ("echo 'rhoray info: a: b\nhint: c' >&2; exit 4", rr.FileError, "^a: b\nhint: c$"),
])
def test_every_end_of_the_program_is_an_error_with_a_sentence(fake_program, ball, script, error, words):
    fake_program(script)
    with pytest.raises(error, match=words):
        rr.info(ball)


def test_a_program_that_cannot_be_started_is_told():
    with pytest.raises(rr.FileError, match="rhoray: cannot be started: Argument list too long"):
        rr.info("x" * 10_000_000)


# ---- progress ------------------------------------------------------------------------------------

@pytest.mark.parametrize("call", [lambda box, progress: rr.resample(box, size=40, progress=progress),
                                  lambda box, progress: rr.volume(numpy.zeros((40, 40, 40)), progress=progress)])
def test_progress_rises_in_named_phases(box, call):
    steps = []
    call(box, lambda *step: steps.append(step))
    assert len({phase for phase, _, _ in steps}) > 3
    assert all(phase and "(" not in phase for phase, _, _ in steps)
    for (phase, done, _), (next_phase, next_done, _) in zip(steps, steps[1:]):
        assert phase != next_phase or done <= next_done
    assert any(done == total > 0 for _, done, total in steps)


@pytest.mark.parametrize("call", [lambda box: rr.resample(box, size=40, progress=True),
                                  lambda box: rr.volume(numpy.zeros((40, 40, 40)), progress=True)])
def test_a_bar_is_drawn_and_wiped_away(box, capsys, call):
    call(box)
    drawn = capsys.readouterr().err
    assert re.search(r"\rwriting samples \[=+ *\] \d+ %", drawn)
    assert "\n" not in drawn and drawn.endswith("\r") and drawn.split("\r")[-2].strip() == ""


def test_nothing_is_printed_without_progress(box, capfd):
    rr.resample(box, size=8)
    assert capfd.readouterr() == ("", "")


def test_an_exception_in_progress_ends_the_program(box):
    def fail(phase, done, total):
        raise RuntimeError("enough")
    begin = time.monotonic()
    with pytest.raises(RuntimeError, match="enough"):
        rr.validate(box, 1.5, samples=10**9, progress=fail)
    assert time.monotonic() - begin < 5
    assert children(os.getpid()) == []


# ---- ended ---------------------------------------------------------------------------------------

def interrupted_after_s(call, is_ready=lambda: children(os.getpid())):
    """How long a call goes on after SIGINT, which comes half a second after it is ready."""
    sent = []

    def send():
        while not is_ready():
            time.sleep(0.01)
        time.sleep(0.5)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)
    thread = threading.Thread(target=send)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        call()
    thread.join()
    assert children(os.getpid()) == []
    return time.monotonic() - sent[0]


def test_ctrl_c_ends_long_calls(tmp_path, temporary_folder, ball):
    corner = rr.surface(numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]),
                        numpy.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    noise = rr.volume(numpy.random.default_rng(1).random((64, 64, 64)))
    for call in (lambda: rr.tetrahedralize(corner, max_volume=1e-8), lambda: rr.accuracy(noise, iso=0.5),
                 lambda: rr.validate(ball, 4, samples=10**9)):
        assert interrupted_after_s(call) < 0.5  # measured: 0.03 s
    assert list(temporary_folder.iterdir()) == []
    report = tmp_path / "results/report.html"
    interrupted_after_s(lambda: rr.accuracy(ball, report.parent, iso=4, size=(240, 180), repeat=1000), report.exists)
    assert "Interrupted" in report.read_text()


def test_a_second_ctrl_c_ends_a_program_that_writes_its_results(fake_program, ball, tmp_path):
    fake_program(f"trap 'touch {tmp_path}/told' INT\nwhile :; do sleep 0.1; done")

    def again():
        while not (tmp_path / "told").exists():
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)
    thread = threading.Thread(target=again)
    thread.start()
    assert interrupted_after_s(lambda: rr.accuracy(ball, tmp_path / "results")) < 5
    thread.join()


def test_ctrl_c_in_a_terminal_does_not_reach_the_program_besides(box):
    groups = []

    def look(phase, done, total):
        groups.extend(os.getpgid(int(child)) for child in children(os.getpid()))
    rr.resample(box, size=40, progress=look)
    assert groups and os.getpgid(0) not in groups


def test_a_killed_python_leaves_no_program(tmp_path):
    code = """
import rhoray as rr, numpy
rr.validate(rr.volume(numpy.random.default_rng(1).random((9, 9, 9))), 0.5, samples=10**9)
"""
    process = subprocess.Popen([sys.executable, "-c", code])
    end = time.monotonic() + NOTHING_LEFT_S
    while time.monotonic() < end and not (children(process.pid) and children(children(process.pid)[0])):
        time.sleep(0.01)
    program = children(process.pid)[0]
    worker = children(program)[0]
    process.kill()
    process.wait()
    end = time.monotonic() + NOTHING_LEFT_S
    while time.monotonic() < end and (is_running(program) or is_running(worker)):
        time.sleep(0.01)
    assert not is_running(program) and not is_running(worker)


def test_threads_and_forked_processes_start_programs(ball):
    expected = rr.info(ball)
    with futures.ThreadPoolExecutor(4) as pool:
        assert list(pool.map(rr.info, [ball] * 8)) == [expected] * 8
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply(_fields_in_child, (ball.path,)) == expected["fields"]
        with pytest.raises(rr.FileError, match="absent.rho: no such file"):
            pool.apply(rr.info, ("absent.rho",))


def _fields_in_child(path):
    return rr.info(path)["fields"]


def test_a_forked_process_leaves_the_files_of_its_parent(tmp_path):
    header = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n"
    (tmp_path / "a.nrrd").write_bytes(header + bytes(8))
    code = f"""
import os, sys, rhoray as rr
data = rr.open({str(tmp_path / "a.nrrd")!r})
if os.fork() == 0:
    sys.exit()
os.wait()
print(os.path.exists(data.path), data.path)
"""
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert told[0] == "True" and not os.path.exists(told[1])
