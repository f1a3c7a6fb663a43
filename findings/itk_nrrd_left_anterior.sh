#!/usr/bin/env bash
# ITK 5.4.3 (Debian 13: libinsighttoolkit5.4 5.4.3-5; 5.2.1 of Debian 12 likewise): NrrdImageIO turns the wrong axis of a NRRD whose
# "space" is left-anterior-superior (LAS). ITK's own axes are left, posterior, superior, so the second axis has to change its sign;
# ITK changes the first: the volume is turned by 180 degrees about the long axis of the body, with no warning. RAS is read right.
# Seen on 2026-11-27: "las.nrrd: ... origin -1 2 3 directions -1 1 1" where the origin 1 2 3 should become 1 -2 3.
# Usage: findings/itk_nrrd_left_anterior.sh     needs g++, python3, root's apt and Debian 13's packages; exits with 1 if that changes.
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
for name, space in (("lps", "left-posterior-superior"), ("ras", "right-anterior-superior"), ("las", "left-anterior-superior")):
    header = ("NRRD0004\ntype: uint8\ndimension: 3\nspace: " + space + "\nsizes: 2 3 4\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
              "kinds: domain domain domain\nencoding: raw\nspace origin: (1,2,3)\n\n")
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
root/usr/lib64/ld-linux-x86-64.so.2 --library-path $lib:root/usr/lib ./read lps.nrrd ras.nrrd las.nrrd | tee seen
diff seen - <<'E' || exit 1
lps.nrrd: spacing 1 1 1 origin 1 2 3 directions 1 1 1
ras.nrrd: spacing 1 1 1 origin -1 -2 3 directions -1 -1 1
las.nrrd: spacing 1 1 1 origin -1 2 3 directions -1 1 1
E
