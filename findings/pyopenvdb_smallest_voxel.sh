#!/usr/bin/env bash
# pyopenvdb 10.0.1 (Debian 13: python3-openvdb 10.0.1-2.3+b1): a transform whose determinant is below 3e-15 is refused as if it had
# no inverse, so that no voxel may be smaller than about 1.44e-5 of its unit, whatever the size of the grid. A micro-CT with
# voxels of 10 um cannot be kept in meters, and one of 20 um can: "Non-zero scale values required". For a matrix the message is another
# one. Long thin voxels of as little volume are refused alike. A grid in mm or um is the cure (the bound is in openvdb/math/Maps.h).
# Seen on 2026-11-29: 2e-5 taken, 1e-5 refused by a scale, by scaling 0.01 to 0.001 of it, and by a matrix.
# Usage: findings/pyopenvdb_smallest_voxel.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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

cat >root/smallest.py <<'P'
import pyopenvdb

def tried(name, make):
    try:
        size = make().voxelSize()
        print(f"{name}: {size[0]:g} x {size[1]:g} x {size[2]:g}")
    except Exception as e:
        print(f"{name}: {type(e).__name__}: {e}")

def scaled():
    transform = pyopenvdb.createLinearTransform(0.01)
    transform.scale((0.001, 0.001, 0.001))
    return transform

def matrix(x, y, z):
    return [[x, 0, 0, 0], [0, y, 0, 0], [0, 0, z, 0], [0, 0, 0, 1]]

tried("voxels of 20 um in meters", lambda: pyopenvdb.createLinearTransform(2e-5))
tried("of 10 um in meters", lambda: pyopenvdb.createLinearTransform(1e-5))
tried("of 10 um in mm, scaled to meters", scaled)
tried("of 10 um by a matrix", lambda: pyopenvdb.createLinearTransform(matrix(1e-5, 1e-5, 1e-5)))
tried("of 5 x 5 x 100 um", lambda: pyopenvdb.createLinearTransform(matrix(5e-6, 5e-6, 1e-4)))
tried("of 10 um in mm", lambda: pyopenvdb.createLinearTransform(0.01))
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack /usr/bin/python3 /smallest.py | tee seen
diff seen - <<'E' || exit 1
voxels of 20 um in meters: 2e-05 x 2e-05 x 2e-05
of 10 um in meters: ArithmeticError: Non-zero scale values required
of 10 um in mm, scaled to meters: ArithmeticError: Non-zero scale values required
of 10 um by a matrix: ArithmeticError: Tried to initialize an affine transform from a nearly singular matrix
of 5 x 5 x 100 um: ArithmeticError: Tried to initialize an affine transform from a nearly singular matrix
of 10 um in mm: 0.01 x 0.01 x 0.01
E
