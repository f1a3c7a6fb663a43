#!/usr/bin/env bash
# HDF5 2 (h5wasm 0.10.3) against HDF5 1.14 (h5wasm 0.8.11), both with their defaults: a file with two groups and an attribute, written twice with
# a pause of 1.5 s between. HDF5 1.14 writes superblock 0 and groups without times: both files are the same to the byte. HDF5 2 writes
# superblock 2, since its default lower bound of the format is 1.8, and groups with four times each: the two files differ. Who compares files by
# their hashes gets another one with each run; track_times of datasets, which many programs turn off, does not change that. What helps is a lower
# bound of the format (H5Pset_libver_bounds, earliest): HDF5 2.2 then writes what 1.10 wrote.
# Seen on 2026-11-27: "0.8.11 superblock 0 same", "0.10.3 superblock 2 differ".
# Usage: findings/hdf5_2_group_times.sh     needs node and npm; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

cat >write.mjs <<'J'
import h5 from "h5wasm/node";
await h5.ready;
for (const name of ["first.h5", "second.h5"]) {
    const file = new h5.File(name, "w");
    file.create_group("VTKHDF").create_group("PointData");
    file.get("VTKHDF").create_attribute("Type", "UnstructuredGrid");
    file.close();
    if (name === "first.h5") await new Promise((resolve) => setTimeout(resolve, 1500));
}
J
echo '{"name": "trial", "private": true}' >package.json

# What two files of a version are; the version is installed already.
compare() {
    node write.mjs
    echo "$1 superblock $(od -An -tu1 -j8 -N1 first.h5 | tr -d ' ') $(cmp -s first.h5 second.h5 && echo same || echo differ)"
}
npm install --silent --no-audit --no-fund h5wasm@0.8.11 >messages 2>&1
compare 0.8.11 | tee seen
npm install --silent --no-audit --no-fund h5wasm@0.10.3 >messages 2>&1
compare 0.10.3 | tee -a seen
printf '%s\n' "0.8.11 superblock 0 same" "0.10.3 superblock 2 differ" | diff - seen || exit 1
