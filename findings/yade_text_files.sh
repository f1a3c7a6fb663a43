#!/usr/bin/env bash
# YADE 2025.2.0 (Debian 13: yade 2025.2.0-1+b1; 2023.02a of Debian 12 likewise): the two ways of keeping a pack as text do not fit
# together. export.text writes a first line "#format x_y_z_r" that ymport.text skips and pack.SpherePack.load refuses ("has 2 columns"),
# so YADE does not read its own file back that way. A blank line at the end, as editors and other programs leave it, is skipped by
# SpherePack.load and raises IndexError in ymport.text. And both writers keep 6 digits: with coordinates in micrometres a centre
# at 12345.67 becomes 12345.7, 3 % of a radius of 1 away, where the pack was made to touch.
# Seen on 2026-11-27: "exported: ymport.text 1 SpherePack.load ValueError", "blank: ymport.text IndexError SpherePack.load 1".
# Usage: findings/yade_text_files.sh     needs root's apt and chroot and 500 MB of Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y yade=2025.2.0-1+b1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/text.py <<'P'
import os
import sys

from yade import O, export, pack, utils, ymport


def tried(read):
    try:
        return read()
    except Exception as error:
        return type(error).__name__


def load(name):
    spheres = pack.SpherePack()
    spheres.load(name)
    return len(spheres)


O.bodies.append(utils.sphere((12345.67, 0, 0), 1))
export.text("/tmp/exported.txt")
pack.SpherePack([((12345.67, 0, 0), 1)]).save("/tmp/saved.txt")
with open("/tmp/blank.txt", "w") as file:
    file.write("0 0 0 1\n\n")
words = [line.split()[0] for name in ("exported", "saved") for line in open(f"/tmp/{name}.txt") if line.strip() and line[0] != "#"]
print("written:", *words)
for name in ("exported", "saved", "blank"):
    path = f"/tmp/{name}.txt"
    print(f"{name}: ymport.text", tried(lambda: len(ymport.text(path))), "SpherePack.load", tried(lambda: load(path)))
sys.stdout.flush()
os._exit(0)
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack:$lib/openblas-pthread HOME=/tmp UCX_LOG_LEVEL=fatal \
    /usr/bin/python3 /usr/bin/yade -n -x -j1 /text.py 2>messages | grep -E "^(written|exported|saved|blank):" | tee seen
diff seen - <<'E' || exit 1
written: 12345.7 12345.7
exported: ymport.text 1 SpherePack.load ValueError
saved: ymport.text 1 SpherePack.load 1
blank: ymport.text IndexError SpherePack.load 1
E
