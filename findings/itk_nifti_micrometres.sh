#!/usr/bin/env bash
# ITK 5.2.1 (Debian 12: libinsighttoolkit5.2 5.2.1-5+deb12u1): NiftiImageIO turns the spacing of a NIfTI file in micrometres (or metres)
# into millimetres and leaves the origin as it is, so a micro-CT volume is a thousand times too far from where it belongs: voxels of
# 0.01 mm and the origin 500 mm away for 0.5 mm. ITK 5.4.3 (Debian 13: libinsighttoolkit5.4 5.4.3-5) turns both: the same file, the
# same program, and the bone stands elsewhere after an upgrade. Both with sform and with qform.
# Seen on 2026-11-27: ITK 5.2.1 "spacing 0.01 0.01 0.01 origin -500 -600 700", ITK 5.4.3 "... origin -0.5 -0.6 0.7".
# Usage: findings/itk_nifti_micrometres.sh     needs g++, python3, root's apt and both Debians' packages; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
chmod 777 .
old=5.2.1-5+deb12u1
apt-get download -qq "libinsighttoolkit5-dev=$old" "libinsighttoolkit5.2=$old"
for package in *.deb; do dpkg -x "$package" old; done

# Packages of Debian 13 into the folder root, with an apt of its own that knows nothing of this machine's packages.
mkdir -p apt/lists/partial apt/cache/archives/partial root
: >apt/status
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u)
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror trixie main" >apt/sources
trixie=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
        -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
        -o Acquire::Check-Valid-Until=false -o Acquire::Languages=none -o APT::Install-Recommends=false)
"${trixie[@]}" update
"${trixie[@]}" install --download-only -y libinsighttoolkit5.4=5.4.3-5 >/dev/null
(cd apt/cache/archives && "${trixie[@]}" download libinsighttoolkit5-dev=5.4.3-5)
for package in apt/cache/archives/*.deb; do dpkg -x "$package" root; done

python3 - <<'P'
import struct
for name, unit in (("mm", 2), ("um", 3)):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 2, 3, 4, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<8f", header, 76, 1, 10, 10, 10, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    header[123] = unit
    struct.pack_into("<2h", header, 252, 1, 1)
    struct.pack_into("<3f", header, 268, 500, 600, 700)
    struct.pack_into("<12f", header, 280, 10, 0, 0, 500, 0, 10, 0, 600, 0, 0, 10, 700)
    header[344:348] = b"n+1\0"
    open(name + ".nii", "wb").write(bytes(header) + bytes(24))
P

cat >read.cpp <<'C'
#include <itkNiftiImageIO.h>

#include <cstdio>

int main(int count, char** names) {
    for (int i = 1; i < count; ++i) {
        auto io = itk::NiftiImageIO::New();
        io->SetFileName(names[i]);
        io->ReadImageInformation();
        std::printf("%s: spacing", names[i]);
        for (unsigned d = 0; d < 3; ++d) std::printf(" %g", io->GetSpacing(d));
        std::printf(" origin");
        for (unsigned d = 0; d < 3; ++d) std::printf(" %g", io->GetOrigin(d));
        std::printf(" directions");
        for (unsigned d = 0; d < 3; ++d) std::printf(" %g", io->GetDirection(d)[d] + 0.0);
        std::printf("\n");
    }
}
C
g++ -w -std=c++17 -Iold/usr/include/ITK-5.2 read.cpp -o read_old -Lold/usr/lib -lITKIONIFTI-5.2 -lITKIOImageBase-5.2 -lITKCommon-5.2 \
    -litksys-5.2 -Wl,--allow-shlib-undefined
lib=root/usr/lib/x86_64-linux-gnu
# Linked on Debian 12 with Debian 13's ITK, run with Debian 13's C library.
g++ -w -std=c++17 -Iroot/usr/include/ITK-5.4 read.cpp -o read -Wl,--allow-shlib-undefined -Lroot/usr/lib -L$lib -l:libITKIONIFTI-5.4.so.1 \
    -l:libITKIOImageBase-5.4.so.1 -l:libITKCommon-5.4.so.1 -l:libitksys-5.4.so.1
{
    echo "ITK 5.2.1"
    LD_LIBRARY_PATH=$PWD/old/usr/lib ./read_old mm.nii um.nii
    echo "ITK 5.4.3"
    root/usr/lib64/ld-linux-x86-64.so.2 --library-path $lib:root/usr/lib ./read mm.nii um.nii
} | tee seen
diff seen - <<'E' || exit 1
ITK 5.2.1
mm.nii: spacing 10 10 10 origin -500 -600 700 directions -1 -1 1
um.nii: spacing 0.01 0.01 0.01 origin -500 -600 700 directions -1 -1 1
ITK 5.4.3
mm.nii: spacing 10 10 10 origin -500 -600 700 directions -1 -1 1
um.nii: spacing 0.01 0.01 0.01 origin -0.5 -0.6 0.7 directions -1 -1 1
E
