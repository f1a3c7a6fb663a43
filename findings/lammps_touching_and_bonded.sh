#!/usr/bin/env bash
# LAMMPS 4 Feb 2025 (Debian 13: lammps 20250204+dfsg.1-2): "compute contact/atom" and the forces of "pair_style gran" mean different
# contacts. Two spheres that touch exactly (centres 1 apart, radii 0.5) are one contact each and have no force, so a count of contacts
# by force differs from this one for a pack of touching spheres. The same two, overlapping and with force, joined by a bond, have no
# contact and no force: special_bonds leaves bonded pairs out of the list that the compute reads, so the number of contacts of a bonded
# pack falls as bonds are added. And for that the style must be "hybrid sphere bond": a Bonds section under plain "atom_style sphere"
# is an error although extra/bond/per/atom is taken.
# Seen on 2026-11-27: "touching: 1 0", "overlapping: 1 -1", "overlapping and bonded: 0 0" (contacts, force), and the error below.
# Usage: findings/lammps_touching_and_bonded.sh     needs root's apt and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y lammps=20250204+dfsg.1-2 >/dev/null
for package in apt/cache/archives/*.deb; do dpkg -x "$package" root; done
lib=root/usr/lib/x86_64-linux-gnu
lmp() {
    UCX_LOG_LEVEL=fatal root/usr/lib64/ld-linux-x86-64.so.2 --library-path $lib:$lib/blas:$lib/lapack:$lib/openblas-pthread root/usr/bin/lmp \
        -log none -in "$1" 2>&1
}

pair() {  # NAME DISTANCE STYLE BONDS: two spheres of radius 0.5
    {
        printf '%s\n\n2 atoms\n1 atom types\n' "$1"
        [ "$4" = 0 ] || printf '1 bonds\n1 bond types\n'
        printf '\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\nAtoms\n\n'
        if [ "$3" = sphere ]; then
            printf '1 1 1 2 5 5 5\n2 1 1 2 5 5 %s\n' "$2"
        else
            printf '1 1 5 5 5 1 2 0\n2 1 5 5 %s 1 2 0\n' "$2"
        fi
        [ "$4" = 0 ] || printf '\nBonds\n\n1 1 1 2\n'
    } >pair.data
    {
        printf 'units si\natom_style %s\nboundary f f f\ncomm_modify vel yes\n' "$3"
        [ "$4" = 0 ] && printf 'read_data pair.data\n' ||
            printf 'read_data pair.data extra/bond/per/atom 1 extra/special/per/atom 1\nbond_style zero\nbond_coeff 1\n'
        printf 'pair_style gran/hooke 100 NULL 0 NULL 0 0\npair_coeff * *\ncompute c all contact/atom\n'
        printf 'dump d all custom 1 pair.dump id c_c fz\ndump_modify d sort id format line "%%d %%g %%.3g"\nrun 0\n'
    } >pair.in
    rm -f pair.dump
    if lmp pair.in >log; then awk -v name="$1" '$1 == 1 && NF == 3 { print name ":", $2, $3 }' pair.dump; else
        echo "$1: $(grep -o 'ERROR: [^(]*[^ (]' log | head -1)"
    fi
}
{
    pair touching 6 sphere 0
    pair overlapping 5.99 sphere 0
    pair "overlapping and bonded" 5.99 "hybrid sphere bond" 1
    pair "bonded, plain sphere" 5.99 sphere 1
} | tee seen
diff seen - <<'E' || exit 1
touching: 1 0
overlapping: 1 -1
overlapping and bonded: 0 0
bonded, plain sphere: ERROR: No bonds allowed with atom style sphere
E
