#!/usr/bin/env bash
# vedo 2025.5.3 (Debian 13: python3-vedo 2025.5.3-1), Mesh.binarize, from a mesh to a mask: with dims, the number of voxels, they do not
# span the mesh. Their size stays 1/250 of its diagonal, and they begin at its least corner, so that the mask holds that corner only: for a
# ball of 20 mm 60 x 60 x 60 voxels have 5 % of its volume, 20 x 20 x 20 nothing. And where no origin is given, the centers of the first
# voxels lie one spacing above the mesh's least corner, along each axis, so that half a voxel or more is left out on that side only: a plate of
# 1 mm keeps 75 % in voxels of 0.25 mm, 50 % in voxels of 0.5 mm and is lost in voxels of 1 mm. No message.
# Seen on 2026-12-01: the lines below.
# Usage: findings/vedo_binarize_dims.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y python3-vedo=2025.5.3-1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/binarize.py <<'P'
import math

import numpy
import vedo


def block(*sides):
    corners = numpy.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]) * sides + 0.013
    faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return vedo.Mesh([corners, [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]])


def show(name, mesh, **how):
    mask = mesh.binarize(**how)
    inside, size, origin = numpy.argwhere(mask.tonumpy()), numpy.array(mask.spacing()), numpy.array(mask.origin())
    extent = "none"
    if len(inside):
        extent = "%.2f to %.2f along z" % tuple((origin + inside[i].astype(float) * size)[2] + sign * size[2] / 2
                                                for i, sign in ((inside[:, 2].argmin(), -1), (inside[:, 2].argmax(), 1)))
    options = ", ".join("%s %s" % (key, "x".join("%g" % v for v in value)) for key, value in how.items())
    print("%s, %s: voxels of %.3f mm, %.3f of the volume, %s" % (name, options or "no option", size[0], len(inside) * math.prod(size) / abs(mesh.volume()), extent))


ball = vedo.Sphere(r=10, res=60)
for n in (20, 60, 100):
    show("ball", ball, dims=(n, n, n))
show("ball", ball)
show("ball", ball, spacing=(1, 1, 1))
plate = block(10, 10, 1)
for size in (1, 0.5, 0.25):
    show("plate of 10 x 10 x 1 mm", plate, spacing=(size, size, size))
P
chroot root /usr/bin/env HOME=/tmp UCX_LOG_LEVEL=fatal LD_LIBRARY_PATH=/usr/lib/x86_64-linux-gnu/blas:/usr/lib/x86_64-linux-gnu/lapack /usr/bin/python3 /binarize.py | tee seen
diff seen - <<'E' || exit 1
ball, dims 20x20x20: voxels of 0.139 mm, 0.000 of the volume, none
ball, dims 60x60x60: voxels of 0.139 mm, 0.052 of the volume, -9.65 to -1.62 along z
ball, dims 100x100x100: voxels of 0.139 mm, 0.453 of the volume, -9.93 to 3.92 along z
ball, no option: voxels of 0.139 mm, 1.000 of the volume, -9.93 to 10.02 along z
ball, spacing 1x1x1: voxels of 1.000 mm, 0.990 of the volume, -9.50 to 9.50 along z
plate of 10 x 10 x 1 mm, spacing 1x1x1: voxels of 1.000 mm, 0.000 of the volume, none
plate of 10 x 10 x 1 mm, spacing 0.5x0.5x0.5: voxels of 0.500 mm, 0.500 of the volume, 0.26 to 0.76 along z
plate of 10 x 10 x 1 mm, spacing 0.25x0.25x0.25: voxels of 0.250 mm, 0.750 of the volume, 0.14 to 0.89 along z
E
