#!/usr/bin/env bash
# YADE 2025.2.0 (Debian 13: yade 2025.2.0-1+b1; 2023.02a of Debian 12 likewise): a predicate that is asked for a sphere, as by
# regularHexa and randomDensePack, lets spheres stick out of most bodies. inGtsSurface tests the six points of the sphere along the axes,
# so that one beside a face across (1, 1, 1) passes with its center at 0.58 radii from it; inEllipsoid makes the half-axes shorter by
# the radius, which is no parallel surface; inHyperboloid makes its radii shorter in the horizontal plane, not across its wall.
# Of a hexagonal packing in an octahedron, 421 of 5,761 spheres stick out. inCylinder and inParallelepiped are exact.
# Seen on 2026-11-29: largest protrusions of 0.421, 0.137 and 0.253 radii, and 0.000 of inCylinder.
# Usage: findings/yade_predicate_padding.sh     needs root's apt and chroot and 500 MB of Debian 13's packages; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# Packages of Debian 13 into the folder root, with an apt of its own that knows nothing of this machine's packages.
mkdir -p apt/lists/partial apt/cache/archives/partial root
: >apt/status
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u)
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror trixie main" >apt/sources
trixie=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
        -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
        -o Acquire::Check-Valid-Until=false -o Acquire::Languages=none -o APT::Install-Recommends=false)
"${trixie[@]}" update
"${trixie[@]}" install --download-only -y yade=2025.2.0-1+b1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/padding.py <<'P'
import math
import os
import sys

import gts
from yade import *
from yade import pack

vertices, edges, surface = {}, {}, gts.Surface()


def edge(a, b):
    for p in (a, b):
        if p not in vertices:
            vertices[p] = gts.Vertex(*p)
    key = min(a, b), max(a, b)
    if key not in edges:
        edges[key] = gts.Edge(vertices[key[0]], vertices[key[1]])
    return edges[key]


for x in (-3.0, 3.0):
    for y in (-3.0, 3.0):
        for z in (-3.0, 3.0):
            corners = [(x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)]
            a, b, c = corners if x * y * z > 0 else corners[::-1]
            surface.add(gts.Face(edge(a, b), edge(b, c), edge(c, a)))
print("octahedron of volume %g" % surface.volume())


def protrusion(predicate, radius, centers, depth):
    """Of the spheres that pass, in radii."""
    return max([0] + [(radius - depth(c)) / radius for c in centers if predicate(Vector3(*c), radius)])


def grid(low, high, steps):
    return [[lo + (hi - lo) * k / steps for k in range(steps + 1)] for lo, hi in zip(low, high)]


def nearest(curve, x, y):
    return min(math.hypot(x - u, y - v) for u, v in curve)


def in_octahedron(c):
    return (3 - sum(abs(q) for q in c)) / math.sqrt(3)


along = [(k / 1000, k / 1000, k / 1000) for k in range(1001)]
print("inGtsSurface: %.3f" % protrusion(pack.inGtsSurface(surface), 0.5, along, in_octahedron))
bodies = pack.regularHexa(pack.inGtsSurface(surface), radius=0.1, gap=0)
out = sum(in_octahedron(b.state.pos) < 0.1 - 1e-9 for b in bodies)
print("regularHexa: %d of %d stick out" % (out, len(bodies)))

ellipse = [(3 * math.cos(u), math.sin(u)) for u in (k * math.pi / 2000 for k in range(1001))]
xs, ys = grid((0, 0), (3, 1), 60)
print("inEllipsoid: %.3f" % protrusion(pack.inEllipsoid((0, 0, 0), (3, 1, 1)), 0.2, [(x, y, 0) for x in xs for y in ys],
                                       lambda c: nearest(ellipse, c[0], c[1])))
profile = [(math.sqrt(0.25 + 3.75 * (z / 2) ** 2), z) for z in (-2 + k / 250 for k in range(1001))]
xs, zs = grid((0, -2), (2, 2), 80)
inside = [(x, 0, z) for x in xs for z in zs if x < math.sqrt(0.25 + 3.75 * (z / 2) ** 2)]
print("inHyperboloid: %.3f" % protrusion(pack.inHyperboloid((0, 0, -2), (0, 0, 2), 2, 0.5), 0.2, inside,
                                         lambda c: min(2 - abs(c[2]), nearest(profile, c[0], c[2]))))
xs, zs = grid((0, -2), (1, 2), 80)
print("inCylinder: %.3f" % protrusion(pack.inCylinder((0, 0, -2), (0, 0, 2), 1), 0.2, [(x, 0, z) for x in xs for z in zs],
                                      lambda c: min(2 - abs(c[2]), 1 - c[0]) + 1e-12))
sys.stdout.flush()
os._exit(0)
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack:$lib/openblas-pthread HOME=/tmp UCX_LOG_LEVEL=fatal \
    /usr/bin/python3 /usr/bin/yade -n -x -j1 /padding.py 2>messages | grep -E "^(octahedron|in|regular)" | tee seen
diff seen - <<'E' || exit 1
octahedron of volume 36
inGtsSurface: 0.421
regularHexa: 421 of 5761 stick out
inEllipsoid: 0.137
inHyperboloid: 0.253
inCylinder: 0.000
E
