#!/usr/bin/env bash
# GDCM 3.0.21 (Debian 12: libvtkgdcm-tools 3.0.21-1, VTK 9.1), gdcm2vtk from a DICOM CT to .mhd: rows come in the order from below, the place is that of
# the last row, and the spacing along y stays positive, with axes 1 0 0 0 1 0 0 0 1. So every program finds the image mirrored about that row, and one height
# of it too far to the back: a left bone becomes a right one. With "--lower-left" rows are in the order of the DICOM files, and all voxels lie
# right. An oblique series loses its axes either way. Exit status 0, no word of it.
# Seen on 2026-12-01: the lines below. The voxel marked 100 is the first of its slice, at (10, 20, 0) mm, 200 the last of that row, 300 the first
# of the last row.
# Usage: findings/gdcm2vtk_mirrors.sh     needs python3, root's apt and chroot; exits with 1 if that changes.
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
"${bookworm[@]}" install --download-only -y libvtkgdcm-tools=3.0.21-1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done
mkdir -p root/tmp

for library in $(ls -d root/usr/lib/*/blas root/usr/lib/*/lapack root/usr/lib/*/libproxy root/usr/lib/*/openmpi/lib 2>/dev/null); do echo "${library#root}"; done |
    paste -sd: >libraries

cat >series.py <<'P'
import math
import os
import shutil
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
    """A CT series: one file a slice, 0.5 mm between rows, 0.25 mm between columns, three corners of the first slice marked; turned about x."""
    os.makedirs(folder)
    corners = {0: 100, columns - 1: 200, (rows - 1) * columns: 300}
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
                (0x7fe0, 0x10, "OW", struct.pack("<48h", *(corners.get(k, 0) if i == 0 else 0 for k in range(48))))]
        data = b"".join(element(*entry) for entry in body)
        with open(f"{folder}/{i:03d}.dcm", "wb") as file:
            file.write(bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + data)


for name, tilt, options in (("straight", 0, ()), ("straight, --lower-left", 0, ("--lower-left",)), ("turned by 0.2, --lower-left", 0.2, ("--lower-left",))):
    shutil.rmtree("root/series", True)
    series("root/series", (0, 2, 4, 6), tilt)
    subprocess.run(["chroot", "root", "/usr/bin/env", "LD_LIBRARY_PATH=" + open("libraries").read().strip(), "HOME=/tmp", "gdcm2vtk", "--ipp-sort",
                    *options, "/series", "/tmp/out.mhd"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    lines = dict(line.strip().split(" = ") for line in open("root/tmp/out.mhd"))
    size, spacing, place = ([float(v) for v in lines[key].split()] for key in ("DimSize", "ElementSpacing", "Offset"))
    kind = {"MET_SHORT": "h", "MET_INT": "i", "MET_FLOAT": "f", "MET_DOUBLE": "d"}[lines["ElementType"]]
    values = [v[0] for v in struct.iter_unpack("<" + kind, open("root/tmp/" + lines["ElementDataFile"], "rb").read())]
    found = []
    for mark in (100, 200, 300):
        at = values.index(mark)
        index = (at % size[0], at // size[0] % size[1], at // (size[0] * size[1]))
        found.append("%d at (%s)" % (mark, ", ".join("%.6g" % (p + s * k) for p, s, k in zip(place, spacing, index))))
    print("%s: %s; axes %s" % (name, ", ".join(found), lines["TransformMatrix"]))
P
python3 series.py | tee seen
diff seen - <<'E' || exit 1
straight: 100 at (10, 25, 0), 200 at (11.75, 25, 0), 300 at (10, 22.5, 0); axes 1 0 0 0 1 0 0 0 1
straight, --lower-left: 100 at (10, 20, 0), 200 at (11.75, 20, 0), 300 at (10, 22.5, 0); axes 1 0 0 0 1 0 0 0 1
turned by 0.2, --lower-left: 100 at (10, 20, 0), 200 at (11.75, 20, 0), 300 at (10, 22.5, 0); axes 1 0 0 0 1 0 0 0 1
E
