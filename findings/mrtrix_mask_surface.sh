#!/usr/bin/env bash
# MRtrix3 3.0.4 (Debian 13: mrtrix3 3.0.4-1+b1): voxel2mesh of a mask puts the surface through the centres of the voxels around it, half a
# voxel outside. Without -threshold it looks for a threshold itself, and for an image of 0 and 1 that is 0.001, not 0.5, even where the
# type is a single bit. A block of 5 x 5 x 6 voxels of 2 mm, 10 x 10 x 12 mm, becomes 12 x 12 x 14 mm, and its volume 1753 mm3 for
# 1200: a trabecula of two voxels has three voxels' thickness. No message. "-threshold 0.5" gives the true size (1141, its edges cut off),
# "-blocky" the voxels (1200), and label2mesh of the same program takes 0.5 for the same mask.
# Seen on 2026-11-30: "voxel2mesh: size 12 12 14 volume 1753", "voxel2mesh -threshold 0.5: size 10 10 12 volume 1141".
# Usage: findings/mrtrix_mask_surface.sh     needs python3, root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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

python3 - <<'P'
import struct

header = bytearray(352)
struct.pack_into("<i", header, 0, 348)
struct.pack_into("<8h", header, 40, 3, 12, 13, 14, 1, 1, 1, 1)
struct.pack_into("<2h", header, 70, 2, 8)
struct.pack_into("<8f", header, 76, 1, 2, 2, 2, 0, 0, 0, 0)
struct.pack_into("<f", header, 108, 352)
struct.pack_into("<2h", header, 252, 0, 1)
struct.pack_into("<12f", header, 280, 2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 2, 30)
header[344:348] = b"n+1\0"
voxels = bytes(3 <= x < 8 and 4 <= y < 9 and 5 <= z < 11 for z in range(14) for y in range(13) for x in range(12))
open("root/mask.nii", "wb").write(header + voxels)
P
mrtrix() { chroot root /usr/bin/env LD_LIBRARY_PATH=/usr/lib/mrtrix3/lib HOME=/tmp "$@" -quiet; }
mrtrix mrconvert /mask.nii -datatype bit /bits.mif
surface() {
    mrtrix "$@" /surface.obj -force
    python3 - "$@" <<'P'
import sys

lines = [line.split() for line in open("root/surface.obj") if line[0] in "vf" and line[1] == " "]
points = [[float(x) for x in line[1:]] for line in lines if line[0] == "v"]
faces = [[points[int(x.split("/")[0]) - 1] for x in line[1:]] for line in lines if line[0] == "f"]
volume = sum((a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
             for face in faces for a, b, c in [(face[0], face[k], face[k + 1]) for k in range(1, len(face) - 1)])
print(*[w.strip("/") for w in sys.argv[1:]], "-> size", *["%.3g" % (max(p[k] for p in points) - min(p[k] for p in points)) for k in range(3)],
      "volume %.4g" % volume)
P
}
{
    surface voxel2mesh /mask.nii
    surface voxel2mesh /bits.mif
    surface voxel2mesh /mask.nii -threshold 0.5
    surface voxel2mesh /mask.nii -blocky
    surface label2mesh /mask.nii
} | tee seen
diff seen - <<'E' || exit 1
voxel2mesh mask.nii -> size 12 12 14 volume 1753
voxel2mesh bits.mif -> size 12 12 14 volume 1753
voxel2mesh mask.nii -threshold 0.5 -> size 10 10 12 volume 1141
voxel2mesh mask.nii -blocky -> size 10 10 12 volume 1200
label2mesh mask.nii -> size 10 10 12 volume 1141
E
