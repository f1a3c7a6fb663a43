#!/usr/bin/env bash
# MRtrix3 3.0.4 (Debian 13: mrtrix3 3.0.4-1+b1): mrinfo and mrconvert take the two values of DICOM's PixelSpacing the wrong way round.
# The first is the distance between rows, so the voxel's size down a column; MRtrix3 gives it to the axis along a row. A slice of
# 6 rows 0.5 mm apart and 8 columns 0.25 mm apart, 2 mm wide and 3 mm high, is read 4 mm wide and 1.5 mm high, and mrconvert
# writes that into NIfTI without a word. Slices with square pixels do not show it.
# The same series with a slice missing, at z = 0 1 2 4 5 6 mm, is read as 6 slices 1.2 mm apart, since the distance is that of the
# first and last slice over their number less one: no slice but these two stands where it was measured.
# Seen on 2026-11-27: "even: 8 6 6 voxels of 0.5 0.25 1" (right: 0.25 0.5 1) and "missing: 8 6 6 voxels of 0.5 0.25 1.2".
# Usage: findings/mrtrix_pixel_spacing.sh     needs python3, root's apt and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y mrtrix3=3.0.4-1+b1 >/dev/null
for package in apt/cache/archives/*.deb; do dpkg -x "$package" root; done

cat >series.py <<'P'
import os
import struct


def element(group, number, kind, value):
    """One element of a DICOM file with its kind written out, little endian."""
    if isinstance(value, str):
        value = value.encode()
        value += (b"\0" if kind == "UI" else b" ") * (len(value) % 2)
    long = kind in ("OB", "OW", "SQ")
    return struct.pack("<HH2s", group, number, kind.encode()) + struct.pack("<xxI" if long else "<H", len(value)) + value


def series(folder, heights, rows=6, columns=8):
    """A CT series: one file a slice, 0.5 mm between rows, 0.25 mm between columns, each voxel 10 times its slice's z."""
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
                (0x20, 0x32, "DS", f"10\\20\\{z}"), (0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"), (0x20, 0x52, "UI", root + ".4"),
                (0x28, 2, "US", struct.pack("<H", 1)), (0x28, 4, "CS", "MONOCHROME2"), (0x28, 0x10, "US", struct.pack("<H", rows)),
                (0x28, 0x11, "US", struct.pack("<H", columns)), (0x28, 0x30, "DS", "0.5\\0.25"),
                (0x28, 0x100, "US", struct.pack("<H", 16)), (0x28, 0x101, "US", struct.pack("<H", 16)),
                (0x28, 0x102, "US", struct.pack("<H", 15)), (0x28, 0x103, "US", struct.pack("<H", 1)),
                (0x28, 0x1052, "DS", "0"), (0x28, 0x1053, "DS", "1"),
                (0x7fe0, 0x10, "OW", struct.pack("<h", 10 * z) * (rows * columns))]
        data = b"".join(element(*entry) for entry in body)
        with open(f"{folder}/{i:03d}.dcm", "wb") as file:
            file.write(bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + data)


series("even", (0, 1, 2, 3, 4, 5))
series("missing", (0, 1, 2, 4, 5, 6))
P
python3 series.py
lib=root/usr/lib/x86_64-linux-gnu
mrinfo() { root/usr/lib64/ld-linux-x86-64.so.2 --library-path $lib:root/usr/lib/mrtrix3/lib root/usr/bin/mrinfo -quiet "$@"; }
for name in even missing; do
    size=$(mrinfo -size $name)
    spacing=$(mrinfo -spacing $name)
    echo "$name: $size voxels of $spacing"
done | tee seen
diff seen - <<'E' || exit 1
even: 8 6 6 voxels of 0.5 0.25 1
missing: 8 6 6 voxels of 0.5 0.25 1.2
E
