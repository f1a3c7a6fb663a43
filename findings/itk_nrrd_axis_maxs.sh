#!/usr/bin/env bash
# ITK 5.4.3 (Debian 13: libinsighttoolkit5.4 5.4.3-5; 5.2.1 of Debian 12 likewise): a NRRD may give its grid by "axis mins" and
# "axis maxs", and teem's unu does so. NrrdImageIO uses them for the origin only, not for the spacing: 2 x 3 x 4 voxels over 20, 30 and
# 40 mm get the origin 5 5 5, half of the right 10 mm, and the spacing 1 1 1. Bone read so is ten times too small, with an origin
# that looks right. With "spacings" and "axis mins" but no "centerings", the origin is half a voxel past the mins, as for cells.
# Seen on 2026-11-27: "mins_maxs.nrrd: spacing 1 1 1 origin 5 5 5", "mins.nrrd: spacing 10 10 10 origin 5 5 5".
# Usage: findings/itk_nrrd_axis_maxs.sh     needs g++, python3, root's apt and Debian 13's packages; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

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
for name, grid in (("spacings", "spacings: 10 10 10"), ("mins", "spacings: 10 10 10\naxis mins: 0 0 0"),
                   ("nodes", "spacings: 10 10 10\naxis mins: 0 0 0\ncenterings: node node node"),
                   ("mins_maxs", "axis mins: 0 0 0\naxis maxs: 20 30 40\ncenterings: cell cell cell")):
    header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n" + grid + "\n\n"
    open(name + ".nrrd", "wb").write(header.encode() + bytes(24))
P

cat >read.cpp <<'C'
#include <itkNrrdImageIO.h>

#include <cstdio>

int main(int count, char** names) {
    for (int i = 1; i < count; ++i) {
        auto io = itk::NrrdImageIO::New();
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
lib=root/usr/lib/x86_64-linux-gnu
# Linked on Debian 12 with Debian 13's ITK, run with Debian 13's C library.
g++ -w -std=c++17 -Iroot/usr/include/ITK-5.4 read.cpp -o read -Wl,--allow-shlib-undefined -Lroot/usr/lib -L$lib -l:libITKIONRRD-5.4.so.1 \
    -l:libITKIOImageBase-5.4.so.1 -l:libITKCommon-5.4.so.1 -l:libitksys-5.4.so.1
root/usr/lib64/ld-linux-x86-64.so.2 --library-path $lib:root/usr/lib ./read spacings.nrrd mins.nrrd nodes.nrrd mins_maxs.nrrd | tee seen
diff seen - <<'E' || exit 1
spacings.nrrd: spacing 10 10 10 origin 0 0 0 directions 1 1 1
mins.nrrd: spacing 10 10 10 origin 5 5 5 directions 1 1 1
nodes.nrrd: spacing 10 10 10 origin 0 0 0 directions 1 1 1
mins_maxs.nrrd: spacing 1 1 1 origin 5 5 5 directions 1 1 1
E
