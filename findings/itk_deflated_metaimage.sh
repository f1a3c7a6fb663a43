#!/usr/bin/env bash
# ITK 5.2.1 (Debian 12: libinsighttoolkit5.2 5.2.1-5+deb12u1): MetaImageIO takes a deflated MetaImage whose header has no
# CompressedDataSize, which the format does not require, says "Uncompress failed" on standard error, throws nothing, and leaves the
# voxels of the caller as they were. With the tag, the same bytes are read right. A program that does not look at standard error
# goes on with whatever its memory held.
# Seen on 2026-11-27: "with size: 1 2 64" and "without size: 7 7 7" (7: what the buffer was filled with before).
# Usage: findings/itk_deflated_metaimage.sh     needs g++, python3 and Debian 12's packages; exits with 1 if that changes.
set -euo pipefail
version=5.2.1-5+deb12u1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
chmod 777 .
apt-get download -qq "libinsighttoolkit5-dev=$version" "libinsighttoolkit5.2=$version"
for package in *.deb; do dpkg -x "$package" root; done

python3 - <<'P'
import zlib
voxels = zlib.compress(bytes(range(1, 65)))
for name, size in (("with.mha", f"CompressedDataSize = {len(voxels)}\n"), ("without.mha", "")):
    header = ("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = True\n" + size +
              "DimSize = 4 4 4\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n")
    open(name, "wb").write(header.encode() + voxels)
P

cat >read.cpp <<'C'
#include <itkMetaImageIO.h>

#include <cstdio>
#include <vector>

int main(int, char** names) {
    auto io = itk::MetaImageIO::New();
    io->SetFileName(names[1]);
    io->ReadImageInformation();
    itk::ImageIORegion region(3);
    for (unsigned d = 0; d < 3; ++d) region.SetSize(d, io->GetDimensions(d));
    io->SetIORegion(region);
    std::vector<unsigned char> voxels(io->GetImageSizeInBytes(), 7);
    io->Read(voxels.data());
    std::printf("%d %d %d\n", voxels[0], voxels[1], voxels.back());
}
C
lib=root/usr/lib
g++ -std=c++17 -Iroot/usr/include/ITK-5.2 read.cpp -o read -L$lib -lITKIOMeta-5.2 -lITKMetaIO-5.2 -lITKIOImageBase-5.2 \
    -lITKCommon-5.2 -litksys-5.2 -Wl,-rpath-link,$lib
export LD_LIBRARY_PATH=$PWD/$lib
with=$(./read with.mha)
without=$(./read without.mha 2>/dev/null) || without=refused
echo "with size: $with"
echo "without size: $without"
[ "$with" = "1 2 64" ] && [ "$without" = "7 7 7" ] || exit 1
