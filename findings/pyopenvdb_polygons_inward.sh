#!/usr/bin/env bash
# pyopenvdb 10.0.1 (Debian 13: python3-openvdb 10.0.1-2.3+b1): the polygons that convertToQuads and convertToPolygons make of a level set
# are ordered clockwise as seen from outside, so that their normals point into the solid. The volume by the divergence theorem
# is negative, and programs that take the order at its word (slicers, signed distances, packers) see a hole in the place of a bone.
# No flag, and no word in the docstring. Turning each row (quads[:, ::-1]) is the cure. createLevelSetFromPolygons takes either order, so a
# round trip does not show it. (volumeToMesh of the C++ library orders its polygons so.)
# Seen on 2026-11-29: a ball of radius 5 in voxels of 0.25 has a volume of -522 (right: 523.6), with adaptivity 0.5 -479.
# Usage: findings/pyopenvdb_polygons_inward.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y python3-openvdb=10.0.1-2.3+b1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do dpkg -x "$package" root; done

cat >root/polygons.py <<'P'
import numpy
import pyopenvdb

def volume(points, quads, triangles=()):
    points, faces = numpy.asarray(points, float), [list(t) for t in triangles]
    for a, b, c, d in quads:
        faces += [[a, b, c], [a, c, d]]
    a, b, c = (points[[face[k] for face in faces]] for k in range(3))
    return (a * numpy.cross(b, c)).sum() / 6

cube = numpy.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
outward = numpy.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]], "uint32")
print(f"a cube of faces in order: {volume(cube, outward):+.3g}")
ball = pyopenvdb.createLevelSetSphere(radius=5, voxelSize=0.25)
points, quads = ball.convertToQuads()
print(f"a ball of 523.6, quads: {volume(points, quads):+.0f}, each turned: {volume(points, quads[:, ::-1]):+.0f}")
points, triangles, quads = ball.convertToPolygons(adaptivity=0.5)
print(f"with adaptivity: {volume(points, quads, triangles):+.0f}")
small = pyopenvdb.createLinearTransform(0.05)
for name, faces in (("in order", outward), ("turned", outward[:, ::-1].copy())):
    grid = pyopenvdb.FloatGrid.createLevelSetFromPolygons(cube, quads=faces, transform=small)
    print(f"level set of the cube {name}: {grid.getAccessor().getValue((10, 10, 19)):+.2f} inside")
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack /usr/bin/python3 /polygons.py | tee seen
diff seen - <<'E' || exit 1
a cube of faces in order: +1
a ball of 523.6, quads: -522, each turned: +522
with adaptivity: -479
level set of the cube in order: -0.05 inside
level set of the cube turned: -0.05 inside
E
