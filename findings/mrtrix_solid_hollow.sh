#!/usr/bin/env bash
# MRtrix3 3.0.4 (Debian 13: mrtrix3 3.0.4-1+b1): mesh2voxel, which makes an image of the parts of voxels that are within a closed mesh, leaves solids
# hollow where their triangles are large for the voxels: the voxels that the surface passes are right, those within are 0 like those outside. Whether
# that happens depends on how the solid is turned. A block of 8 mm of 12 triangles in voxels of 1 mm has 512 mm3 as it lies along the axes or
# turned by 20 degrees, 204 turned by 30 and 231 turned by 45; with each triangle cut into four, the same block has 511 or 512 each time. A shaft
# of 24 sides that leaves the image at both ends has 477 mm3 in it where each side is two triangles from end to end, and 2237 (right: 2236)
# with one more ring of corners in the middle. A cut face, a plate, a screw or a decimated bone may lose most of its volume so.
# No message, exit status 0, and the same with "-nthreads 0".
# Seen on 2026-12-01: "block turned by 30: 204 mm3, each triangle in four: 512 mm3", "shaft through the image: 477 mm3, ...", and the lines below.
# Usage: findings/mrtrix_solid_hollow.sh     needs python3, root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y mrtrix3=3.0.4-1+b1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done


cat >solids.py <<'P'
import math
import struct
import subprocess


def written(points, triangles):
    with open("root/solid.obj", "w") as out:
        for p in points:
            print("v %.9g %.9g %.9g" % tuple(p), file=out)
        for t in triangles:
            print("f %d %d %d" % tuple(i + 1 for i in t), file=out)


def finer(points, triangles):
    """Each triangle in four: the same solid."""
    points, middles, four = list(points), {}, []

    def middle(a, b):
        key = min(a, b), max(a, b)
        if key not in middles:
            middles[key] = len(points)
            points.append([(points[a][k] + points[b][k]) / 2 for k in range(3)])
        return middles[key]

    for a, b, c in triangles:
        x, y, z = middle(a, b), middle(b, c), middle(c, a)
        four += [(a, x, z), (x, b, y), (z, y, c), (x, y, z)]
    return points, four


def prism(corners, heights):
    """A solid over a polygon, with a ring of corners at each height and fans at its ends."""
    n, last = len(corners), len(corners) * (len(heights) - 1)
    points = [(x, y, z) for z in heights for x, y in corners]
    triangles = []
    for k in range(0, last, n):
        for i in range(n):
            j = (i + 1) % n
            triangles += [(k + i, k + j, k + n + j), (k + i, k + n + j, k + n + i)]
    for i in range(1, n - 1):
        triangles += [(0, i + 1, i), (last, last + i, last + i + 1)]
    return points, triangles


def polygon(n, radius, x, y, turn):
    angles = [math.radians(turn) + 2 * math.pi * i / n for i in range(n)]
    return [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]


def volume(*options):
    """Of the image that mesh2voxel makes."""
    subprocess.run(["chroot", "root", "/usr/bin/env", "LD_LIBRARY_PATH=/usr/lib/mrtrix3/lib", "HOME=/tmp", "mesh2voxel", "/solid.obj",
                    "/grid.nii", "/parts.nii", "-force", "-quiet", *options], check=True)
    data = open("root/parts.nii", "rb").read()
    kind = struct.unpack_from("<h", data, 70)[0]
    parts = struct.unpack_from("<8000" + {16: "f", 64: "d"}[kind], data, int(struct.unpack_from("<f", data, 108)[0]))
    return "%.0f mm3" % sum(parts)


# 20 x 20 x 20 voxels of 1 mm, with centers at whole numbers.
header = bytearray(352)
struct.pack_into("<i", header, 0, 348)
struct.pack_into("<8h", header, 40, 3, 20, 20, 20, 1, 1, 1, 1)
struct.pack_into("<2h", header, 70, 2, 8)
struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
struct.pack_into("<f", header, 108, 352)
struct.pack_into("<2h", header, 252, 0, 1)
struct.pack_into("<12f", header, 280, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
header[344:348] = b"n+1\0"
open("root/grid.nii", "wb").write(header + bytes(8000))

for turn in (0, 20, 30, 45):
    block = prism(polygon(4, 32**0.5, 9.3, 9.4, 45 + turn), (5.1, 13.1))
    written(*block)
    coarse = volume()
    same = coarse == volume("-nthreads", "0")
    written(*finer(*block))
    print("block turned by %d: %s%s, each triangle in four: %s" % (turn, coarse, "" if same else " or another", volume()))
for name, bottom, top in (("through the image", -3, 22), ("that ends within it", -3, 15.2)):
    sides = polygon(24, 6, 9.4, 9.3, 0)
    written(*prism(sides, (bottom, top)))
    long = volume()
    written(*prism(sides, (bottom, 9.5, top)))
    right = 12 * 36 * math.sin(math.radians(15)) * (min(top, 19.5) + 0.5)
    print("shaft %s: %s, with a ring in the middle: %s, right: %.0f mm3" % (name, long, volume(), right))
P
python3 solids.py | tee seen
diff seen - <<'E' || exit 1
block turned by 0: 512 mm3, each triangle in four: 512 mm3
block turned by 20: 512 mm3, each triangle in four: 512 mm3
block turned by 30: 204 mm3, each triangle in four: 512 mm3
block turned by 45: 231 mm3, each triangle in four: 511 mm3
shaft through the image: 477 mm3, with a ring in the middle: 2237 mm3, right: 2236 mm3
shaft that ends within it: 1756 mm3, with a ring in the middle: 1756 mm3, right: 1755 mm3
E
