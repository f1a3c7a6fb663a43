#!/usr/bin/env bash
# PoCL 3.1 (Debian 12: pocl-opencl-icd 3.1-3+deb12u1, ocl-icd-libopencl1 2.3.1-1): a program that asks OpenCL only for the number of
# platforms, by clGetPlatformIDs(0, NULL, &n), with no device, context or kernel, grows from 1 to some 60 MB of resident memory,
# since the loader opens every driver there is, and PoCL's brings the libraries of Clang and LLVM with it. They stay: the loader
# closes no driver. A program that looks for a GPU and finds none has these 60 MB for the rest of its run, and one that states
# its memory beforehand is wrong by them.
# Seen on 2026-11-29: "without a driver: platforms 0, 1 MB before, 1 MB after", "with PoCL: platforms 1, 1 MB before, 65 MB after".
# Usage: findings/pocl_memory_of_a_question.sh     needs root's apt and chroot, a C compiler and 500 MB; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

cat >ask.c <<'C'
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
static long resident(void) { /* MB */
    FILE *file = fopen("/proc/self/statm", "r");
    long size = 0, pages = 0;
    if (!file || fscanf(file, "%ld %ld", &size, &pages) != 2) return -1;
    fclose(file);
    return pages * 4096 / 1000000;
}
int main(void) {
    void *library = dlopen("libOpenCL.so.1", RTLD_NOW);
    if (!library) return 2;
    int (*ask)(unsigned, void *, unsigned *) = (int (*)(unsigned, void *, unsigned *))dlsym(library, "clGetPlatformIDs");
    unsigned count = 0;
    const long before = resident();
    ask(0, NULL, &count);
    printf("%u %ld %ld\n", count, before, resident());
    return 0;
}
C
cc ask.c -o ask -ldl

# Packages of Debian 12 into a folder, with an apt of its own that knows nothing of this machine's packages.
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u | head -1)
installed() { # FOLDER PACKAGE...
    local root=$1
    shift
    mkdir -p apt/lists/partial apt/cache/archives/partial "$root/proc"
    : >apt/status
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror bookworm main" >apt/sources
    local own=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
               -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
               -o Acquire::Languages=none -o APT::Install-Recommends=false)
    "${own[@]}" update
    "${own[@]}" install --download-only -y "$@" >/dev/null
    for package in apt/cache/archives/*.deb; do dpkg -x "$package" "$root"; rm "$package"; done
    cp ask "$root/ask"
}
asked() { # FOLDER
    unshare --mount bash -c 'mount -t proc proc "$0/proc"; export HOME=/tmp; exec chroot "$0" /ask' "$PWD/$1"
}

installed without ocl-icd-libopencl1=2.3.1-1
installed with ocl-icd-libopencl1=2.3.1-1 pocl-opencl-icd=3.1-3+deb12u1
read -r none before_none after_none < <(asked without)
read -r one before_one after_one < <(asked with)
echo "without a driver: platforms $none, $before_none MB before, $after_none MB after"
echo "with PoCL: platforms $one, $before_one MB before, $after_one MB after"
if [ "$none" -ne 0 ] || [ $((after_none - before_none)) -ge 3 ] || [ "$one" -ne 1 ] || [ $((after_one - before_one)) -le 40 ]; then
    echo "this has changed" >&2
    exit 1
fi
