#!/usr/bin/env bash
# MIA 2.4.7 (Debian 12: mia-tools 2.4.7-11+b1), mia-3dimagefilter on a .nii: a filter that changes the voxels (downscale, scale, isovoxel) writes the
# new sizes to pixdim, from which the qform takes them, and leaves the sform as it was. What reads the sform first, as nibabel does, finds a block of
# 864 mm3 at 62 to 404 mm3 and millimeters off; by the qform it has 500 to 832 mm3 near its place. "crop" leaves the sform at the first voxel of
# the whole image, and gives the qform a place that is neither that one nor the right one; the voxels named by "end" are not in it.
# From .nii to .mhd (MetaIO), the values keep their order, the axes become 1 0 0 0 1 0 0 0 1 where they should be -1 0 0 0 -1 0 0 0 1, and a rotation is
# dropped; the Offset along z is that of the last slice. So the file is read without complaint, mirrored about its first voxel and somewhere else.
# No message but that of each filter, exit status 0.
# Seen on 2026-12-01: the lines below; a block of 12 x 12 x 12 voxels of 0.5 x 0.5 x 2 mm around (14.75, -15.25, 49) mm.
# Usage: findings/mia_voxels_and_place.sh     needs python3, root's apt and chroot; exits with 1 if that changes.
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
"${bookworm[@]}" install --download-only -y mia-tools=2.4.7-11+b1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >images.py <<'P'
import math
import os
import struct
import subprocess

SIZE, VOXEL, PLACE = (20, 20, 20), (0.5, 0.5, 2.0), (10.0, -20.0, 30.0)
BLOCK = range(4, 16)


def write(name, turn):
    """A block of ones; turned about z in its header."""
    header = bytearray(352)
    cosine, sine = math.cos(turn), math.sin(turn)
    rows = [[cosine * VOXEL[0], -sine * VOXEL[1], 0, PLACE[0]], [sine * VOXEL[0], cosine * VOXEL[1], 0, PLACE[1]], [0, 0, VOXEL[2], PLACE[2]]]
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *SIZE, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<8f", header, 76, 1, *VOXEL, 1, 0, 0, 0)
    struct.pack_into("<f", header, 108, 352)
    header[123] = 2
    struct.pack_into("<2h6f", header, 252, 1, 1, 0, 0, math.sin(turn / 2), *PLACE)
    for k in range(3):
        struct.pack_into("<4f", header, 280 + 16 * k, *rows[k])
    header[344:348] = b"n+1\0"
    ones = bytes(int(x in BLOCK and y in BLOCK and z in BLOCK) for z in range(20) for y in range(20) for x in range(20))
    open("root/" + name, "wb").write(header + ones)


def filtered(source, target, *filters):
    if os.path.exists("root/" + target):
        os.remove("root/" + target)
    subprocess.run(["chroot", "root", "/usr/bin/env", "HOME=/tmp", "mia-3dimagefilter", "-i", "/" + source, "-o", "/" + target, *filters],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def middle(size, data):
    """How many voxels are 1, and the mean of their indices."""
    found = [(i % size[0], i // size[0] % size[1], i // (size[0] * size[1])) for i, value in enumerate(data) if value]
    return len(found), [sum(index[k] for index in found) / len(found) for k in range(3)]


def shown(voxel, place, count, at):
    center = ["%.2f" % (place[k] + voxel[k] * at[k]) for k in range(3)]
    return "%g x %g x %g mm, %.1f mm3 around (%s)" % (*voxel, count * abs(voxel[0] * voxel[1] * voxel[2]), ", ".join(center))


write("in.nii", 0)
for name in ("downscale:bx=2,by=2,bz=2", "scale:s=[<10,10,10>]", "isovoxel:size=1", "crop:start=[<4,4,4>],end=[<15,15,15>]"):
    filtered("in.nii", "out.nii", name)
    data = open("root/out.nii", "rb").read()
    size = struct.unpack_from("<3h", data, 42)
    count, at = middle(size, data[int(struct.unpack_from("<f", data, 108)[0]):])
    rows = [struct.unpack_from("<4f", data, 280 + 16 * k) for k in range(3)]
    print(name.split(":")[0], "to %d x %d x %d voxels" % size)
    print("  sform", shown([rows[k][k] for k in range(3)], [row[3] for row in rows], count, at))
    print("  qform", shown(struct.unpack_from("<3f", data, 80), struct.unpack_from("<3f", data, 268), count, at))

for turn in (0, 0.3):
    write("in.nii", turn)
    filtered("in.nii", "out.mhd")
    lines = dict(line.strip().split(" = ") for line in open("root/out.mhd"))
    raw = open("root/" + lines["ElementDataFile"], "rb").read()
    same = raw == open("root/in.nii", "rb").read()[352:]
    print("turned by %g, .mhd: values %s, axes %s, Offset %s" % (turn, "in their order" if same else "in another order", lines["TransformMatrix"], lines["Offset"]))
P
python3 images.py | tee seen
diff seen - <<'E' || exit 1
downscale to 10 x 10 x 10 voxels
  sform 0.5 x 0.5 x 2 mm, 62.5 mm3 around (12.00, -18.00, 38.00)
  qform 1 x 1 x 4 mm, 500.0 mm3 around (14.00, -16.00, 48.00)
scale to 10 x 10 x 10 voxels
  sform 0.5 x 0.5 x 2 mm, 104.0 mm3 around (12.25, -17.75, 39.00)
  qform 1 x 1 x 4 mm, 832.0 mm3 around (14.50, -15.50, 50.00)
isovoxel to 11 x 11 x 39 voxels
  sform 0.5 x 0.5 x 2 mm, 403.5 mm3 around (12.28, -17.72, 68.00)
  qform 1 x 1 x 1 mm, 807.0 mm3 around (14.57, -15.43, 49.00)
crop to 11 x 11 x 11 voxels
  sform 0.5 x 0.5 x 2 mm, 665.5 mm3 around (12.50, -17.50, 40.00)
  qform 0.5 x 0.5 x 2 mm, 665.5 mm3 around (0.50, 0.50, -2.00)
turned by 0, .mhd: values in their order, axes 1 0 0 0 1 0 0 0 1, Offset -10 20 68
turned by 0.3, .mhd: values in their order, axes 1 0 0 0 1 0 0 0 1, Offset -10 20 68
E
