#!/usr/bin/env bash
# dcm2niix 1.0.20241211 (Debian 13: dcm2niix 1.0.20241211-1): where the distances of a CT series' slices are not all equal, it writes a
# second file, NAME_Eq_1.nii, resampled to equal distances, the one that is meant to be used. That file starts right and ends too
# early: slices at z = 0 1 2 4 5 6 mm give 6 slices of 1 mm, which is z = 0 to 5, and slices at 0 1 2 4 7 11 mm give 9, which is z = 0
# to 8: the object loses its top. The first file keeps all slices and places them 1 mm apart, so it is too short as well: neither of
# the two is as long as the series. The exit status is 0, the warning tells of the distances only.
# Seen on 2026-11-27: missing_Eq_1.nii has the slices 0 1 2 3 4 5 for 0 1 2 4 5 6, uneven_Eq_1.nii ends at 8 for 11.
# Usage: findings/dcm2niix_equidistant.sh     needs python3, root's apt and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y dcm2niix=1.0.20241211-1 >/dev/null
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


series("missing", (0, 1, 2, 4, 5, 6))
series("uneven", (0, 1, 2, 4, 7, 11))
P
python3 series.py
cat >slices.py <<'P'
import struct
import sys

for name in sys.argv[1:]:
    data = open(name, "rb").read()
    columns, rows, slices = struct.unpack_from("<3h", data, 42)
    distance = struct.unpack_from("<f", data, 88)[0]
    start = int(struct.unpack_from("<f", data, 108)[0])
    voxels = struct.unpack_from(f"<{columns * rows * slices}h", data, start)
    print(f"{name}: distance {distance:g} slices", *(f"{voxels[i * columns * rows] / 10:g}" for i in range(slices)))
P
for name in missing uneven; do
    root/usr/lib64/ld-linux-x86-64.so.2 --library-path root/usr/lib/x86_64-linux-gnu root/usr/bin/dcm2niix -b n -f $name -o . $name \
        >log.$name
done
python3 slices.py missing.nii missing_Eq_1.nii uneven.nii uneven_Eq_1.nii | tee seen
diff seen - <<'E' || exit 1
missing.nii: distance 1 slices 0 1 2 4 5 6
missing_Eq_1.nii: distance 1 slices 0 1 2 3 4 5
uneven.nii: distance 1 slices 0 1 2 4 7 11
uneven_Eq_1.nii: distance 1 slices 0 1 2 3 4 5 6 7 8
E
