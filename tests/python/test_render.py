"""Pictures as numpy arrays, compared with the program's."""
import json
import multiprocessing
import os
import shlex
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest
import rhoray as rr
from conftest import distance_samples

PROGRAM = os.environ["RHORAY_PROGRAM"]


def pixels_of(path):
    """The compressed pixels of a PNG file. One encoder wrote both files: equal pixels give equal chunks."""
    data, at, idat = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        if kind == b"IDAT":
            idat += data[at + 8:at + 8 + length]
        at += length + 12
    return idat


@pytest.mark.parametrize("options, words", [
    ({"iso": 4}, ["--iso", "4"]),
    ({"iso": [3, 5]}, ["--iso", "3,5", "--legend", "off"]),
    ({"mode": "mip"}, ["--mode", "mip"]),
    ({"iso": 4, "accuracy": "certified", "view": "front", "size": (200, 150)},
     ["--iso", "4", "--accuracy", "certified", "--view", "front", "--size", "200x150"]),
    ({"iso": "auto", "style": "presentation", "size": (160, 120)},
     ["--iso", "auto", "--style", "presentation", "--size", "160x120"]),
])
def test_pictures_are_those_of_the_program(tmp_path, ball, options, words):
    ball.save(tmp_path / "ball.rho")
    subprocess.run([PROGRAM, "render", "ball.rho", *words, "-q", "-o", "program.png"], cwd=tmp_path, check=True)
    rr.render(rr.open(tmp_path / "ball.rho"), **options).save(tmp_path / "python.png")
    assert pixels_of(tmp_path / "python.png") == pixels_of(tmp_path / "program.png")


def test_channels_are_views_with_known_numbers(ball):
    picture = rr.render(ball, iso=4, accuracy="certified", size=(120, 90),
                        antialias=1, camera={"position": [10, -40, 6], "target": [10, 8, 6], "up": [0, 0, 1], "fov": 30},
                        channels=["depth", "normal", "value", "error", "cell", "cost"])
    assert picture.depth.shape == (90, 120) and picture.normal.shape == (90, 120, 3)
    assert picture.color.shape == (90, 120, 4) and picture.rgba.shape == (90, 120, 3)
    assert not picture.depth.flags.owndata and not picture.depth.flags.writeable
    # The trilinear distance differs from the true one by less than a cell's second-order term.
    assert picture.depth[45, 60] == pytest.approx(44, abs=0.05)
    shown = numpy.isfinite(picture.depth)
    assert (picture.value[shown] == 4).all() and numpy.isnan(picture.value[~shown]).all()
    assert (picture.cell[~shown] == 2**64 - 1).all()
    assert picture.error[shown].max() < 1e-3
    assert picture.stats["hits"] == shown.sum()
    assert numpy.allclose(numpy.linalg.norm(picture.normal[shown], axis=-1), 1, atol=1e-5)
    check = picture.verify(100)
    assert check["broken"] == "" and check["random"]["missed"] == 0
    depth = picture.depth
    copy = depth.copy()
    del picture
    assert numpy.array_equal(depth, copy)


def test_a_picture_s_scene_makes_the_same_picture(ball, box):
    for data, options in ((ball, {"iso": numpy.array([3, 5])}), (ball, {"iso": numpy.float32(4)}), (box, {}), (box, {"iso": 1.5, "color_by": "u"})):
        picture = rr.render(data, size=(96, 96), **options)
        again = rr.render(json.loads(json.dumps(picture.scene)), data={"data": data})
        assert numpy.array_equal(picture.color, again.color)


def test_data_of_one_file_are_those_of_their_names(ball, box, tmp_path):
    def scene(name, **reading):
        layers = [{"data": name, "type": "isosurface", "isovalue": 4}]
        return {"data": {"a": {"file": "f"}, "b": {"file": "f", **reading}}, "layers": layers,
                "camera": {"position": [10, -40, 6], "target": [10, 8, 6], "up": [0, 0, 1], "fov": 30},
                "image": {"size": [60, 40]}}
    other = rr.volume({"distance": distance_samples()}, spacing=(0.25, 0.5, 0.5))
    shown = [rr.render(scene(name), data={"a": ball, "b": other}) for name in "ab"]
    alone = [rr.render({**scene("a"), "data": {"a": {}}}, data={"a": data}) for data in (ball, other)]
    for picture, expected in zip(shown, alone, strict=True):
        assert numpy.array_equal(picture.rgba, expected.rgba)
    assert {spec["file"] for spec in shown[1].scene["data"].values()} == {"f"}
    distance_samples().tofile(tmp_path / "f")
    for name in "ab":  # one file, read in two ways
        read = scene(name, raw="41x33x25:float32", spacing=[0.25, 0.5, 0.5])
        read["data"]["a"].update(raw="41x33x25:float32", spacing=[0.5, 0.5, 0.5])
        (tmp_path / "scene.json").write_text(json.dumps(read))
        picture = rr.render(tmp_path / "scene.json")
        assert numpy.array_equal(picture.rgba, shown["ab".index(name)].rgba)
        subprocess.run([PROGRAM, "render", "scene.json", "-o", "program.png", "--force", "-q"], cwd=tmp_path, check=True)
        assert picture.compare(tmp_path / "program.png")["differing"] == 0
        subprocess.run([PROGRAM, *shlex.split(picture.command)[1:], "--force", "-q"], cwd=tmp_path, check=True)
        assert picture.compare(tmp_path / "picture.png")["differing"] == 0
        with rr.view(tmp_path / "scene.json", browser=False) as view:
            assert numpy.array_equal(view.picture(size=(60, 40)).rgba, picture.rgba)


def test_pictures_show_themselves_in_notebooks(ball):
    assert rr.render(ball, iso=4, size=(32, 32))._repr_png_().startswith(b"\x89PNG")


def test_several_threads_render_at_once(ball):
    expected = rr.render(ball, iso=4, size=(200, 200)).color
    found = [None] * 4

    def work(i):
        found[i] = rr.render(ball, iso=4, size=(200, 200)).color
    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(numpy.array_equal(color, expected) for color in found)


def test_ctrl_c_ends_a_long_render():
    program = """
import numpy, rhoray as rr, sys, time
v = rr.volume(numpy.random.default_rng(1).random((64, 64, 64)))
rr.render(v, iso=0.5, size=(64, 64), accuracy="exact")
print("ready", flush=True)
try:
    rr.render(v, iso=0.5, size=(4000, 4000), accuracy="exact")
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60)[0] == "interrupted\n"


def _render_in_child(queue):
    try:
        rr.render(rr.volume(distance_samples()), iso=4, size=(32, 32))
        queue.put("rendered")
    except rr.Error as error:
        queue.put(str(error))


@pytest.mark.parametrize("method, words", [("fork", "forked"), ("spawn", "rendered")])
def test_forked_processes_get_a_sentence_and_spawned_ones_render(ball, method, words):
    rr.render(ball, iso=4, size=(32, 32))
    context = multiprocessing.get_context(method)
    queue = context.Queue()
    process = context.Process(target=_render_in_child, args=(queue,))
    process.start()
    assert words in queue.get(timeout=60)
    process.join()
    assert process.exitcode == 0


@pytest.mark.parametrize("call, words", [
    (lambda ball: rr.render(ball, iso=float("nan")), "NaN or infinite"),
    (lambda ball: rr.render(ball, iso=4, camera={"position": object()}), "tolist"),
    (lambda ball: rr.render(ball, iso=4, size=(0, 10)), "size"),
    (lambda ball: rr.render(ball, iso=4, colormap="viridis"), "color_by"),
    (lambda ball: rr.render(ball, iso=4, channels=["error"]), "error"),
    (lambda ball: rr.render(ball, iso=4, channels=["depht"]), "depht"),
    (lambda ball: rr.render(ball, iso=4, accuracy="precise"), "precise"),
    (lambda ball: rr.render(ball, mode="isosurface"), "mode"),
    (lambda ball: rr.render({"layers": []}), ""),
    (lambda ball: rr.render({}, iso=3), "iso"),
    (lambda ball: ball.boundary(), "mesh"),
])
def test_wrong_requests_are_refused_with_a_sentence(ball, call, words):
    with pytest.raises(rr.UsageError, match=words):
        call(ball)


LAYER = {"data": "data", "type": "isosurface", "isovalue": 4}


@pytest.mark.parametrize("call, words", [
    (lambda ball, path: rr.render(path / "missing.json"), "missing.json"),
    (lambda ball, path: rr.render(path / "bad.json"), "bad.json: line 1, column 2: .*expected JSON"),
    (lambda ball, path: rr.render(path / "deep.json"), "deep.json"),
    (lambda ball, path: rr.render(path / "list.json"), "list.json: found list; expected"),
    (lambda ball, path: rr.render(path / "bytes.json"), "bytes.json: is not text"),
    (lambda ball, path: rr.render(path), "Is a directory"),
    (lambda ball, path: rr.render(7), "found int; expected"),
    (lambda ball, path: rr.render([]), "found list; expected"),
    (lambda ball, path: rr.render({"data": []}), "/data"),
    (lambda ball, path: rr.render({"data": {"a": "x.rho"}, "layers": [LAYER]}), "/data/a"),
    (lambda ball, path: rr.render({"data": {"a": {"file": [1]}}, "layers": [LAYER]}), "/data/a/file"),
    (lambda ball, path: rr.render({"data": {"data": {}}, "layers": "x"}, data={"data": ball}), "/layers"),
    (lambda ball, path: rr.render({"data": {"data": {}}, "layers": [LAYER]}, data=ball), "data: found Data"),
    (lambda ball, path: rr.render({"data": {"data": {}}, "layers": [LAYER]}, data={"data": 7}), "data: .*found int"),
    (lambda ball, path: rr.render({"data": {"head": {"file": "f"}}, "layers": [LAYER]}, data={"haed": ball}),
     "data: 'haed': .*expected 'f' or 'head'"),
    (lambda ball, path: rr.render(ball, iso=4, camera="front"), "/camera"),
    (lambda ball, path: rr.render(ball, iso=4, size=5), "/image/size"),
    (lambda ball, path: rr.render(ball, iso=4, range=5), "range"),
    (lambda ball, path: rr.render(ball, mode=[]), "mode"),
    (lambda ball, path: rr.render(ball, iso=4, effects={("a",): 1}), "render: keys"),
    (lambda ball, path: rr.view({"data": []}, browser=False), "/data"),
    (lambda ball, path: rr.view(path / "list.json", browser=False), "list.json"),
    (lambda ball, path: rr.view(7, browser=False), "found int"),
    (lambda ball, path: rr.accuracy({"data": {"a": 3}}), "/data/a"),
])
def test_scenes_of_another_shape_are_refused_with_a_sentence(ball, tmp_path, call, words):
    (tmp_path / "bad.json").write_text("{")
    (tmp_path / "deep.json").write_text("[" * 100_000)
    (tmp_path / "list.json").write_text("[]")
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe")
    with pytest.raises(rr.Error, match=words):
        call(ball, tmp_path)


def test_a_command_draws_the_same_picture(ball, box, tmp_path):
    pictures = [rr.render(ball, iso=[3, 5, 7], size=(60, 40)), rr.render(ball, mode="mip", size=(60, 40)),
                rr.render(box, size=(60, 40)), rr.render(box, iso=2, size=(60, 40), background="none")]
    program = os.environ["RHORAY_PROGRAM"]
    for picture in pictures:
        words = shlex.split(picture.command)
        assert words[:2] == ["rhoray", "render"] and words[-2:] == ["-o", "picture.png"]
        subprocess.run([program, *words[1:], "--force", "-q"], cwd=tmp_path, check=True)
        assert picture.compare(tmp_path / "picture.png")["differing"] == 0
    with pytest.raises(rr.UsageError, match="boundary"):
        rr.render(box.boundary(), size=(8, 8)).command


def test_pictures_are_compared(ball):
    one, other = (rr.render(ball, iso=iso, size=(60, 40), zoom=1) for iso in (5, 4))
    same, found = one.compare(one), one.compare(other)
    assert (same["pixels"], same["differing"], same["root_mean_square"]) == (2400, 0, 0)
    difference = abs(one.rgba.astype(int) - other.rgba).max(axis=-1)
    assert found["differing"] == (difference > 0).sum()
    assert found["largest"]["size"] == pytest.approx(difference.max() / 255)
    with pytest.raises(rr.Error):
        one.compare(rr.render(ball, iso=5, size=(61, 40)))
