#!/usr/bin/env bash
# niftilib 3.0.1 (Debian 12: libnifti2-2 3.0.1-9): nifti_image_load makes voxels that are nan or infinite 0, without a word but in its debug
# output. A CT in Hounsfield units that was resampled with nan around it has water there; at a threshold of 0 or less, bone.
# Seen on 2026-11-27: "1 0 0 4" for 1, nan, inf, 4.
# Usage: findings/niftilib_nan.sh     needs g++, python3 and Debian 12's packages; exits with 1 if that changes.
set -euo pipefail
version=3.0.1-9
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
chmod 777 .
for package in libnifti2-dev libnifti2-2 libniftiio-dev libznz3 libznz-dev; do apt-get download -qq "$package=$version"; done
for package in *.deb; do dpkg -x "$package" root; done
lib=$(dirname root/usr/lib/*/libnifti2.so)
python3 - <<'P'
import struct
header = bytearray(352)
struct.pack_into("<i", header, 0, 348)
struct.pack_into("<8h", header, 40, 3, 4, 1, 1, 1, 1, 1, 1)
struct.pack_into("<2h", header, 70, 16, 32)
struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
struct.pack_into("<f", header, 108, 352)
header[344:348] = b"n+1\0"
open("a.nii", "wb").write(header + struct.pack("<4f", 1, float("nan"), float("inf"), 4))
P
cat >read.cpp <<'C'
#include <nifti2_io.h>

#include <cstdio>

int main() {
    const nifti_image* image = nifti_image_read("a.nii", 1);
    const auto* v = static_cast<const float*>(image->data);
    std::printf("%g %g %g %g\n", v[0], v[1], v[2], v[3]);
}
C
g++ -std=c++17 -Iroot/usr/include/nifti read.cpp -o read -L"$lib" -lnifti2 -lznz -Wl,-rpath-link,"$lib"
export LD_LIBRARY_PATH=$PWD/$lib
seen=$(./read)
echo "$seen"
[ "$seen" = "1 0 0 4" ] || exit 1
