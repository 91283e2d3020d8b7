"""The viewer in a browser, from Python: both can change what it shows."""
import base64
import json
import os
import pathlib
import tempfile
import threading
import traceback
import urllib.parse
import weakref

from rhoray import _program, _scenes
from rhoray._data import Data
from rhoray._errors import Error, UsageError
from rhoray._pictures import render


def view(what, *, data=None, port=None, hosts=(), browser=None, **options):
    """Shows data or a scene in a page of the browser, and returns a View.

    what, data and the options are those of `render`.
    port: on this machine's loopback interface; None: a free one.
    hosts: names of proxies under which the page is reached, such as that of a notebook hub.
    browser: whether to open the page; None: where there is a screen, unless in a notebook.
    """
    return View(what, data=data, port=port, hosts=hosts, browser=browser, **options)


class View:
    """A page that shows data, until `close` or the end of Python.

    `scene` is what the page shows, as a scene document. Changes of it appear in the page, and changes
    that the user makes in the page appear in it:

        w = rr.view(v, iso=0.25)
        w.scene["layers"][0]["isovalue"] = 0.3
        w.scene["camera"]["position"]          # after a drag in the page, that of the page
        w.picture(size=(1024, 768)).save("figure.png")
    """

    def __init__(self, what, *, data=None, port=None, hosts=(), browser=None, **options):
        import subprocess  # only here and in `close`: importing it takes time
        document, known = _scenes.read(what, data, options, "view")
        known = _scenes.opened(document, known)
        document = _scenes.with_paths(document, known)
        self._data = known
        title = what.kind if isinstance(what, Data) else "scene" if isinstance(what, dict) else pathlib.Path(what).stem
        self._folder = tempfile.TemporaryDirectory(prefix="rhoray-view-")
        folder = pathlib.Path(self._folder.name)
        path = folder / f"{title}.json"
        path.write_text(_scenes.text_of(document, "view"), encoding="utf-8")
        words = ["--stdio"]
        if port is not None:
            words += ["--port", str(port)]
        if hosts:
            words += ["--allow-host", ",".join([hosts] if isinstance(hosts, str) else hosts)]
        if browser is False or (browser is None and _is_notebook()):
            words.append("--no-browser")
        self._guard = threading.RLock()
        self._observers = []
        self._number = 0
        with (folder / "messages").open("wb") as messages:
            # A session of its own: Ctrl+C in a terminal does not end it.
            self._process = subprocess.Popen([_program.path(), "view", str(path), *words], stdin=subprocess.PIPE,
                                             stdout=subprocess.PIPE, stderr=messages, start_new_session=True)
        weakref.finalize(self, self._process.stdin.close)  # which ends the server
        self.url = self._first("url", path)
        hello = self._first("hello", path)
        files = {name: {"file": spec["file"]} for name, spec in document["data"].items()}  # no client is told them
        self._document, self._start = _merged(hello["document"], {"data": files}), hello["camera"]
        self._patch, self._camera = {}, self._start
        self.size = None
        self.error = None
        self._reader = threading.Thread(target=_read, args=(self._process.stdout, weakref.ref(self)), daemon=True)
        self._reader.start()

    def _first(self, key, scene):
        """One of the first messages of the server. It ends when the scene is wrong."""
        line = self._process.stdout.readline()
        if line:
            return json.loads(line)[key]
        code = self._process.wait()
        self._process.stdin.close()
        self._process.stdout.close()
        messages = (scene.parent / "messages").read_text(encoding="utf-8", errors="replace")
        of_scene = f"{scene}: "
        if of_scene in messages:
            code = 2
        raise _program.error_in(messages.replace(of_scene, "scene: "), code)

    @property
    def scene(self):
        """What is shown, a scene document as a dict. Assign to its parts, or a whole document to it."""
        with self._guard:
            return _Scene(self)

    @scene.setter
    def scene(self, document):
        with self._guard:
            self._change(_difference(self._numbered(), _with_numbers(document)))

    def picture(self, size=None, channels=()):
        """Renders what is shown. size: (width, height); None: that of the page."""
        with self._guard:
            document = _with_list(self._numbered())
        size = size or self.size
        if size is not None:
            document["image"] = {**document.get("image", {}), "size": list(size)}
        return render(document, data=self._data, channels=channels)

    def observe(self, function):
        """Calls function(view) after each change in the page, on another thread. Returns a function that ends it.

        An exception in it is printed, and ends nothing.
        """
        self._observers.append(function)
        return lambda: self._observers.remove(function)

    def close(self):
        """Ends the server. The page keeps its last picture."""
        import subprocess
        try:
            self._process.stdin.close()  # which ends the server
        except BrokenPipeError:
            pass
        try:
            self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if threading.current_thread() is not self._reader:
            self._reader.join()
            self._process.stdout.close()
        self._folder.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        self.close()

    def __repr__(self):
        return f"<rhoray.View: {self.url}>"

    def _repr_mimebundle_(self, include=None, exclude=None):
        import html  # only here: importing it takes time
        png = self.picture()._repr_png_()
        url = html.escape(self._page())
        port = urllib.parse.urlsplit(self.url).port
        return {"image/png": png, "text/plain": repr(self), "text/html": (
            f'<iframe src="{url}" title="Rhoray" width="100%" height="600" style="border: 0"></iframe>'
            f'<p>Nothing above? Open <a href="{url}" target="_blank">the page</a>; from another machine first: '
            f'<code>ssh -N -L {port}:127.0.0.1:{port} {html.escape(os.uname().nodename)}</code></p>'
            f'<details open><summary>Picture</summary><img alt="what the page showed at first" '
            f'src="data:image/png;base64,{base64.b64encode(png).decode()}"></details>')}

    def _page(self):
        """The page's address for a notebook: below the proxy of its hub, where there is one."""
        prefix, parts = os.environ.get("JUPYTERHUB_SERVICE_PREFIX"), urllib.parse.urlsplit(self.url)
        return f"{prefix.rstrip('/')}/proxy/{parts.port}/#{parts.fragment}" if prefix else self.url

    def _numbered(self):
        """The scene as a document whose layers have numbers, with the camera."""
        return {**_merged(self._document, self._patch), "camera": dict(self._camera)}

    def _change(self, patch):
        """Merges a patch into the scene, and sends it to the page."""
        with self._guard:
            document = _merged(self._numbered(), patch)
            camera = document.pop("camera", {})
            if not isinstance(camera, dict):
                raise UsageError(f"camera: found {type(camera).__name__}; expected a dict")
            given = (patch or {}).get("camera") or {}
            for new, old in (("fov", "ortho_height"), ("ortho_height", "fov")):
                if given.get(new) is not None:
                    camera.pop(old, None)
            missing = {"position", "target", "up"} - set(camera)
            if missing or len(camera) != 4 or not {"fov", "ortho_height"} & set(camera):
                raise UsageError(f"camera: {', '.join(camera) or 'nothing'}; expected position, target, up, and fov or "
                                 "ortho_height")
            scene = _difference(self._document, document) or {}
            text = _scenes.text_of({"set": {"n": self._number + 1, "camera": camera, "scene": scene}}, "scene")
            sent = json.loads(text)["set"]
            try:
                self._process.stdin.write(text.encode() + b"\n")
                self._process.stdin.flush()
            except (BrokenPipeError, ValueError):
                raise Error("the viewer has ended", 1) from None
            self._number, self._camera, self._patch = sent["n"], sent["camera"], sent["scene"]
            self.error = None

    def _take(self, message):
        with self._guard:  # an error of a change that is being sent comes after it
            if "error" in message:
                self.error = message["error"]
                return
            state = message["state"]
            if state["n"] < self._number:
                return
            self._patch, self._camera = state["scene"], state.get("camera", self._start)
            self.size, self.error = tuple(state["size"]), None
        for function in list(self._observers):
            try:
                function(self)
            except Exception:  # noqa: BLE001  (any of the user's; the next message comes on this thread)
                traceback.print_exc()


def _read(stream, viewer):
    """Takes the server's messages, until it or the View ends."""
    for line in stream:
        view = viewer()
        if view is None:
            return
        view._take(json.loads(line))
        del view


def _is_notebook():
    try:
        return type(get_ipython()).__name__ == "ZMQInteractiveShell"
    except NameError:
        return False


# ---- documents that tell their changes -----------------------------------------------------------

def _telling(base, names):
    """A subclass of dict or list whose methods `names` tell `_root` when they have changed something."""
    def method(name):
        plain = getattr(base, name)

        def act(self, *values, **named):
            result = plain(self, *values, **named)
            _adopt(self, self._root)
            self._root._tell()
            return result
        return act

    def reduced(self):
        return base, (base(self),)  # copies and pickles are plain

    return type(f"_Telling{base.__name__.title()}", (base,),
                {"_root": None, "__reduce__": reduced, **{name: method(name) for name in names}})


_Dict = _telling(dict, ("__setitem__", "__delitem__", "__ior__", "clear", "pop", "popitem", "setdefault", "update"))
_List = _telling(list, ("__setitem__", "__delitem__", "__iadd__", "__imul__", "append", "clear", "extend", "insert",
                        "pop", "remove", "reverse", "sort"))


def _adopt(container, root):
    """Makes all containers in this one tell the root."""
    container._root = root
    items = container.items() if isinstance(container, dict) else enumerate(container)
    for key, value in list(items):
        if isinstance(value, (dict, list)) and getattr(value, "_root", None) is not root:
            adopted = (_Dict if isinstance(value, dict) else _List)(value)
            _adopt(adopted, root)
            (dict if isinstance(container, dict) else list).__setitem__(container, key, adopted)


class _Scene(_Dict):
    """The scene of a View. A change of any part is sent to the page."""

    def __init__(self, view):
        super().__init__(_with_list(view._numbered()))
        self._view = view
        self._seen = view._numbered()
        _adopt(self, self)

    def _tell(self):
        now = json.loads(_scenes.text_of(_with_numbers(self), "scene"))
        patch = _difference(self._seen, now)
        if patch is not None:
            self._view._change(patch)
            self._seen = now


def _with_numbers(document):
    """A document whose layers are a dict by number, so that a merge patch can change one of them."""
    if not isinstance(document, dict):
        raise UsageError(f"scene: found {type(document).__name__}; expected a dict")
    layers = document.get("layers", [])
    if not isinstance(layers, list):
        raise UsageError(f"layers: found {type(layers).__name__}; expected a list")
    return {**document, "layers": {str(i): layer for i, layer in enumerate(layers)}}


def _with_list(document):
    return {**document, "layers": [document["layers"][str(i)] for i in range(len(document["layers"]))]}


def _merged(target, patch):
    """JSON Merge Patch (RFC 7386): None removes a key."""
    if not isinstance(patch, dict):
        return patch
    result = dict(target) if isinstance(target, dict) else {}
    for key, value in patch.items():
        if value is None:
            result.pop(key, None)
        else:
            result[key] = _merged(result.get(key), value)
    return result


def _difference(old, new):
    """The merge patch that makes `new` of `old`; None: they are equal."""
    if old == new:
        return None
    if not isinstance(old, dict) or not isinstance(new, dict):
        return new
    changed = {key: _difference(old.get(key), value) for key, value in new.items() if old.get(key) != value}
    return {**dict.fromkeys(old.keys() - new.keys()), **changed}
