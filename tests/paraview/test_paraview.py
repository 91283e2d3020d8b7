"""The ParaView reader in pvpython and pvserver."""
import os
import pathlib
import socket
import subprocess
import textwrap
import time
import unittest

import numpy as np

from support import PATIENCE_S, PLUGIN, Packed, RHORAY, box_of_tetrahedra, numbered, run, write_tetrahedra
from rhoray_reader import RhorayReader


class ParaView(Packed):
    """The plugin in pvpython and pvserver."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        site = cls.folder / "base/lib/python3.11/site-packages"
        site.mkdir(parents=True)
        # As tools/paraview/README.md tells users to do.
        (site / "usercustomize.py").write_text("import inspect; inspect.getargspec = inspect.getfullargspec\n")
        cls.environment = {**os.environ, "PYTHONUSERBASE": str(cls.folder / "base"), "PYTHONDONTWRITEBYTECODE": "1"}
        np.save(cls.folder / "made.npy", numbered(9, 8, 7))
        points, cells = box_of_tetrahedra(3)
        write_tetrahedra(cls.folder / "made.vtk", points, cells,
                         [("height", points[:, 2].astype("f4")), ("square", (points**2).sum(1))])
        for name, source in (("grid", "made.npy"), ("mesh", "made.vtk")):
            run(RHORAY, "pack", cls.folder / source, "-o", cls.folder / f"{name}.rho", "--quiet")

    def pvpython(self, script, **environment):
        """The output of a script that begins with these lines."""
        start = f"from paraview.simple import *\nplugin = {str(PLUGIN)!r}\nfolder = {str(self.folder)!r}\n"
        done = subprocess.run(["pvpython", "-c", start + textwrap.dedent(script)], capture_output=True, text=True,
                              env={**self.environment, **environment}, timeout=PATIENCE_S)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split("\n")[:-1]

    SHOW = """
        for name in ("grid", "mesh"):
            reader = OpenDataFile(f"{folder}/{name}.rho")
            reader.UpdatePipeline()
            info = reader.GetDataInformation()
            print(type(reader).__name__, info.GetDataSetTypeAsString(), info.GetNumberOfPoints(),
                  info.GetNumberOfCells(), *sorted(reader.PointData.keys()))
        """
    SHOWN = ["RhorayReader vtkImageData 504 336 made", "RhorayReader vtkUnstructuredGrid 64 162 height square"]

    def test_a_script_loads_the_plugin_and_opens_files(self):
        self.assertEqual(self.pvpython("LoadPlugin(plugin, ns=globals())\n" + textwrap.dedent(self.SHOW)), self.SHOWN)

    def test_the_plugin_is_found_in_a_folder(self):
        self.assertEqual(self.pvpython(self.SHOW, PV_PLUGIN_PATH=str(PLUGIN.parent)), self.SHOWN)

    def test_fields_are_chosen_and_another_file_is_opened(self):
        self.assertEqual(self.pvpython("""
            LoadPlugin(plugin, ns=globals())
            reader = RhorayReader(FileName=f"{folder}/mesh.rho", PointArrayStatus=["square"])
            for chosen in (None, ["height"], [], ["height", "square"]):
                if chosen is not None:
                    reader.PointArrayStatus = chosen
                reader.UpdatePipeline()
                print(*sorted(reader.PointData.keys()), sep=",")
            reader.FileName = f"{folder}/grid.rho"
            reader.UpdatePipeline()
            print(*reader.PointArrayStatus.Available, *reader.PointData.keys())
            contour = Contour(Input=reader, ContourBy="made", Isosurfaces=[100.5])
            x, y, z = servermanager.Fetch(contour).GetPoint(20)
            print(abs(x + 9 * y + 72 * z - 100.5) < 1e-4)
            """), ["square", "height", "", "height,square", "made made", "True"])

    def test_a_server_reads_the_file(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        server = subprocess.Popen(["pvserver", f"--server-port={port}"], stdout=subprocess.DEVNULL,
                                  env=self.environment)
        try:
            end = time.monotonic() + PATIENCE_S
            while time.monotonic() < end and f":{port:04X} 00000000:0000 0A" not in \
                    pathlib.Path("/proc/net/tcp").read_text() + pathlib.Path("/proc/net/tcp6").read_text():
                time.sleep(0.1)
            shown = self.pvpython(f"Connect('127.0.0.1', {port})\nLoadPlugin(plugin, remote=True, ns=globals())\n"
                                  + textwrap.dedent(self.SHOW))
            self.assertEqual([line for line in shown if line.startswith("Rhoray")], self.SHOWN)
            server.wait(PATIENCE_S)  # it ends with its client
        finally:
            server.kill()
            server.wait()

    def test_of_several_processes_the_first_reads(self):
        for name in ("grid", "mesh"):
            counts = []
            for piece in (0, 1, 2):
                reader = RhorayReader()
                reader.SetFileName(str(self.folder / f"{name}.rho"))
                reader.UpdatePiece(piece, 3, 0)
                counts.append(reader.GetOutputDataObject(0).GetNumberOfCells())
            self.assertEqual(counts, [336 if name == "grid" else 162, 0, 0], name)


if __name__ == "__main__":
    unittest.main()
