#!/usr/bin/env bash
# MRIConvert 2.1.0 (Debian 12: mriconvert 1:2.1.0-5+b2), mcverter from DICOM CT to .nii and .mhd: a series of a tilted gantry, whose planes are turned about x
# while their positions rise along z, becomes an image with perpendicular axes: slices 1.96 mm apart along the normal of the planes for 2 mm along z
# at 0.2 rad. The first slice lies right, each further one is 0.4 mm more beside its place (0.96 mm at 0.5 rad), and a straight shaft
# leans by the angle of the gantry; volumes stay right, so that no count of voxels shows it. A missing slice is closed up without a word
# (slices at 0, 2, 4, 8, 10 mm are 2 mm apart), and the distances of rows and columns are exchanged, as some other programs have them.
# Exit status 0, no warning.
# Seen on 2026-12-01: the lines below; each slice's first voxel is at (10, 20, z) mm, rows are 0.5 mm apart and columns 0.25 mm.
# Usage: findings/mcverter_tilted_gantry.sh     needs python3, root's apt and chroot; exits with 1 if that changes.
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
"${bookworm[@]}" install --download-only -y mriconvert=1:2.1.0-5+b2 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done
mkdir -p root/tmp root/root

cat >series.py <<'P'
import math
import os
import struct
import subprocess


def element(group, number, kind, value):
    """One element of a DICOM file with its kind written out, little endian."""
    if isinstance(value, str):
        value = value.encode()
        value += (b"\0" if kind == "UI" else b" ") * (len(value) % 2)
    long = kind in ("OB", "OW", "SQ")
    return struct.pack("<HH2s", group, number, kind.encode()) + struct.pack("<xxI" if long else "<H", len(value)) + value


def series(folder, heights, tilt=0, rows=6, columns=8):
    """A CT series: one file a slice, 0.5 mm between rows, 0.25 mm between columns, each voxel 10 times its slice's z; turned about x."""
    os.makedirs(folder)
    kind, root = "1.2.840.10008.5.1.4.1.1.2", "2.25.1"
    for i, z in enumerate(heights):
        own = f"{root}.3.{i + 1}"
        meta = (element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", kind) + element(2, 3, "UI", own) +
                element(2, 0x10, "UI", "1.2.840.10008.1.2.1"))
        body = [(8, 8, "CS", "ORIGINAL\\PRIMARY\\AXIAL"), (8, 0x16, "UI", kind), (8, 0x18, "UI", own), (8, 0x20, "DA", "20200101"),
                (8, 0x21, "DA", "20200101"), (8, 0x30, "TM", "120000"), (8, 0x60, "CS", "CT"), (8, 0x70, "LO", "none"),
                (8, 0x103e, "LO", "bone"), (0x10, 0x10, "PN", "a"), (0x10, 0x20, "LO", "1"), (0x18, 0x50, "DS", "1"),
                (0x18, 0x1030, "LO", "bone"), (0x18, 0x5100, "CS", "HFS"), (0x20, 0xd, "UI", root + ".1"),
                (0x20, 0xe, "UI", root + ".2"), (0x20, 0x10, "SH", "1"), (0x20, 0x11, "IS", "1"), (0x20, 0x13, "IS", str(i + 1)),
                (0x20, 0x32, "DS", f"10\\20\\{z}"), (0x20, 0x37, "DS", "1\\0\\0\\0\\%.9g\\%.9g" % (math.cos(tilt), math.sin(tilt))), (0x20, 0x52, "UI", root + ".4"),
                (0x28, 2, "US", struct.pack("<H", 1)), (0x28, 4, "CS", "MONOCHROME2"), (0x28, 0x10, "US", struct.pack("<H", rows)),
                (0x28, 0x11, "US", struct.pack("<H", columns)), (0x28, 0x30, "DS", "0.5\\0.25"),
                (0x28, 0x100, "US", struct.pack("<H", 16)), (0x28, 0x101, "US", struct.pack("<H", 16)),
                (0x28, 0x102, "US", struct.pack("<H", 15)), (0x28, 0x103, "US", struct.pack("<H", 1)),
                (0x28, 0x1052, "DS", "0"), (0x28, 0x1053, "DS", "1"),
                (0x7fe0, 0x10, "OW", struct.pack("<h", 10 * z) * (rows * columns))]
        data = b"".join(element(*entry) for entry in body)
        with open(f"{folder}/{i:03d}.dcm", "wb") as file:
            file.write(bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + data)


HEIGHTS = {"straight": (0, 2, 4, 6, 8), "tilted by 0.2": (0, 2, 4, 6, 8), "tilted by 0.5": (0, 2, 4, 6, 8), "one missing": (0, 2, 4, 8, 10)}
for k, (name, heights) in enumerate(HEIGHTS.items()):
    folder = "s%d" % k
    series("root/" + folder, heights, float(name.split()[-1]) if "tilted" in name else 0)
    os.makedirs("root/o" + folder)
    slices = ["/%s/%03d.dcm" % (folder, i) for i in range(len(heights))]
    for form in ("nifti", "meta"):
        subprocess.run(["chroot", "root", "/usr/bin/env", "HOME=/root", "mcverter", "-q", "-n", "-f", form, "-o", "/o" + folder, *slices], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    made = ["root/o" + folder + "/" + file for file in sorted(os.listdir("root/o" + folder))]
    data = open(next(file for file in made if file.endswith(".nii")), "rb").read()
    b, c, d = struct.unpack_from("<3f", data, 256)
    a = math.sqrt(max(0, 1 - b * b - c * c - d * d))
    pixdim = struct.unpack_from("<4f", data, 76)
    # The third axis of the qform, in LPS.
    along = (-2 * (b * d + a * c), -2 * (c * d - a * b), a * a + d * d - b * b - c * c)
    place = [sign * v for sign, v in zip((-1, -1, 1), struct.unpack_from("<3f", data, 268))]
    last = [place[n] + 4 * pixdim[3] * (pixdim[0] or 1) * along[n] for n in range(3)]
    off = math.dist(last, (10, 20, heights[-1]))
    lines = dict(line.strip().split(" = ") for line in open(next(file for file in made if file.endswith(".mhd"))))
    print("%s: rows and columns %g and %g mm, slices %.4g mm apart, the last one %.2f mm off; .mhd: %s" %
          (name, pixdim[2], pixdim[1], pixdim[3], off, lines["ElementSpacing"]))
P
python3 series.py | tee seen
diff seen - <<'E' || exit 1
straight: rows and columns 0.25 and 0.5 mm, slices 2 mm apart, the last one 0.00 mm off; .mhd: 0.5 0.25 2
tilted by 0.2: rows and columns 0.25 and 0.5 mm, slices 1.96 mm apart, the last one 1.59 mm off; .mhd: 0.5 0.25 1.9602
tilted by 0.5: rows and columns 0.25 and 0.5 mm, slices 1.755 mm apart, the last one 3.84 mm off; .mhd: 0.5 0.25 1.7552
one missing: rows and columns 0.25 and 0.5 mm, slices 2 mm apart, the last one 2.00 mm off; .mhd: 0.5 0.25 2
E
