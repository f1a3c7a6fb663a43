#!/usr/bin/env bash
# PyVista 0.44.1 (Debian 13: python3-pyvista 0.44.1-11), voxelize and voxelize_volume: points are laid from the least corner of the mesh in steps
# of density, up to but without its greatest one, and every cell is kept that has a corner within the mesh. So the voxels
# are too many on a round solid and too few on a slender or a square one, and all lie towards the least corner; the last layer of the other side is
# missing. A ball of 20 voxels has 17 % too much, with voxels half as large still 10 %; a rod that is two voxels thick has 69 % too little, a
# block of 8 x 8 x 8 voxels 33 %. voxelize_volume marks the same cells (InsideMesh).
# No message.
# Seen on 2026-12-01: "ball of 20 mm, density 1: 1.166 of its volume, 1.166 marked, from -10.0 to 9.0" and the lines below.
# Usage: findings/pyvista_voxelize_corner.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y python3-pyvista=0.44.1-11 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/voxels.py <<'P'
import warnings

import pyvista

warnings.simplefilter("ignore")


def show(name, mesh, density):
    true = mesh.volume
    cells = pyvista.voxelize(mesh, density=density)
    marked = pyvista.voxelize_volume(mesh, density=density)["InsideMesh"].sum() * density**3
    print("%s, density %g: %.3f of its volume, %.3f marked, from %.1f to %.1f" % (name, density, cells.volume / true, marked / true, *cells.bounds[:2]))


def ball():
    return pyvista.Sphere(radius=10, theta_resolution=120, phi_resolution=120)


def rod(diameter):
    return pyvista.Cylinder(radius=diameter / 2, height=20, direction=(0, 0, 1), resolution=60).triangulate().clean()


def block(side):
    return pyvista.Box((0, side) * 3).triangulate().clean()


for density in (2, 1, 0.5, 0.25):
    show("ball of 20 mm", ball(), density)
for diameter in (1, 2, 4):
    show("rod of %d mm" % diameter, rod(diameter), 0.5)
for side in (7.9, 8, 8.4):
    show("block of %.1f mm" % side, block(side), 1)
show("block of 8 mm, turned by 30 degrees", block(8).rotate_z(30), 1)
P
chroot root /usr/bin/env HOME=/tmp UCX_LOG_LEVEL=fatal LD_LIBRARY_PATH=/usr/lib/x86_64-linux-gnu/blas:/usr/lib/x86_64-linux-gnu/lapack /usr/bin/python3 /voxels.py | tee seen
diff seen - <<'E' || exit 1
ball of 20 mm, density 2: 1.185 of its volume, 1.185 marked, from -10.0 to 8.0
ball of 20 mm, density 1: 1.166 of its volume, 1.166 marked, from -10.0 to 9.0
ball of 20 mm, density 0.5: 1.099 of its volume, 1.099 marked, from -10.0 to 9.5
ball of 20 mm, density 0.25: 1.053 of its volume, 1.053 marked, from -10.0 to 9.8
rod of 1 mm, density 0.5: 0.311 of its volume, 0.311 marked, from -0.5 to 0.0
rod of 2 mm, density 0.5: 0.700 of its volume, 0.700 marked, from -1.0 to 0.5
rod of 4 mm, density 0.5: 0.933 of its volume, 0.933 marked, from -2.0 to 1.5
block of 7.9 mm, density 1: 0.696 of its volume, 0.696 marked, from 0.0 to 7.0
block of 8.0 mm, density 1: 0.670 of its volume, 0.670 marked, from 0.0 to 7.0
block of 8.4 mm, density 1: 0.864 of its volume, 0.864 marked, from 0.0 to 8.0
block of 8 mm, turned by 30 degrees, density 1: 1.080 of its volume, 1.080 marked, from -4.0 to 6.0
E
