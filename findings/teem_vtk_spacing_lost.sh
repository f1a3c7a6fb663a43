#!/usr/bin/env bash
# teem 1.12.0 (Debian 13: teem-apps 1.12.0~20160122-6): "teem-unu save -f vtk" of a NRRD whose voxel sizes are in "space directions", as all
# NRRDs with a space have them, writes SPACING 1 1 1 and ORIGIN 0 0 0 into the STRUCTURED_POINTS file, though the axes are straight
# and the format has both. With "spacings" and "axis mins" they are kept. No message, exit status 0: a micro-CT of 0.02 mm becomes
# fifty times as large and leaves its place. And "-en big", the order of bytes that VTK's binary files have, turns all values round: they
# are right with the default, "little", only, since the writer swaps after that option once more.
# Seen on 2026-11-30: "directions: spacing 1 1 1 origin 0 0 0", "spacings: spacing 0.5 0.25 2 origin 10 20 30", "-en big: 256 512 ...".
# Usage: findings/teem_vtk_spacing_lost.sh     needs python3, root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y teem-apps=1.12.0~20160122-6 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

{
    printf 'NRRD0005\ntype: short\ndimension: 3\nsizes: 2 2 2\nspace: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.25,0) (0,0,2)\n'
    printf 'space origin: (10,20,30)\nencoding: ascii\n\n1 2 3 4 5 6 7 8\n'
} >root/directions.nrrd
{
    printf 'NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 2\nspacings: 0.5 0.25 2\naxis mins: 10 20 30\n'
    printf 'encoding: ascii\n\n1 2 3 4 5 6 7 8\n'
} >root/spacings.nrrd
save() {  # NAME OPTIONS
    local name=$1
    shift
    chroot root /usr/bin/teem-unu save -i /$name.nrrd -f vtk "$@" -o /$name.vtk
    python3 - "$name $*" root/$name.vtk <<'P'
import struct
import sys

head, _, values = open(sys.argv[2], "rb").read().partition(b"LOOKUP_TABLE default\n")
words = {line.split()[0]: line.split()[1:] for line in head.decode().splitlines() if line}
print(sys.argv[1].strip() + ": spacing", *words["SPACING"], "origin", *words["ORIGIN"], "values", *struct.unpack(">8h", values[:16]))
P
}
{
    save directions
    save spacings
    save spacings -en big
} | tee seen
diff seen - <<'E' || exit 1
directions: spacing 1 1 1 origin 0 0 0 values 1 2 3 4 5 6 7 8
spacings: spacing 0.5 0.25 2 origin 10 20 30 values 1 2 3 4 5 6 7 8
spacings -en big: spacing 0.5 0.25 2 origin 10 20 30 values 256 512 768 1024 1280 1536 1792 2048
E
