#!/usr/bin/env bash
# numpy-stl 2.9.0 (Debian 13: python3-stl 2.9.0-2+b7): Mesh.from_file of a .stl of text reads the first solid and leaves out the others, as those of
# an implant or of further bones in the same file; so does what is written from it. from_multi_file reads all. is_closed, and the check of
# get_mass_properties, only ask whether the sum of normals times areas has no component above 0. So a tube that is open at both ends, as a shaft
# cut off at both, is closed, and so is one whose hole looks along +x, +y or +z; one whose hole looks the other way is not.
# rotate, and rotate_using_matrix with the matrix of a rotation, turn the other way than the right-hand rule, and than transform with the same
# matrix. No message, but for holes that are seen.
# Seen on 2026-12-01: "two solids of 1 and 2 mm3: from_file 1, written from it 1, from_multi_file 1 2" and the lines below.
# Usage: findings/numpy_stl_first_solid.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y python3-stl=2.9.0-2+b7 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/solids.py <<'P'
import math

import numpy
from stl import Mode
from stl.mesh import Mesh


def block(x, length):
    """Twelve triangles that face outward, those of its two ends along z last."""
    corners = [(x + length * (i & 1), i >> 1 & 1, i >> 2) for i in range(8)]
    sides = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
    return [[corners[i] for i in three] for a, b, c, d in sides for three in ((a, b, c), (a, c, d))]


def mesh(triangles):
    made = Mesh(numpy.zeros(len(triangles), dtype=Mesh.dtype))
    made.vectors[:] = triangles
    made.update_normals()
    return made


def volume(it):
    return "%g" % it.get_mass_properties()[0]


with open("/two.stl", "w") as out:
    for name, triangles in (("bone", block(0, 1)), ("screw", block(3, 2))):
        print("solid", name, file=out)
        for three in triangles:
            print("facet normal 0 0 0\nouter loop", file=out)
            for corner in three:
                print("vertex %d %d %d" % corner, file=out)
            print("endloop\nendfacet", file=out)
        print("endsolid", name, file=out)
first = Mesh.from_file("/two.stl")
first.save("/one.stl", mode=Mode.BINARY)
print("two solids of 1 and 2 mm3: from_file %s, written from it %s, from_multi_file %s" % (
    volume(first), volume(Mesh.from_file("/one.stl")), " ".join(volume(m) for m in Mesh.from_multi_file("/two.stl"))))

all_sides = block(0, 1)
for name, left in (("whole", all_sides), ("without both ends", all_sides[:8]), ("without the upper end", all_sides[:10]),
                   ("without the lower end", all_sides[:8] + all_sides[10:])):
    print("block %s: %d triangles, is_closed %s" % (name, len(left), mesh(left).is_closed()))

turn = numpy.eye(4)
turn[:2, :2] = [[math.cos(math.pi / 6), -math.sin(math.pi / 6)], [math.sin(math.pi / 6), math.cos(math.pi / 6)]]
for name, how in (("rotate", lambda m: m.rotate([0, 0, 1], math.pi / 6)),
                  ("rotate_using_matrix", lambda m: m.rotate_using_matrix(turn[:3, :3])),
                  ("transform", lambda m: m.transform(turn))):
    bone = mesh([[(1, 0, 0), (0, 1, 0), (0, 0, 1)]])
    how(bone)
    print("(1, 0, 0) by 30 degrees about z, %s: (%.3f, %.3f, %.3f)" % (name, *bone.vectors[0][0]))
P
chroot root /usr/bin/env LD_LIBRARY_PATH=/usr/lib/x86_64-linux-gnu/blas:/usr/lib/x86_64-linux-gnu/lapack /usr/bin/python3 /solids.py | tee seen
diff seen - <<'E' || exit 1
two solids of 1 and 2 mm3: from_file 1, written from it 1, from_multi_file 1 2
block whole: 12 triangles, is_closed True
block without both ends: 8 triangles, is_closed True
block without the upper end: 10 triangles, is_closed True
block without the lower end: 10 triangles, is_closed False
(1, 0, 0) by 30 degrees about z, rotate: (0.866, -0.500, 0.000)
(1, 0, 0) by 30 degrees about z, rotate_using_matrix: (0.866, -0.500, 0.000)
(1, 0, 0) by 30 degrees about z, transform: (0.866, 0.500, 0.000)
E
