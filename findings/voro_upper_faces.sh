#!/usr/bin/env bash
# Voro++ 0.4.6 (Debian 12: voro++ 0.5+revert-to-0.4.6+dfsg1-1): its box is half-open. A center exactly on an upper face of the box, or beyond any
# face, is left out without a message, with exit status 0, and its neighbors share its room: of three centers in a unit cube, the cell of one on
# the lower face has a volume of 0.25, that of one on the upper face is missing and the others grow. So local solid fractions by Voronoi cells
# of a specimen that was cut at its outermost centers, or given its bounding box of centers, are wrong on three of six sides. "-p" wraps instead:
# there a center on the upper face lies on the lower one.
# Seen on 2026-11-30: cells of centers at x = 0, 0.5 and 1 of a box from 0 to 1: "0 0.25, 0.5 0.75"; of a box to 1.0001: "0 0.25, 0.5 0.5, 1 0.2501".
# Usage: findings/voro_upper_faces.sh     needs root's apt; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
apt-get download -qq voro++=0.5+revert-to-0.4.6+dfsg1-1 2>/dev/null
dpkg -x voro++_*.deb root
voro=root/usr/bin/voro++

printf '1 0 0.5 0.5\n2 0.5 0.5 0.5\n3 1 0.5 0.5\n' >centers
cells() {  # NAME OPTIONS: the volumes of cells
    "$voro" -c '%x %v' "${@:2}" 0 1 0 1 centers
    printf '%s, status %d: %s\n' "$1" $? "$(sort -n centers.vol | paste -sd, | sed 's/,/, /g')"
}
{
    cells 'box to 1' 0 1
    cells 'box to 1.0001' 0 1.0001
    printf '1 0 0.5 0.5\n2 0.5 0.5 0.5\n3 7 0.5 0.5\n' >centers
    cells 'box to 1, one far outside' 0 1
} | tee seen
diff seen - <<'E2' || exit 1
box to 1, status 0: 0 0.25, 0.5 0.75
box to 1.0001, status 0: 0 0.25, 0.5 0.5, 1 0.2501
box to 1, one far outside, status 0: 0 0.25, 0.5 0.75
E2
