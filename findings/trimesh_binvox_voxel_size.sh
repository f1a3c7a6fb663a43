#!/usr/bin/env bash
# trimesh 4.5.1 (Debian 13: python3-trimesh 4.5.1-3): a binvox file is read and written with voxels of scale / (n - 1) whose first centre
# is at "translate". The format's own page has scale for the side of the whole grid, n voxels of scale / n, and centres at
# translate + scale * (i + 0.5) / n. A full grid of 4 x 4 x 4 on a side of 4 is read with the volume 151.7 for 64 and reaches from
# -0.67 to 4.67; with 128 voxels along a side a bone is 0.8 % longer, 2.4 % larger, and half a voxel off. What trimesh writes is
# too small by as much in programs that follow the page. A round trip in trimesh hides both. (Its docstring: "Length of entire voxel grid".)
# Seen on 2026-11-30: "read: voxel 1.33333, from -0.666667 to 4.66667, volume 151.704", "written: scale 3 for 4 voxels of 1".
# Usage: findings/trimesh_binvox_voxel_size.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y python3-trimesh=4.5.1-3 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/voxels.py <<'P'
import io

import numpy
import trimesh

for n in (4, 128):
    runs = b"\1\xff" * (n ** 3 // 255) + bytes([1, n ** 3 % 255])
    full = f"#binvox 1\ndim {n} {n} {n}\ntranslate 0 0 0\nscale 4\ndata\n".encode() + runs
    grid = trimesh.load(io.BytesIO(full), file_type="binvox")
    low, high = grid.bounds[:, 0]
    print(f"{n} voxels on a side of 4, read: voxel {grid.scale[0]:g}, from {low:g} to {high:g}, volume {grid.volume:g}")
unit = trimesh.voxel.VoxelGrid(numpy.ones((4, 4, 4), bool))
written = trimesh.exchange.binvox.export_binvox(unit)
print("4 voxels of 1, from -0.5 to 3.5, written:", *[line.decode() for line in written.split(b"\n")[1:4]], sep=" / ")
back = trimesh.load(io.BytesIO(written), file_type="binvox")
print(f"and read again: voxel {back.scale[0]:g}, volume {back.volume:g}")
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack HOME=/tmp /usr/bin/python3 /voxels.py | tee seen
diff seen - <<'E' || exit 1
4 voxels on a side of 4, read: voxel 1.33333, from -0.666667 to 4.66667, volume 151.704
128 voxels on a side of 4, read: voxel 0.0314961, from -0.015748 to 4.01575, volume 65.5237
4 voxels of 1, from -0.5 to 3.5, written: / dim 4 4 4 / translate 0.0 0.0 0.0 / scale 3.0
and read again: voxel 1, volume 64
E
