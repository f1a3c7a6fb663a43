#!/usr/bin/env bash
# plastimatch 1.10.0 (Debian 13: plastimatch 1.10.0+dfsg.2-1~deb13u1): "convert" of a CT series whose slices are not equally far apart
# makes up the slices between. The volume has the right length, but each place without a slice holds a copy of the nearest slice,
# the lower one where two are equally near; slices at z = 0 1 2 4 7 11 mm become 12 slices of which 6 were never
# measured. The exit status is 0, and the warning says that the distances differ, not that slices were added. Bone there ends in
# steps, and a later test for equal distances passes.
# Seen on 2026-11-27: "missing: 0 1 2 2 4 5 6" for 0 1 2 4 5 6, and "uneven: 0 1 2 2 4 4 7 7 7 7 11 11" for 0 1 2 4 7 11.
# Usage: findings/plastimatch_missing_slice.sh     needs python3, root's apt and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y "plastimatch=1.10.0+dfsg.2-1~deb13u1" >/dev/null
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
    header, voxels = open(name + ".mhd").read(), open(name + ".raw", "rb").read()
    tags = dict(line.split(" = ") for line in header.splitlines() if " = " in line)
    columns, rows, slices = map(int, tags["DimSize"].split())
    kind = {"MET_SHORT": "h", "MET_FLOAT": "f"}[tags["ElementType"]]
    voxels = struct.unpack(f"<{columns * rows * slices}{kind}", voxels)
    print(f"{name}:", *(f"{voxels[i * columns * rows] / 10:g}" for i in range(slices)))
P
lib=root/usr/lib/x86_64-linux-gnu
for name in missing uneven; do
    root/usr/lib64/ld-linux-x86-64.so.2 --library-path $lib:$lib/blas:$lib/lapack:root/usr/lib root/usr/bin/plastimatch convert --input $name \
        --output-img $name.mhd >log.$name 2>&1
    grep -i warning log.$name
done
python3 slices.py missing uneven | tee seen
diff seen - <<'E' || exit 1
missing: 0 1 2 2 4 5 6
uneven: 0 1 2 2 4 4 7 7 7 7 11 11
E
