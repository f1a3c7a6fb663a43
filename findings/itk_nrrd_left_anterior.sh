#!/usr/bin/env bash
# ITK 5.2.1 (Debian 12: libinsighttoolkit5.2): NrrdImageIO turns the space left-anterior-superior to LPS by the sign of the first
# axis, where that of the second is meant: the image lies half a turn about z wrong, and nothing is reported.
# Right by arithmetic: origin (1, 2, 3) is (1, -2, 3) in LPS, and the axes are diag(1, -1, 1). ITK 5.4.7 is right.
# Seen on 2026-11-27: "origin -1 2 3, axes -1 1 1".
# Usage: findings/itk_nrrd_left_anterior.sh     needs g++ and libinsighttoolkit5-dev; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
printf '%s\n' NRRD0004 "type: uint8" "dimension: 3" "space: left-anterior-superior" "sizes: 2 2 2" \
    "space directions: (1,0,0) (0,1,0) (0,0,1)" "space origin: (1,2,3)" "encoding: raw" "" 1234567 >las.nrrd
cat >read.cpp <<'C'
#include <itkNrrdImageIO.h>

#include <cstdio>

int main() {
    auto io = itk::NrrdImageIO::New();
    io->SetFileName("las.nrrd");
    io->ReadImageInformation();
    std::printf("origin %g %g %g, axes %g %g %g\n", io->GetOrigin(0), io->GetOrigin(1), io->GetOrigin(2), io->GetDirection(0)[0],
                io->GetDirection(1)[1], io->GetDirection(2)[2]);
}
C
g++ -std=c++17 -I/usr/include/ITK-5.2 read.cpp -o read -lITKIONRRD-5.2 -lITKIOImageBase-5.2 -lITKCommon-5.2 -litksys-5.2
seen=$(./read)
echo "$seen"
[ "$seen" = "origin -1 2 3, axes -1 1 1" ] || exit 1
