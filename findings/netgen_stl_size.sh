#!/usr/bin/env bash
# Netgen 6.2.1905 (Debian 12: python3-netgen 6.2.2006+really6.2.1905+dfsg-5.1+b1), netgen.stl from Python. LoadSTLGeometry reads a .stl as text, whatever
# is in it: of a binary file it takes no triangle, and GenerateMesh then makes a mesh of no points, says "Success !!!!", and raises nothing.
# maxh of MeshingParameters is no bound for the elements of a surface: a cube of 10 mm becomes six tetrahedra with edges of up to 17.3 mm whether maxh is
# 1, 2 or 5 mm, and in a ball of 1280 triangles edges are three to four times as long as maxh. The surface is meshed anew with such elements, so
# that volume goes: the ball keeps 98 % at maxh = 1 mm and 89 % at 3 mm, though its own triangles are 1.6 mm long.
# Seen on 2026-12-01: the lines below. (Tetrahedra count negative by the right-hand rule, as they always do in Netgen.)
# Usage: findings/netgen_stl_size.sh     needs python3, root's apt and chroot; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# Packages into the folder root, with an apt of its own that knows nothing of this machine's packages.
mkdir -p apt/lists/partial apt/cache/archives/partial root
: >apt/status
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u)
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror bookworm main" >apt/sources
bookworm=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
          -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
          -o Acquire::Check-Valid-Until=false -o Acquire::Languages=none -o APT::Install-Recommends=false)
"${bookworm[@]}" update
"${bookworm[@]}" install --download-only -y python3-netgen=6.2.2006+really6.2.1905+dfsg-5.1+b1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done
mkdir -p root/tmp
for library in $(ls -d root/usr/lib/*/blas root/usr/lib/*/lapack root/usr/lib/*/netgen 2>/dev/null); do echo "${library#root}"; done | paste -sd: >libraries

cat >root/solids.py <<'P'
import struct


def ball():
    """An icosahedron with each triangle in four, three times, its corners on a ball of radius 10 mm."""
    golden = (1 + 5**0.5) / 2
    points = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden), (0, 1, golden), (0, -1, -golden),
              (0, 1, -golden), (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)]
    edges = [(i, j) for i in range(12) for j in range(i) if abs(sum((a - b)**2 for a, b in zip(points[i], points[j])) - 4) < 1e-9]
    faces = [(i, j, k) for i, j in edges for k in range(j) if (i, k) in edges and (j, k) in edges]

    def out(p):
        return tuple(10 * c / sum(d * d for d in p)**0.5 for c in p)

    triangles = [tuple(out(points[i]) for i in face) for face in faces]
    for _ in range(3):
        finer = []
        for a, b, c in triangles:
            x, y, z = (out([p + q for p, q in zip(u, v)]) for u, v in ((a, b), (b, c), (c, a)))
            finer += [(a, x, z), (x, b, y), (z, y, c), (x, y, z)]
        triangles = finer
    return triangles


def cube():
    corner = [(x, y, z) for z in (0, 10) for y in (0, 10) for x in (0, 10)]
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    return [tuple(corner[i] for i in face) for face in faces]


def normal(t):
    u, v = ([t[k][i] - t[0][i] for i in range(3)] for k in (1, 2))
    n = [u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3)]
    return n


def outward(triangles, middle):
    for t in triangles:
        away = sum(a * (b - m) for a, b, m in zip(normal(t), t[0], middle))
        yield t if away > 0 else (t[0], t[2], t[1])


for name, triangles in (("ball", list(outward(ball(), (0, 0, 0)))), ("cube", list(outward(cube(), (5, 5, 5))))):
    with open(name + ".text.stl", "w") as text:
        text.write("solid a\n")
        for t in triangles:
            text.write("facet normal %r %r %r\nouter loop\n" % tuple(normal(t)))
            text.writelines("vertex %.9g %.9g %.9g\n" % p for p in t)
            text.write("endloop\nendfacet\n")
        text.write("endsolid a\n")
    with open(name + ".binary.stl", "wb") as binary:
        binary.write(bytes(80) + struct.pack("<I", len(triangles)))
        for t in triangles:
            binary.write(struct.pack("<12fH", *normal(t), *t[0], *t[1], *t[2], 0))
P
cat >root/meshes.py <<'P'
import math
import netgen.stl
from netgen.meshing import MeshingParameters


def meshed(name, size):
    mesh = netgen.stl.GenerateMesh(netgen.stl.LoadSTLGeometry(name + ".stl"), MeshingParameters(maxh=size))
    points = [tuple(point.p) for point in mesh.Points()]
    volume = longest = 0
    for element in mesh.Elements3D():
        a, b, c, d = (points[v.nr - 1] for v in list(element.vertices)[:4])
        u, v, w = ([q - p for p, q in zip(a, other)] for other in (b, c, d))
        volume -= sum(u[i] * (v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3]) for i in range(3)) / 6
        longest = max([longest] + [math.dist(p, q) for p in (a, b, c, d) for q in (a, b, c, d)])
    print("mesh: %s, maxh %g: %d tetrahedra, %.0f mm3, edges up to %.1f mm" % (name, size, len(list(mesh.Elements3D())), volume, longest), flush=True)


for name, sizes in (("cube.text", (1, 2, 5)), ("ball.text", (1, 3)), ("cube.binary", (1,)), ("ball.binary", (1,))):
    for size in sizes:
        meshed(name, size)
P
for script in solids meshes; do
    chroot root /usr/bin/env -C /tmp LD_LIBRARY_PATH="$(cat libraries)" HOME=/tmp python3 /$script.py >all 2>&1 || { tail all; exit 1; }
done
grep -a "^mesh: " all | tee seen
diff seen - <<'E' || exit 1
mesh: cube.text, maxh 1: 6 tetrahedra, 1000 mm3, edges up to 17.3 mm
mesh: cube.text, maxh 2: 6 tetrahedra, 1000 mm3, edges up to 17.3 mm
mesh: cube.text, maxh 5: 6 tetrahedra, 1000 mm3, edges up to 17.3 mm
mesh: ball.text, maxh 1: 9732 tetrahedra, 4068 mm3, edges up to 3.8 mm
mesh: ball.text, maxh 3: 141 tetrahedra, 3693 mm3, edges up to 11.7 mm
mesh: cube.binary, maxh 1: 0 tetrahedra, 0 mm3, edges up to 0.0 mm
mesh: ball.binary, maxh 1: 0 tetrahedra, 0 mm3, edges up to 0.0 mm
E
