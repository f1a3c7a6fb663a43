#!/usr/bin/env bash
# A NIfTI file with sform_code = 0 and qform_code = 0 has sizes and voxel sizes but says nothing of where it lies. Three readers of
# Debian 12 place it in three ways, none warns, and two are mirror images of each other. Axes as NIfTI has them (x to the right,
# y to the front): ITK 5.2.1 (libinsighttoolkit5.2 5.2.1-5+deb12u1) has x and y negative and voxel 0 at the origin; nibabel 5.0.0
# (python3-nibabel 5.0.0-2) has only x negative, so the other handedness, and the middle of the volume at the origin; niftilib 3.0.1
# (nifti-bin 3.0.1-9) has all positive and voxel 0 at the origin. A bone sent through two of them may change sides.
# Seen on 2026-11-27: steps and place of voxel 0 "-2 -3 4 at 0 0 0", "-2 3 4 at 1 -3 -6" and "2 3 4 at 0 0 0".
# Usage: findings/nifti_without_forms.sh     needs g++, /usr/bin/python3 and Debian 12's packages; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
chmod 777 .
itk=5.2.1-5+deb12u1
apt-get download -qq "libinsighttoolkit5-dev=$itk" "libinsighttoolkit5.2=$itk" python3-nibabel=5.0.0-2 nifti-bin=3.0.1-9 \
    libnifti2-2=3.0.1-9 libnifticdf2=3.0.1-9 libznz3=3.0.1-9 python3-numpy=1:1.24.2-1+deb12u1 python3-packaging=23.0-1
for package in *.deb; do dpkg -x "$package" root; done

cat >place.py <<'P'
import struct
header = bytearray(352)
struct.pack_into("<i", header, 0, 348)
struct.pack_into("<8h", header, 40, 3, 2, 3, 4, 1, 1, 1, 1)
struct.pack_into("<2h", header, 70, 2, 8)
struct.pack_into("<8f", header, 76, 1, 2, 3, 4, 1, 1, 1, 1)
struct.pack_into("<f", header, 108, 352)
header[123] = 2
header[344:348] = b"n+1\0"
open("plain.nii", "wb").write(bytes(header) + bytes(24))

import nibabel
affine = nibabel.load("plain.nii").affine
print(f"nibabel {nibabel.__version__}:", *(f"{affine[d, d]:g}" for d in range(3)), "at", *(f"{affine[d, 3]:g}" for d in range(3)))
P
cat >read.cpp <<'C'
#include <itkNiftiImageIO.h>

#include <cstdio>

int main() {
    auto io = itk::NiftiImageIO::New();
    io->SetFileName("plain.nii");
    io->ReadImageInformation();
    const double sign[] = {-1, -1, 1};  // from ITK's left and posterior to NIfTI's right and anterior
    std::printf("ITK 5.2.1:");
    for (unsigned d = 0; d < 3; ++d) std::printf(" %g", sign[d] * io->GetDirection(d)[d] * io->GetSpacing(d));
    std::printf(" at");
    for (unsigned d = 0; d < 3; ++d) std::printf(" %g", sign[d] * io->GetOrigin(d) + 0.0);
    std::printf("\n");
}
C
lib=root/usr/lib
g++ -w -std=c++17 -Iroot/usr/include/ITK-5.2 read.cpp -o read -L$lib -lITKIONIFTI-5.2 -lITKIOImageBase-5.2 -lITKCommon-5.2 \
    -litksys-5.2 -Wl,--allow-shlib-undefined
export LD_LIBRARY_PATH=$PWD/$lib:$PWD/$lib/x86_64-linux-gnu
{
    PYTHONPATH=root/usr/lib/python3/dist-packages /usr/bin/python3 place.py
    ./read
    root/usr/bin/nifti_tool -quiet -disp_nim -field qto_xyz -infiles plain.nii |
        awk '{ for (i = 1; i <= NF - 15; ++i) if ($i == "2.0") print "niftilib 3.0.1:", $i + 0, $(i + 5) + 0, $(i + 10) + 0, "at",
               $(i + 3) + 0, $(i + 7) + 0, $(i + 11) + 0 }'
} | tee seen
diff seen - <<'E' || exit 1
nibabel 5.0.0: -2 3 4 at 1 -3 -6
ITK 5.2.1: -2 -3 4 at 0 0 0
niftilib 3.0.1: 2 3 4 at 0 0 0
E
