#!/usr/bin/env bash
# InVesalius 3.1.99998 (Debian 12: invesalius 3.1.99998-4), from a DICOM CT without its windows ("--no-gui"). A surface ("-e FILE.stl") lies with the first
# column at x = 0, the last row at y = 0 and the first slice at z = 0: the place of the patient is dropped, so that it fits neither the CT nor a surface of
# another program, and its smoothing takes 14 % of a block of 5 x 9.6 x 16 mm. The files of a project ("--export-project FILE.nii") have neither sform
# nor qform, and the mask has one more voxel along each axis than the image that it belongs to: its block lies one voxel further along x
# and z, and at the same rows. What multiplies both by index, or scales one to the other, is off by a voxel. Exit status 0, no message.
# Seen on 2026-12-01: the lines below.
# Usage: findings/invesalius_place.sh     needs python3, root's apt and chroot, and 2.5 GB for packages; exits with 1 if that changes.
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
"${bookworm[@]}" install --download-only -y invesalius=3.1.99998-4 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done
mkdir -p root/tmp root/home root/dev/shm root/proc
# It asks for the size of the memory.
for file in meminfo cpuinfo stat vmstat; do cat /proc/$file >root/proc/$file; done
for library in root/usr/lib/*/blas root/usr/lib/*/lapack; do echo "${library#root}"; done | paste -sd: >libraries

cat >series.py <<'P'
import gzip
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


def series(folder, heights, rows=40, columns=36):
    """A CT series: one file a slice, 0.8 mm between rows, 0.5 mm between columns, with a block of bone."""
    os.makedirs(folder)
    kind, root = "1.2.840.10008.5.1.4.1.1.2", "2.25.1"
    for i, z in enumerate(heights):
        own = f"{root}.3.{i + 1}"
        voxels = [1724 if 4 <= i < 12 and 4 <= row < 16 and 6 <= column < 16 else 0 for row in range(rows) for column in range(columns)]
        meta = (element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", kind) + element(2, 3, "UI", own) +
                element(2, 0x10, "UI", "1.2.840.10008.1.2.1"))
        body = [(8, 8, "CS", "ORIGINAL\\PRIMARY\\AXIAL"), (8, 0x16, "UI", kind), (8, 0x18, "UI", own), (8, 0x20, "DA", "20200101"),
                (8, 0x21, "DA", "20200101"), (8, 0x30, "TM", "120000"), (8, 0x60, "CS", "CT"), (8, 0x70, "LO", "none"),
                (8, 0x103e, "LO", "bone"), (0x10, 0x10, "PN", "a"), (0x10, 0x20, "LO", "1"), (0x18, 0x50, "DS", "2"),
                (0x18, 0x1030, "LO", "bone"), (0x18, 0x5100, "CS", "HFS"), (0x20, 0xd, "UI", root + ".1"),
                (0x20, 0xe, "UI", root + ".2"), (0x20, 0x10, "SH", "1"), (0x20, 0x11, "IS", "1"), (0x20, 0x13, "IS", str(i + 1)),
                (0x20, 0x32, "DS", f"-50\\-70\\{z}"), (0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"), (0x20, 0x52, "UI", root + ".4"),
                (0x28, 2, "US", struct.pack("<H", 1)), (0x28, 4, "CS", "MONOCHROME2"), (0x28, 0x10, "US", struct.pack("<H", rows)),
                (0x28, 0x11, "US", struct.pack("<H", columns)), (0x28, 0x30, "DS", "0.8\\0.5"),
                (0x28, 0x100, "US", struct.pack("<H", 16)), (0x28, 0x101, "US", struct.pack("<H", 16)),
                (0x28, 0x102, "US", struct.pack("<H", 15)), (0x28, 0x103, "US", struct.pack("<H", 1)),
                (0x28, 0x1050, "DS", "300"), (0x28, 0x1051, "DS", "1500"), (0x28, 0x1052, "DS", "-1024"), (0x28, 0x1053, "DS", "1"),
                (0x7fe0, 0x10, "OW", struct.pack("<%dh" % (rows * columns), *voxels))]
        data = b"".join(element(*entry) for entry in body)
        with open(f"{folder}/{i:03d}.dcm", "wb") as file:
            file.write(bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + data)


def run(*options):
    subprocess.run(["chroot", "root", "/usr/bin/env", "-C", "/usr/share/invesalius", "PATH=/usr/bin:/bin", "HOME=/home", "PYTHONPATH=/usr/lib/invesalius",
                    "INVESALIUS_LIBRARY_PATH=/usr/share/invesalius/", "LD_LIBRARY_PATH=" + open("libraries").read().strip(), "python3", "app.py",
                    "--no-gui", "-i", "/series", "-t", "226,3071", *options], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def block(name):
    data = open("root/home/" + name, "rb").read()
    data = data if data[:2] != b"\x1f\x8b" else gzip.decompress(data)
    size, kind = struct.unpack_from("<3h", data, 42), struct.unpack_from("<h", data, 70)[0]
    values = struct.unpack_from("<%d%s" % (size[0] * size[1] * size[2], {2: "B", 4: "h", 256: "b", 512: "H"}[kind]), data,
                                int(struct.unpack_from("<f", data, 108)[0]))
    found = [(i % size[0], i // size[0] % size[1], i // (size[0] * size[1])) for i, value in enumerate(values) if value > 0]
    codes = struct.unpack_from("<2h", data, 252)
    return "%d x %d x %d voxels, codes of qform and sform %d %d, block at %s" % (
        *size, *codes, ", ".join("%d to %d" % (min(f[k] for f in found), max(f[k] for f in found)) for k in range(3)))


series("root/series", range(100, 140, 2))
run("-e", "/home/bone.stl")
data = open("root/home/bone.stl", "rb").read()
corners = [struct.unpack_from("<9f", data, 96 + 50 * i) for i in range(struct.unpack_from("<I", data, 80)[0])]
middle, volume = [], 0
for k in range(3):
    along = [v for t in corners for v in t[k::3]]
    middle.append("%.2f" % ((min(along) + max(along)) / 2))
for a, b, c in ((t[:3], t[3:6], t[6:]) for t in corners):
    volume += sum(a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3]) for i in range(3)) / 6
print("surface around (%s) mm for (-44.75, -62.40, 115.00), %.0f mm3 for 768" % (", ".join(middle), volume))
run("--export-project", "/home/all.nii")
print("image:", block("all.nii"))
print("mask:", block(next(name for name in os.listdir("root/home") if "mask" in name)))
P
python3 series.py | tee seen
diff seen - <<'E' || exit 1
surface around (5.25, -23.60, 15.00) mm for (-44.75, -62.40, 115.00), 663 mm3 for 768
image: 36 x 40 x 20 voxels, codes of qform and sform 0 0, block at 6 to 15, 4 to 15, 4 to 11
mask: 37 x 41 x 21 voxels, codes of qform and sform 0 0, block at 7 to 16, 4 to 15, 5 to 12
E
