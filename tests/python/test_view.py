"""The viewer from Python, with a page that is played by the test. tests/browser does it with a browser."""
import asyncio
import base64
import copy
import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import threading
import time
import urllib.parse

import numpy
import pytest
import rhoray as rr
import websockets

PATIENCE_S = 20
CAMERA = {"position": [40.0, 8.0, 6.0], "target": [10.0, 8.0, 6.0], "up": [0.0, 0.0, 1.0], "fov": 30.0}


@pytest.fixture
def viewer(ball):
    with rr.view(ball, iso=5, browser=False) as view:
        yield view


class Page:
    """What a page in a browser sends and gets."""

    def __init__(self, view):
        self.parts = urllib.parse.urlsplit(view.url)
        self.asked = 0

    async def __aenter__(self):
        token = self.parts.fragment.removeprefix("token=")
        self.socket = await websockets.connect(f"ws://{self.parts.netloc}/ws", origin=f"http://{self.parts.netloc}",
                                               subprotocols=["rhoray.1", token], max_size=None)
        self.hello = await self.message("hello")
        await self.socket.send('{"follow": true}')
        return self

    async def __aexit__(self, kind, error, trace):
        await self.socket.close()

    async def message(self, key):
        """The next message with this key; pictures before it are acknowledged."""
        while True:
            message = await asyncio.wait_for(self.socket.recv(), PATIENCE_S)
            if isinstance(message, bytes):
                await self.socket.send(json.dumps({"ack": int.from_bytes(message[4:8], "little")}))
            elif key in json.loads(message):
                return json.loads(message)[key]

    async def show(self, scene, camera=None, known=0):
        self.asked += 1
        request = {"n": self.asked, "size": [60, 40], "moving": False, "scene": scene, "set": known}
        await self.socket.send(json.dumps(request if camera is None else {**request, "camera": camera}))


async def until(is_so):
    deadline = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < deadline
        await asyncio.sleep(0.005)


def test_scene_is_a_document_of_the_picture(viewer, ball):
    scene = viewer.scene
    assert scene["layers"][0]["isovalue"] == 5
    assert scene["data"] == {"data": {"field": "distance", "file": ball.path}}
    assert set(scene["camera"]) == {"position", "target", "up", "fov"}
    shown = viewer.picture(size=(80, 60))
    assert numpy.array_equal(shown.rgba, rr.render(ball, iso=5, size=(80, 60)).rgba)
    assert numpy.array_equal(shown.rgba, rr.render(dict(scene, image={"size": [80, 60]}), data={"data": ball}).rgba)
    assert viewer.picture(size=(8, 8), channels=["depth"]).depth.shape == (8, 8)


def test_changes_in_python_move_the_page(viewer):
    async def follow():
        async with Page(viewer) as page:
            await page.show({})
            await until(lambda: viewer.size == (60, 40))
            viewer.scene["layers"][0]["isovalue"] = numpy.float32(6)
            first = await page.message("set")
            assert first["scene"] == {"layers": {"0": {"isovalue": 6.0}}}
            layer = viewer.scene["layers"][0]
            layer["isovalue"] = 7
            layer["color"] = [1.0, 0.0, 0.0]
            await page.message("set")
            both = (await page.message("set"))["scene"]
            assert both == {"layers": {"0": {"isovalue": 7, "color": [1.0, 0.0, 0.0]}}}
            viewer.scene["camera"]["ortho_height"] = 12.5
            camera = (await page.message("set"))["camera"]
            assert camera["ortho_height"] == 12.5 and "fov" not in camera
            viewer.scene["layers"].append({"type": "slice", "data": "data", "axis": "z", "position": 5})
            assert (await page.message("set"))["scene"]["layers"]["1"]["axis"] == "z"
            viewer.scene["layers"].pop()
            assert "1" not in (await page.message("set"))["scene"]["layers"]
            document = viewer.scene
            document.update(style="fast")
            assert (await page.message("set"))["scene"]["style"] == "fast"
            viewer.scene = {**viewer.scene, "camera": CAMERA, "style": "paper"}
            last = await page.message("set")
            assert last["camera"] == CAMERA and last["scene"]["style"] == "paper"
    asyncio.run(follow())
    assert viewer.error is None


def test_changes_in_the_page_are_seen_in_python(viewer, ball):
    seen = []

    async def follow():
        async with Page(viewer) as page:
            end = viewer.observe(lambda view: seen.append(view.scene["layers"][0]["isovalue"]))
            held = viewer.scene
            await page.show({"layers": {"0": {"isovalue": 7}}}, CAMERA)
            await until(lambda: viewer.scene["camera"] == CAMERA)
            assert viewer.scene["layers"][0]["isovalue"] == 7 and viewer.size == (60, 40)
            # Only what is changed of a scene that is older than the drag is sent.
            held["style"] = "fast"
            change = await page.message("set")
            assert change["camera"] == CAMERA
            assert change["scene"] == {"layers": {"0": {"isovalue": 7}}, "style": "fast"}
            end()
            await page.show({"layers": {"0": {"isovalue": 8}}}, CAMERA, known=change["n"])
            await until(lambda: viewer.scene["layers"][0]["isovalue"] == 8)
    asyncio.run(follow())
    assert seen == [7]
    assert viewer.picture().size == (60, 40)
    fresh = rr.render(ball, iso=8, size=(60, 40), camera=CAMERA)
    assert numpy.array_equal(viewer.picture().rgba, fresh.rgba)


def test_a_page_that_is_behind_does_not_undo_a_change(viewer):
    async def follow():
        async with Page(viewer) as page:
            viewer.scene["layers"][0]["isovalue"] = 6
            await page.show({"layers": {"0": {"isovalue": 1}}}, known=0)
            await page.message("set")
            await page.show({"layers": {"0": {"isovalue": 6}}, "style": "fast"}, known=1)
            await until(lambda: viewer.scene.get("style") == "fast")
            assert viewer.scene["layers"][0]["isovalue"] == 6
        async with Page(viewer) as later:
            assert (await later.message("set"))["scene"]["style"] == "fast"
    asyncio.run(follow())


def test_wrong_changes_are_refused(viewer):
    for wrong, said in (({"position": [0, 0, 1]}, "expected position, target, up"), (CAMERA | {"zoom": 2}, "zoom")):
        with pytest.raises(rr.UsageError, match=said):
            viewer.scene["camera"] = wrong
    with pytest.raises(rr.UsageError, match="NaN"):
        viewer.scene["layers"][0]["isovalue"] = float("nan")
    with pytest.raises(rr.UsageError, match="expected what JSON can say"):
        viewer.scene["layers"][0]["isovalue"] = object()
    for wrong in (None, [], "x"):
        with pytest.raises(rr.UsageError, match="scene: found .*expected a dict"):
            viewer.scene = wrong
        with pytest.raises(rr.UsageError, match="camera: found .*expected a dict"):
            viewer.scene = {**viewer.scene, "camera": wrong or 7}
        with pytest.raises(rr.UsageError, match="layers: found .*expected a list"):
            viewer.scene["layers"] = wrong if wrong != [] else {}
    assert viewer.scene["layers"][0]["isovalue"] == 5

    async def follow():
        async with Page(viewer) as page:
            viewer.scene["layers"][0]["colour"] = "red"
            change = await page.message("set")
            await page.show(change["scene"], known=change["n"])
            await until(lambda: viewer.error is not None)
    asyncio.run(follow())
    assert "colour" in viewer.error
    del viewer.scene["layers"][0]["colour"]
    assert viewer.error is None
    with pytest.raises(rr.UsageError, match="nosuch"):
        rr.view(viewer._data["data"], color_by="nosuch", browser=False)
    with pytest.raises(rr.UsageError, match="port"):
        rr.view(viewer._data["data"], port=70000, browser=False)


def test_a_copy_of_the_scene_is_plain(viewer):
    for copied in (copy.deepcopy(viewer.scene), copy.copy(viewer.scene), pickle.loads(pickle.dumps(viewer.scene))):
        assert type(copied) is dict and copied == viewer.scene
    for part in ("layers", "camera"):
        plain = copy.deepcopy(viewer.scene[part])
        assert type(plain) in (list, dict) and plain == viewer.scene[part]
        assert pickle.loads(pickle.dumps(viewer.scene[part])) == plain
    layers = copy.deepcopy(viewer.scene["layers"])
    layers[0]["isovalue"] = 7
    assert type(layers[0]) is dict and viewer.scene["layers"][0]["isovalue"] == 5


def test_views_packed_files_scenes_and_meshes(ball, box, tmp_path):
    ball.save(tmp_path / "ball.rho")
    scene = {"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip", "data": "b"}]}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    with rr.view(tmp_path / "scene.json", browser=False) as view:
        assert view.scene["layers"][0]["type"] == "mip"
        assert view.scene["data"]["b"]["file"] == str(tmp_path / "ball.rho")
        assert view.picture(size=(20, 20)).size == (20, 20)
    with rr.view(scene, data={"b": box}, browser=False) as view:
        assert view.picture(size=(20, 20)).size == (20, 20)
    with rr.view(box, browser=False) as view:
        assert view.scene["layers"][0]["type"] == "boundary"


def test_a_notebook_gets_a_frame_and_a_picture(viewer, monkeypatch):
    shown = viewer._repr_mimebundle_()
    assert shown["image/png"].startswith(b"\x89PNG")
    assert f'<iframe src="{viewer.url}"' in shown["text/html"]
    assert base64.b64encode(shown["image/png"]).decode() in shown["text/html"]
    assert "ssh -N -L" in shown["text/html"]
    port, token = urllib.parse.urlsplit(viewer.url).port, viewer.url.partition("#")[2]
    monkeypatch.setenv("JUPYTERHUB_SERVICE_PREFIX", "/user/ada/")
    assert f'<iframe src="/user/ada/proxy/{port}/#{token}"' in viewer._repr_mimebundle_()["text/html"]


def test_a_proxy_of_a_hub_is_let_in(ball):
    with rr.view(ball, iso=5, browser=False, hosts=["hub.example"]) as view:
        parts = urllib.parse.urlsplit(view.url)

        async def connect(host):
            token = parts.fragment.removeprefix("token=")
            socket = await websockets.connect(f"ws://{host}/ws", host="127.0.0.1", port=parts.port,
                                              origin=f"http://{host}", subprotocols=["rhoray.1", token])
            await socket.close()
        asyncio.run(connect("hub.example"))
        with pytest.raises(websockets.InvalidStatusCode):
            asyncio.run(connect("other.example"))


def test_close_ends_the_server(ball):
    view = rr.view(ball, iso=5, browser=False)
    process, folder = view._process, pathlib.Path(view._folder.name)
    assert folder.exists()
    view.close()
    view.close()
    assert process.returncode == 0 and not folder.exists()
    with pytest.raises(rr.Error, match="has ended"):
        view.scene["style"] = "fast"


def test_the_server_ends_with_its_view_and_with_python(ball):
    process = rr.view(ball, iso=5, browser=False)._process
    assert process.wait(PATIENCE_S) == 0
    program = ("import numpy, os, rhoray as rr\n"
               "w = rr.view(rr.volume(numpy.arange(27.).reshape(3, 3, 3)), iso=5, browser=False)\n"
               "print(w._process.pid, flush=True)\n"
               "input()\n")
    for end in (signal.SIGKILL, signal.SIGINT, None):
        python = subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL)
        server = int(python.stdout.readline())
        os.kill(server, 0)
        python.send_signal(end) if end else python.stdin.close()
        python.wait(PATIENCE_S)
        deadline = time.monotonic() + PATIENCE_S
        while pathlib.Path(f"/proc/{server}/stat").exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        assert not pathlib.Path(f"/proc/{server}/stat").exists(), end
        python.stdout.close()
        if end:
            python.stdin.close()


def test_an_observer_that_raises_ends_nothing(viewer, capfd):
    seen = []
    viewer.observe(lambda view: seen[7])
    viewer.observe(lambda view: seen.append(view.scene["layers"][0]["isovalue"]))

    async def follow():
        async with Page(viewer) as page:
            for isovalue in (6, 7):
                await page.show({"layers": {"0": {"isovalue": isovalue}}})
                await until(lambda: isovalue in seen)
    asyncio.run(follow())
    assert capfd.readouterr().err.count("IndexError") >= 2


def test_observers_may_change_the_scene_and_close(viewer):
    ended = threading.Event()

    def answer(view):
        if view.scene["layers"][0]["isovalue"] == 7:
            view.scene["layers"][0]["isovalue"] = 8
            view.close()
            ended.set()
    viewer.observe(answer)

    async def follow():
        async with Page(viewer) as page:
            await page.show({"layers": {"0": {"isovalue": 7}}})
            await until(ended.is_set)
    asyncio.run(follow())
    assert viewer._process.returncode == 0
