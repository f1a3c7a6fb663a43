#!/usr/bin/env bash
# A NIfTI file may hold two placings: qform and sform, each with a code. Readers of Debian 12 differ over which they take: nibabel 5.0.0
# (python3-nibabel 5.0.0-2) takes the sform whenever its code is not 0; ITK 5.2.1 (libinsighttoolkit5.2 5.2.1-5+deb12u1) takes the
# sform where its code is 1 or there is no qform, and else the qform; an sform with code 2, 3 or 4 (aligned, Talairach, MNI), as a
# registration writes it beside the scanner's qform, is passed over without a word. The bone then lies where it was before.
# Seen on 2026-11-27: sform_code 2 and qform_code 1: nibabel at -5 -6 -7 (the sform), ITK at 10 20 30 (the qform).
# Usage: findings/nifti_sform_code.sh     needs g++, /usr/bin/python3 and Debian 12's packages; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
chmod 777 .
itk=5.2.1-5+deb12u1
apt-get download -qq "libinsighttoolkit5-dev=$itk" "libinsighttoolkit5.2=$itk" python3-nibabel=5.0.0-2 \
    libnifti2-2=3.0.1-9 libznz3=3.0.1-9 python3-numpy=1:1.24.2-1+deb12u1 python3-packaging=23.0-1
for package in *.deb; do dpkg -x "$package" root; done

cat >place.py <<'P'
import struct

import nibabel

for sform, qform in ((1, 1), (2, 1), (2, 0), (4, 2), (1, 2)):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 2, 3, 4, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<8f", header, 76, 1, 2, 3, 4, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    header[123] = 2
    struct.pack_into("<2h", header, 252, qform, sform)
    struct.pack_into("<3f", header, 268, 10, 20, 30)
    struct.pack_into("<12f", header, 280, 2, 0, 0, -5, 0, 3, 0, -6, 0, 0, 4, -7)
    header[344:348] = b"n+1\0"
    name = f"sform{sform}_qform{qform}.nii"
    open(name, "wb").write(bytes(header) + bytes(24))
    print(f"nibabel {nibabel.__version__}: {name} at", *(f"{nibabel.load(name).affine[d, 3]:g}" for d in range(3)))
P
cat >read.cpp <<'C'
#include <itkNiftiImageIO.h>

#include <cstdio>

int main(int count, char** names) {
    for (int i = 1; i < count; ++i) {
        auto io = itk::NiftiImageIO::New();
        io->SetFileName(names[i]);
        io->ReadImageInformation();
        // ITK's left and posterior are NIfTI's right and anterior with the other sign
        std::printf("ITK 5.2.1: %s at %g %g %g\n", names[i], -io->GetOrigin(0), -io->GetOrigin(1), io->GetOrigin(2));
    }
}
C
lib=root/usr/lib
g++ -w -std=c++17 -Iroot/usr/include/ITK-5.2 read.cpp -o read -L$lib -lITKIONIFTI-5.2 -lITKIOImageBase-5.2 -lITKCommon-5.2 \
    -litksys-5.2 -Wl,--allow-shlib-undefined
export LD_LIBRARY_PATH=$PWD/$lib:$PWD/$lib/x86_64-linux-gnu
{
    PYTHONPATH=root/usr/lib/python3/dist-packages /usr/bin/python3 place.py
    ./read sform1_qform1.nii sform2_qform1.nii sform2_qform0.nii sform4_qform2.nii sform1_qform2.nii
} | tee seen
diff seen - <<'E' || exit 1
nibabel 5.0.0: sform1_qform1.nii at -5 -6 -7
nibabel 5.0.0: sform2_qform1.nii at -5 -6 -7
nibabel 5.0.0: sform2_qform0.nii at -5 -6 -7
nibabel 5.0.0: sform4_qform2.nii at -5 -6 -7
nibabel 5.0.0: sform1_qform2.nii at -5 -6 -7
ITK 5.2.1: sform1_qform1.nii at -5 -6 -7
ITK 5.2.1: sform2_qform1.nii at 10 20 30
ITK 5.2.1: sform2_qform0.nii at -5 -6 -7
ITK 5.2.1: sform4_qform2.nii at 10 20 30
ITK 5.2.1: sform1_qform2.nii at -5 -6 -7
E
