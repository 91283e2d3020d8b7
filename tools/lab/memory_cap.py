#!/usr/bin/env python3
"""What `rhoray pack --memory` keeps to: packs a volume and a mesh eight times as large as the cap, samples the anonymous
memory of rhoray and of its workers meanwhile, and compares the file with that of a run without a cap.

    tools/lab/memory_cap.py --rhoray build/release/bin/rhoray --folder /scratch --cap 512M

Anonymous memory is RssAnon of /proc/PID/status: pages that the kernel could only drop by swapping them. Inputs are made in
the folder (up to 17 times the cap of free disk is used) and removed at the end.
"""

import argparse
import array
import hashlib
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib


def write_volume(path, edge, depth):
    """edge x edge x depth 16-bit samples, a ball with some texture; slices are made of one another to be quick."""
    rows = [array.array("H", ((i * i + j * j) // 37 % 4096 for i in range(edge))).tobytes() for j in range(edge)]
    with open(path, "wb") as out:
        for k in range(depth):
            out.write(b"".join(rows[(j + 7 * k) % edge] for j in range(edge)))
    return edge * edge * depth * 2


def tetrahedra_of_slab(n, k):
    """Six tetrahedra for each cube of layer k, all along the cube's diagonal."""
    def corner(c):
        return (c >> 2) * (n + 1) * (n + 1) + (c >> 1 & 1) * (n + 1) + (c & 1)
    pattern = [corner(c) for path in ((1, 2, 4), (2, 1, 4), (1, 4, 2), (4, 1, 2), (2, 4, 1), (4, 2, 1))
               for c in ((0, path[0], path[0] | path[1], 7) if path in ((1, 2, 4), (4, 1, 2), (2, 4, 1))
                         else (0, path[0] | path[1], path[0], 7))]
    corners = array.array("q")
    for j in range(n):
        for i in range(n):
            base = (k * (n + 1) + j) * (n + 1) + i
            corners.extend([base + c for c in pattern])
    return corners.tobytes()


class Appended:
    """Arrays appended to a VTU: raw, or packed by zlib in blocks of 32 KiB as VTK does."""

    block = 1 << 15

    def __init__(self, out, packed):
        self.out, self.packed = out, packed

    def write(self, pieces, byte_count):
        if not self.packed:
            self.out.write(struct.pack("<Q", byte_count))
            for piece in pieces:
                self.out.write(piece)
            return
        header_at = self.out.tell()
        count = -(-byte_count // self.block)
        self.out.write(bytes(8 * (3 + count)))
        sizes, rest = [], b""
        for piece in pieces:
            rest += piece
            while len(rest) >= self.block:
                sizes.append(self.out.write(zlib.compress(rest[:self.block], 1)))
                rest = rest[self.block:]
        if rest:
            sizes.append(self.out.write(zlib.compress(rest, 1)))
        end = self.out.tell()
        self.out.seek(header_at)
        self.out.write(struct.pack(f"<{3 + count}Q", count, self.block, byte_count % self.block, *sizes))
        self.out.seek(end)


def write_mesh(path, n, packed=False):
    """n^3 cubes of six tetrahedra with two fields, as an appended VTU. Offsets are patched in once they are known."""
    points, cells = (n + 1) ** 3, 6 * n ** 3
    names = ["position", "height", "ripple", "connectivity", "offsets", "types"]
    with open(path, "wb+") as out:
        def tag(kind, name, components=1):
            return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="appended" '
                    f'offset="{{{name}:<20}}"/>')
        head = (f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
                f'header_type="UInt64"{" compressor=" + chr(34) + "vtkZLibDataCompressor" + chr(34) if packed else ""}>\n'
                f'<UnstructuredGrid><Piece NumberOfPoints="{points}" NumberOfCells="{cells}">\n'
                f'<PointData>{tag("Float32", "height")}{tag("Float32", "ripple")}</PointData>\n'
                f'<Points>{tag("Float32", "position", 3)}</Points>\n'
                f'<Cells>{tag("Int64", "connectivity")}{tag("Int64", "offsets")}{tag("UInt8", "types")}</Cells>\n'
                f'</Piece></UnstructuredGrid>\n<AppendedData encoding="raw">\n_')
        length = len(head.format(**{name: 0 for name in names}))
        out.seek(length)
        appended, where = Appended(out, packed), {}

        def add(name, pieces, byte_count):
            where[name] = out.tell() - length
            appended.write(pieces, byte_count)

        plane = range((n + 1) * (n + 1))
        row = [i / n for i in range(n + 1)]
        add("height", (array.array("f", [row[k]] * len(plane)).tobytes() for k in range(n + 1)), 4 * points)
        add("ripple", (array.array("f", [(p * 31 + k * 17) % 1009 / 1009 for p in plane]).tobytes()
                       for k in range(n + 1)), 4 * points)
        add("position", (array.array("f", [x for j in range(n + 1) for i in range(n + 1)
                                           for x in (row[i], row[j], row[k])]).tobytes()
                         for k in range(n + 1)), 12 * points)
        add("connectivity", (tetrahedra_of_slab(n, k) for k in range(n)), 32 * cells)
        step = 6 * n * n
        add("offsets", (array.array("q", range(4 * (k * step + 1), 4 * (k + 1) * step + 1, 4)).tobytes()
                        for k in range(n)), 8 * cells)
        add("types", (b"\x0a" * step for k in range(n)), cells)
        out.write(b"\n</AppendedData>\n</VTKFile>\n")
        out.seek(0)
        out.write(head.format(**where).encode())
    return os.path.getsize(path)


def anonymous_bytes(pid):
    try:
        with open(f"/proc/{pid}/status") as status:
            for line in status:
                if line.startswith("RssAnon:"):
                    return int(line.split()[1]) << 10
    except (FileNotFoundError, ProcessLookupError):
        pass
    return 0


def children_of(pid):
    children = []
    try:
        for task in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{task}/children") as names:
                children += [int(name) for name in names.read().split()]
    except (FileNotFoundError, ProcessLookupError):
        pass
    return children


def run(words, folder):
    """Runs to the end; returns seconds, CPU seconds, and the largest RssAnon of the program and of any worker."""
    before = os.times()
    start = time.monotonic()
    peak = worker_peak = 0
    process = subprocess.Popen(words, cwd=folder)
    while process.poll() is None:
        peak = max(peak, anonymous_bytes(process.pid))
        worker_peak = max([worker_peak] + [anonymous_bytes(child) for child in children_of(process.pid)])
        time.sleep(0.005)
    after = os.times()
    if process.returncode != 0:
        sys.exit(f"{' '.join(words)}: ended with {process.returncode}")
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return time.monotonic() - start, cpu, peak, worker_peak


def digest(path):
    sha = hashlib.sha256()
    with open(path, "rb") as file:
        while piece := file.read(1 << 22):
            sha.update(piece)
    return sha.hexdigest()


def study(name, rhoray, words, input_bytes, cap_text, cap, folder):
    command = [rhoray, "pack", *words, "-o", "packed.rho", "-q"]
    digests, held = [], True
    for limit in ([], ["--memory", cap_text]):
        seconds, cpu, peak, worker_peak = run(command + limit, folder)
        digests.append(digest(os.path.join(folder, "packed.rho")))
        os.remove(os.path.join(folder, "packed.rho"))
        left = sorted(set(os.listdir(folder)) - {words[0]})
        print(f"{name:8} {input_bytes / 2**20:8.0f} MiB  cap {cap_text if limit else 'none':>6}  "
              f"{seconds:7.2f} s  {cpu:7.2f} s of CPU  anonymous: rhoray {peak / 2**20:7.1f} MiB, "
              f"worker {worker_peak / 2**20:7.1f} MiB  {digests[-1][:12]}", flush=True)
        if limit:
            held = max(peak, worker_peak) <= 1.1 * cap
        if left:
            sys.exit(f"found {left} left in the folder; expected nothing")
    if digests[0] != digests[1]:
        sys.exit(f"{name}: the capped run wrote other bytes")
    if not held:
        sys.exit(f"{name}: more anonymous memory than 1.1 times the cap")


def size_of(text):
    factor = {"K": 1 << 10, "M": 1 << 20, "G": 1 << 30}.get(text[-1], 1)
    return int(text[:-1] if factor > 1 else text) * factor


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rhoray", required=True, help="the program")
    parser.add_argument("--folder", default=".", help="where inputs and packed files are made")
    parser.add_argument("--cap", default="512M", help="the cap, such as 512M")
    parser.add_argument("--only", choices=["volume", "mesh"], help="one of the two")
    parser.add_argument("--packed", action="store_true", help="the mesh's arrays packed by zlib")
    options = parser.parse_args()
    cap, rhoray = size_of(options.cap), os.path.abspath(options.rhoray)
    folder = tempfile.mkdtemp(prefix="memory-cap-", dir=options.folder)
    try:
        if options.only != "mesh":
            edge = max(64, int((8 * cap / 2) ** (1 / 3)) // 16 * 16)
            depth = -(-8 * cap // (2 * edge * edge))
            size = write_volume(os.path.join(folder, "large.raw"), edge, depth)
            study("volume", rhoray, ["large.raw", "--raw", f"{edge}x{edge}x{depth}:uint16:le"], size, options.cap, cap,
                  folder)
            os.remove(os.path.join(folder, "large.raw"))
        if options.only != "volume":
            # 41 bytes of cells and 20 / 6 of points for each tetrahedron; as arrays in memory they
            # are twice as large.
            n = max(8, round((8 * cap / 2 / (6 * 41 + 20)) ** (1 / 3)))
            size = write_mesh(os.path.join(folder, "large.vtu"), n, options.packed)
            study("mesh", rhoray, ["large.vtu"], size, options.cap, cap, folder)
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
