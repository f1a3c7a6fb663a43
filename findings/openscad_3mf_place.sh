#!/usr/bin/env bash
# OpenSCAD 2021.01 (Debian 12: openscad 2021.01-6), which models of implants and guides are made with: import("FILE.3mf") takes the meshes of a
# file and nothing that the file says about them. A cube of one inch is 1 mm, whatever "unit" is (micron to meter); the transform of a build
# item does not move, scale or turn it; an object that is built twice is there once, an object made of components is missing but for the
# mesh of the component, and one that the file defines and does not build is imported. Exit code 0, no message. So a guide that was placed on a
# bone in another program lies at its own origin, and its size has to be checked.
# Seen on 2026-12-01: every file below gives the cube from 0 to 1.
# Usage: findings/openscad_3mf_place.sh     needs python3, root's apt and chroot; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# Packages into the folder root, with an apt of its own that knows nothing of this machine's packages.
mkdir -p apt/lists/partial apt/cache/archives/partial root
: >apt/status
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u)
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror bookworm main" >apt/sources
bookworm=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
          -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
          -o Acquire::Check-Valid-Until=false -o Acquire::Languages=none -o APT::Install-Recommends=false)
"${bookworm[@]}" update
"${bookworm[@]}" install --download-only -y openscad=2021.01-6 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done
mkdir -p root/tmp

python3 - <<'P'
import itertools
import zipfile

corners = "".join('<vertex x="%d" y="%d" z="%d"/>' % c[::-1] for c in itertools.product((0, 1), repeat=3))
sides = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
cube = ('<object id="1" type="model"><mesh><vertices>' + corners + "</vertices><triangles>" +
        "".join('<triangle v1="%d" v2="%d" v3="%d"/>' % t for t in sides) + "</triangles></mesh></object>")
package = "http://schemas.openxmlformats.org/package/2006/"
printing = "http://schemas.microsoft.com/3dmanufacturing/"


def item(number=1, transform="1 0 0 0 1 0 0 0 1 0 0 0"):
    return f'objectid="{number}" transform="{transform}"/>'


def write(name, build, unit="millimeter", more=""):
    with zipfile.ZipFile(f"root/tmp/{name}.3mf", "w") as file:
        file.writestr("[Content_Types].xml", f'<Types xmlns="{package}content-types"><Default Extension="rels" '
                      'ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" '
                      'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')
        file.writestr("_rels/.rels", f'<Relationships xmlns="{package}relationships"><Relationship Target="/3D/3dmodel.model" '
                      f'Id="r" Type="{printing}2013/01/3dmodel"/></Relationships>')
        file.writestr("3D/3dmodel.model", f'<model unit="{unit}" xmlns="{printing}core/2015/02"><resources>{cube}{more}</resources>'
                      f"<build>{build}</build></model>")


write("inch", "<item " + item(), "inch")
write("moved", "<item " + item(transform="1 0 0 0 1 0 0 0 1 10 20 30"))
write("doubled", "<item " + item(transform="2 0 0 0 2 0 0 0 2 0 0 0"))
write("twice", "<item " + item() + "<item " + item(transform="1 0 0 0 1 0 0 0 1 5 0 0"))
write("components", "<item " + item(2), more='<object id="2" type="model"><components><component ' + item() + "<component " +
      item(transform="1 0 0 0 1 0 0 0 1 5 0 0") + "</components></object>")
write("unbuilt", "")
P
for name in inch moved doubled twice components unbuilt; do
    echo "import(\"/tmp/$name.3mf\");" >root/tmp/import.scad
    rm -f root/tmp/out.stl
    status=0
    QT_QPA_PLATFORM=offscreen chroot root /usr/bin/openscad -o /tmp/out.stl /tmp/import.scad >log 2>&1 || status=$?
    warnings=$(grep -ci 'warning\|error' log || true)
    awk -v name=$name -v status=$status -v warnings="$warnings" '
        $1 == "vertex" { for (d = 2; d < 5; ++d) { if (n == 0 || $d < lo) lo = $d; if (n == 0 || $d > hi) hi = $d; ++n } }
        END { printf "%s: status %d, warnings %d, triangles %d, from %g to %g\n", name, status, warnings, n / 9, lo, hi }' root/tmp/out.stl
done | tee seen
diff seen - <<'E' || exit 1
inch: status 0, warnings 0, triangles 12, from 0 to 1
moved: status 0, warnings 0, triangles 12, from 0 to 1
doubled: status 0, warnings 0, triangles 12, from 0 to 1
twice: status 0, warnings 0, triangles 12, from 0 to 1
components: status 0, warnings 0, triangles 12, from 0 to 1
unbuilt: status 0, warnings 0, triangles 12, from 0 to 1
E
