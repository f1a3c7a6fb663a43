#!/usr/bin/env bash
# vtk-dicom 0.8.14 (Debian 12: vtk-dicom-tools 0.8.14-3.1): the number that a label of a NIfTI file has in the DICOM series of niftitodicom depends on
# the largest label in the file. In floats of 32 bits, as many programs write label maps, 0 and 1 become 0 and 1000; in a file with labels to 3, label 1
# is 100, to 21 it is 10, and only from 205 on it is 1. The help knows of the factor 1000 (below 2.05), not of 100 and 10, and no RescaleSlope
# undoes them (with --modality CT it is there, as 1). Labels of 32-bit integers lose what is above 16 bits instead: 65537 joins label 1, and 40000
# turns negative. And scl_slope and scl_inter are left out unless the modality is CT: bone of 700 HU, stored as 862 with 2 and -1024, is 862 then.
# No message, exit status 0.
# Seen on 2026-11-30: "float 0 1 2 3: 0 100 200 300", "int32 0 1 40000 65537: 0 1 -25536 1", "int16 0 1 512 862, scaled by 2 - 1024: 0 1 512 862".
# Usage: findings/vtkdicom_label_values.sh   needs python3, root's apt and chroot and 500 MB of Debian 12's packages; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# Packages of Debian 12 into the folder root, with an apt of its own that knows nothing of this machine's packages.
mkdir -p apt/lists/partial apt/cache/archives/partial root
: >apt/status
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u)
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror bookworm main" >apt/sources
bookworm=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
          -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
          -o Acquire::Check-Valid-Until=false -o Acquire::Languages=none -o APT::Install-Recommends=false)
"${bookworm[@]}" update
"${bookworm[@]}" install --download-only -y vtk-dicom-tools=0.8.14-3.1 >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >labels.py <<'P'
"""write FILE.nii KIND SLOPE INTERCEPT LABELS: 4 slices, each row with these labels; show FILE.dcm LABELS: what became of them"""
import struct
import sys

if sys.argv[1] == "write":
    code, letter, convert = {"float": (16, "f", float), "int32": (8, "i", int), "int16": (4, "h", int)}[sys.argv[3]]
    labels = [convert(x) for x in sys.argv[6:]]
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, len(labels), 4, 4, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, code, 8 * struct.calcsize(letter))
    struct.pack_into("<8f", header, 76, 1, 0.5, 0.5, 0.5, 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, float(sys.argv[4]), float(sys.argv[5]))
    struct.pack_into("<2h", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0)
    header[123] = 2
    header[344:348] = b"n+1\0"
    open(sys.argv[2], "wb").write(bytes(header) + struct.pack(f"<{len(labels)}{letter}", *labels) * 16)
else:
    data, at, found = open(sys.argv[2], "rb").read(), 132, {}
    while at < len(data):
        group, number, kind = struct.unpack_from("<HH2s", data, at)
        long = kind in (b"OB", b"OW", b"SQ", b"UN", b"UT")
        size = struct.unpack_from("<I" if long else "<H", data, at + (8 if long else 6))[0]
        at += 12 if long else 8
        found[group, number] = data[at:at + size]
        at += size
    columns = struct.unpack("<H", found[0x28, 0x11])[0]
    signed = struct.unpack("<H", found[0x28, 0x103])[0]
    slope, intercept = (float(found.get((0x28, n), default)) for n, default in ((0x1053, b"1"), (0x1052, b"0")))
    # x runs to the right in NIfTI and to the left in DICOM
    row = struct.unpack_from(f"<{columns}{'h' if signed else 'H'}", found[0x7fe0, 0x10])[::-1]
    print(*(f"{slope * x + intercept:g}" for x in row), end=", with" if (0x28, 0x1053) in found else ", without")
    print(" RescaleSlope")
P
converted() {  # KIND SLOPE INTERCEPT LABELS, then options of niftitodicom after --
    local file=("${@:1:3}") labels=()
    shift 3
    while [[ $1 != -- ]]; do labels+=("$1") && shift; done
    shift
    rm -rf root/series root/in.nii
    python3 labels.py write root/in.nii "${file[@]}" "${labels[@]}"
    chroot root /usr/bin/niftitodicom -s "$@" -o /series /in.nii
    printf '%s %s%s%s: ' "${file[0]}" "${labels[*]}" "$([[ ${file[1]} == 1 ]] || echo ", scaled by ${file[1]} - ${file[2]#-}")" "${*:+, $*}"
    python3 labels.py show root/series/IM-0001-0001.dcm
}
{
    converted float 1 0 0 1 0 1 --
    converted float 1 0 0 1 2 3 --
    converted float 1 0 0 1 20 21 --
    converted float 1 0 0 1 203 204 --
    converted float 1 0 0 1 204 205 --
    converted float 1 0 0 1 2 3 -- --modality CT
    converted int32 1 0 0 1 2 3 --
    converted int32 1 0 0 1 40000 65537 --
    converted int16 2 -1024 0 1 512 862 --
    converted int16 2 -1024 0 1 512 862 -- --modality CT
} | tee seen
diff seen - <<'E' || exit 1
float 0 1 0 1: 0 1000 0 1000, without RescaleSlope
float 0 1 2 3: 0 100 200 300, without RescaleSlope
float 0 1 20 21: 0 10 200 210, without RescaleSlope
float 0 1 203 204: 0 10 2030 2040, without RescaleSlope
float 0 1 204 205: 0 1 204 205, without RescaleSlope
float 0 1 2 3, --modality CT: 0 100 200 300, with RescaleSlope
int32 0 1 2 3: 0 1 2 3, without RescaleSlope
int32 0 1 40000 65537: 0 1 -25536 1, without RescaleSlope
int16 0 1 512 862, scaled by 2 - 1024: 0 1 512 862, without RescaleSlope
int16 0 1 512 862, scaled by 2 - 1024, --modality CT: -1024 -1022 0 700, with RescaleSlope
E
