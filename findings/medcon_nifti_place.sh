#!/usr/bin/env bash
# (X)MedCon 0.23.0 (Debian 12: medcon 0.23.0-gtk3+dfsg-1+deb12u2): a CT that it makes a NIfTI file of (medcon -f *.dcm -stack3d -c nifti) holds the
# numbers of the DICOM pixels, not Hounsfield units: RescaleSlope and RescaleIntercept are not applied, and scl_slope and scl_inter are 1 and 0; with
# -qs or -qc they are 2 and -1024, as they should be. Where the volume lies is lost in any case: an axial and a sagittal series of the same pixels become the same file byte
# for byte, with qform_code and sform_code 0, and so does a NIfTI file that is turned and away from the origin and passes through medcon. Bone of
# 700 HU stored as 862 with slope 2 and intercept -1024 is 862 then, and a mask made elsewhere no longer lies on it. No message, exit status 0.
# Seen on 2026-11-30: "axial -stack3d: values 0 862, scl 1 0, qform 0, sform 0", "axial -stack3d -qs: values 0 862, scl 2 -1024, ...", "axial and sagittal: the same bytes".
# Usage: findings/medcon_nifti_place.sh   needs python3, root's apt and chroot and 300 MB of Debian 12's packages; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# Packages of Debian 12 into the folder root, with an apt of its own that knows nothing of this machine's packages.
mkdir -p apt/lists/partial apt/cache/archives/partial root/data
: >apt/status
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u)
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror bookworm main" >apt/sources
bookworm=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
          -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
          -o Acquire::Check-Valid-Until=false -o Acquire::Languages=none -o APT::Install-Recommends=false)
"${bookworm[@]}" update
"${bookworm[@]}" install --download-only -y medcon=0.23.0-gtk3+dfsg-1+deb12u2 >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >ct.py <<'P'
"""series FOLDER AXES: a CT of 4 slices of 6 x 5 pixels, slope 2, intercept -1024; turned FILE.nii; show FILE.nii: what a file holds"""
import os
import struct
import sys

if sys.argv[1] == "series":
    axes = {"axial": ([1, 0, 0, 0, 1, 0], [0, 0, 3]), "sagittal": ([0, 1, 0, 0, 0, -1], [3, 0, 0])}[sys.argv[3]]
    os.makedirs(sys.argv[2])
    for k in range(4):
        def element(group, number, kind, value):
            if isinstance(value, (list, tuple)):
                value = "\\".join(f"{v:g}" for v in value)
            if isinstance(value, str):
                value = value.encode()
            value += (b"\0" if kind == "UI" else b" ") * (len(value) % 2)
            size = struct.pack("<HI", 0, len(value)) if kind in ("OB", "OW") else struct.pack("<H", len(value))
            return struct.pack("<HH", group, number) + kind.encode() + size + value
        short = lambda v: struct.pack("<H", v)
        meta = (element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.2") + element(2, 3, "UI", f"1.2.3.{k + 1}")
                + element(2, 0x10, "UI", "1.2.840.10008.1.2.1"))
        pixels = [0] * 30
        pixels[8] = 862
        position = [10 + axes[1][0] * k, -20, 30 + axes[1][2] * k]
        body = b"".join(element(*e) for e in [
            (8, 8, "CS", "ORIGINAL\\PRIMARY\\AXIAL"), (8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2"), (8, 0x18, "UI", f"1.2.3.{k + 1}"), (8, 0x60, "CS", "CT"),
            (0x18, 0x50, "DS", "3"), (0x18, 0x88, "DS", "3"), (0x20, 0xd, "UI", "1.2.4"), (0x20, 0xe, "UI", "1.2.5"), (0x20, 0x11, "IS", "1"),
            (0x20, 0x13, "IS", str(k + 1)), (0x20, 0x32, "DS", position), (0x20, 0x37, "DS", axes[0]), (0x20, 0x52, "UI", "1.2.6"),
            (0x28, 2, "US", short(1)), (0x28, 4, "CS", "MONOCHROME2"), (0x28, 0x10, "US", short(5)), (0x28, 0x11, "US", short(6)),
            (0x28, 0x30, "DS", [2, 1.5]), (0x28, 0x100, "US", short(16)), (0x28, 0x101, "US", short(16)), (0x28, 0x102, "US", short(15)),
            (0x28, 0x103, "US", short(1)), (0x28, 0x1052, "DS", "-1024"), (0x28, 0x1053, "DS", "2"), (0x7fe0, 0x10, "OW", struct.pack("<30h", *pixels))])
        open(f"{sys.argv[2]}/{k}.dcm", "wb").write(b"\0" * 128 + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + body)
elif sys.argv[1] == "turned":
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 6, 5, 4, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, 1.5, 2, 3, 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[123] = 2
    struct.pack_into("<2h", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, 0, 2, 0, 10, 1.5, 0, 0, -20, 0, 0, 3, 30)
    header[344:348] = b"n+1\0"
    pixels = [0] * 120
    pixels[8] = 862
    open(sys.argv[2], "wb").write(bytes(header) + struct.pack("<120h", *pixels))
else:
    data = open(sys.argv[2], "rb").read()
    count = struct.unpack_from("<8h", data, 40)
    voxels = count[1] * count[2] * count[3]
    assert struct.unpack_from("<h", data, 70)[0] == 4
    first, slope, intercept = struct.unpack_from("<3f", data, 108)
    values = sorted(set(struct.unpack_from(f"<{voxels}h", data, int(first))))
    print(f"values {' '.join(map(str, values))}, scl {slope:g} {intercept:g}, qform %d, sform %d" % struct.unpack_from("<2h", data, 252))
P
converted() {  # NAME, then options of medcon
    local files=("root/data/$1"/*.dcm)
    [[ -e root/data/$1.in.nii ]] && files=("root/data/$1.in.nii")
    rm -f "root/data/$1.nii"
    chroot root /usr/bin/medcon -f "${files[@]#root}" "${@:2}" -c nifti -o "/data/$1" >/dev/null
    printf '%s: ' "$*"
    python3 ct.py show "root/data/$1.nii"
}
python3 ct.py series root/data/axial axial
python3 ct.py series root/data/sagittal sagittal
python3 ct.py turned root/data/turned.in.nii
{
    converted axial -stack3d -qs
    converted axial -stack3d
    converted sagittal -stack3d
    converted turned
    cmp root/data/axial.nii root/data/sagittal.nii && echo "axial and sagittal: the same bytes"
} | tee seen
diff seen - <<'E' || exit 1
axial -stack3d -qs: values 0 862, scl 2 -1024, qform 0, sform 0
axial -stack3d: values 0 862, scl 1 0, qform 0, sform 0
sagittal -stack3d: values 0 862, scl 1 0, qform 0, sform 0
turned: values 0 862, scl 1 0, qform 0, sform 0
axial and sagittal: the same bytes
E
