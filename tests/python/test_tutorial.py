"""The tutorial of the guide: its scripts as a user runs them, and one of them as a notebook."""
import importlib.util
import json
import pathlib
import re
import subprocess
import sys

import pytest

GUIDE = pathlib.Path(__file__).resolve().parents[2] / "data/guide"
sys.path.insert(0, str(GUIDE))
import scripts  # noqa: E402

PATHS = sorted((GUIDE / "tutorial").glob("*.py"))
TIME_LIMIT_S = 120  # of a script; each takes less than 20 s on two quiet cores


@pytest.mark.parametrize("path", PATHS, ids=[path.stem for path in PATHS])
def test_scripts_do_what_they_claim_and_draw_whole_pictures(tmp_path, path):
    image_io = pytest.importorskip("skimage.io")
    script = scripts.read(path)
    assert any(line.startswith("assert ") for line in script.cells[-1].code)
    done = subprocess.run([sys.executable, path], cwd=tmp_path, capture_output=True, text=True, check=False,
                          timeout=TIME_LIMIT_S)
    assert (done.returncode, done.stderr) == (0, "")
    pictures = [name for cell in script.cells for name, _ in cell.pictures()]
    assert pictures
    for name in pictures:
        pixels = image_io.imread(tmp_path / name).astype(int)
        background = pixels[0, 0]
        is_drawn = (abs(pixels - background) > 2).any(axis=-1)
        frame = is_drawn.copy()
        frame[4:-4, 4:-4] = False
        assert not frame.any(), f"{name} is cut off"
        assert is_drawn.mean() > 0.15, f"{name} is nearly empty"
        assert len(set(map(tuple, pixels[is_drawn]))) > 100, f"{name} has few colours"
    if path.stem == "15-figure" and importlib.util.find_spec("matplotlib"):
        assert image_io.imread(tmp_path / "signal_accuracy.png").shape[:2] == (400, 600)


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    """The script of the CT as an executed notebook, with a cell that shows the viewer."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    book = nbformat.from_dict(scripts.notebook(scripts.read(GUIDE / "tutorial/11-ct.py")))
    book.cells.append(nbformat.v4.new_code_cell("rr.view(data, iso=-480, size=(320, 240))"))
    nbformat.validate(book)
    folder = tmp_path_factory.mktemp("notebook")
    nbclient.NotebookClient(book, timeout=TIME_LIMIT_S, kernel_name="python3",
                            resources={"metadata": {"path": str(folder)}}).execute()
    return book


def shown(book, kind):
    return [output.data[kind] for cell in book.cells if cell.cell_type == "code" for output in cell.outputs
            if kind in output.get("data", {})]


def test_a_notebook_shows_pictures_and_the_viewer(notebook):
    pictures = shown(notebook, "image/png")
    assert len(pictures) == 3 and len(set(pictures)) == 3
    assert all(picture.startswith("iVBORw0KGgo") for picture in pictures)  # PNG files in base64
    (frame,) = shown(notebook, "text/html")
    assert re.search(r'<iframe src="http://127\.0\.0\.1:\d+/[^"]*token=', frame)
    assert "the skin is at z = 93.98" in json.dumps(notebook)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # nbconvert calls nbformat in an old way
def test_a_notebook_becomes_a_page(notebook):
    nbconvert = pytest.importorskip("nbconvert")
    page, _ = nbconvert.HTMLExporter().from_notebook_node(notebook)
    assert page.count('src="data:image/png;base64,') == 3  # the last one is below the frame
    assert "<iframe src=" in page and "Skin and skull" in page
