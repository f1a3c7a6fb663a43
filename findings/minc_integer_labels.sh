#!/usr/bin/env bash
# minc-tools 2.3.00 (Debian 12: minc-tools 2.3.00+dfsg-10): a label map with a label above 255 that goes through MINC comes back as NIfTI with labels
# that are no integers, where mnc2nii is asked for an integer type (-short, -int), which holds all of them. It stretches the values so that the
# largest becomes the next power of two less one, and sets scl_slope to undo that: of the labels 0 1 2 3 5 300 the file holds 0 2 3 5 9 511 with
# a slope of 0.587, which is 0 1.174 1.761 2.935 5.284 300. No voxel equals 1, 2, 3 or 5 any more, a reader that truncates merges 1 and 2, and one that
# leaves out the slope has other labels. Up to 255 the labels are kept, so a small test does not show it. Nothing is said, the status is 0.
# Without a type mnc2nii writes floats of 32 bits, which are exact here.
# Seen on 2026-11-30: "-int, labels to 300: type 8, stored 0 2 3 5 9 511, slope 0.587084, read 0 1.17417 1.76125 2.93542 5.28376 300".
# Usage: findings/minc_integer_labels.sh     needs python3, root's apt and chroot and 250 MB of Debian 12's packages; exits with 1 if that changes.
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
"${bookworm[@]}" install --download-only -y minc-tools=2.3.00+dfsg-10 >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >labels.py <<'P'
"""write FILE.nii LABELS: voxels of 0.5 mm with these labels in turn; show FILE.nii: what came back"""
import struct
import sys

name, labels = sys.argv[2], [int(x) for x in sys.argv[3:]]
if sys.argv[1] == "write":
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, len(labels), 4, 4, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, 0.5, 0.5, 0.5, 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    struct.pack_into("<2h", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0)
    header[123] = 2
    header[344:348] = b"n+1\0"
    open(name, "wb").write(bytes(header) + struct.pack(f"<{len(labels)}h", *labels) * 16)
else:
    data = open(name, "rb").read()
    columns = struct.unpack_from("<h", data, 42)[0]
    kind = struct.unpack_from("<h", data, 70)[0]
    start, slope, intercept = struct.unpack_from("<3f", data, 108)
    stored = struct.unpack_from(f"<{columns}{ {4: 'h', 8: 'i', 16: 'f', 512: 'H'}[kind]}", data, int(start))
    read = [slope * x + intercept if slope else x for x in stored]
    print(f"type {kind}, stored", *(f"{x:g}" for x in stored), end=f", slope {slope:g}, read ")
    print(*(f"{x:g}" for x in read))
P
converted() {  # LABELS, then options of mnc2nii after --
    local labels=()
    while [[ $1 != -- ]]; do labels+=("$1") && shift; done
    shift
    rm -f root/*.nii root/*.mnc
    python3 labels.py write root/in.nii "${labels[@]}"
    chroot root /usr/bin/nii2mnc /in.nii /labels.mnc >log 2>&1
    chroot root /usr/bin/mnc2nii "$@" /labels.mnc /out.nii >>log 2>&1
    printf '%s, labels to %d: ' "${*:-no type}" "${labels[-1]}"
    python3 labels.py show root/out.nii
}
{
    converted 0 1 2 3 5 255 -- -int
    converted 0 1 2 3 5 300 -- -int
    converted 0 1 2 3 5 300 -- -short
    converted 0 1 2 3 5 300 -- -unsigned -short
    converted 0 1 2 3 5 2035 -- -short
    converted 0 1 2 3 5 300 --
} | tee seen
diff seen - <<'E' || exit 1
-int, labels to 255: type 8, stored 0 1 2 3 5 255, slope 1, read 0 1 2 3 5 255
-int, labels to 300: type 8, stored 0 2 3 5 9 511, slope 0.587084, read 0 1.17417 1.76125 2.93542 5.28376 300
-short, labels to 300: type 4, stored 0 2 3 5 9 511, slope 0.587084, read 0 1.17417 1.76125 2.93542 5.28376 300
-unsigned -short, labels to 300: type 512, stored 0 2 3 5 9 511, slope 0.587084, read 0 1.17417 1.76125 2.93542 5.28376 300
-short, labels to 2035: type 4, stored 0 1 2 3 5 2047, slope 0.994138, read 0 0.994138 1.98828 2.98241 4.97069 2035
no type, labels to 300: type 16, stored 0 1 2 3 5 300, slope 0, read 0 1 2 3 5 300
E
