#!/usr/bin/env bash
# assimp 5.4.3 (Debian 13: assimp-utils 5.4.3+ds-2): "assimp export" to 3MF writes the meshes where they are in their own coordinates, says
# "millimeter", and leaves out every transform: a 3MF whose item is scaled by 2 and moved comes back at its origin in its first size, one that is built
# twice, 100 mm apart, twice in the same place, and of a COLLADA file in meters 1 m is 1 mm. A glTF file with one node, which has the mesh, becomes
# a 3MF without any mesh. To STL the transforms are kept; there the unit of a 3MF is passed over (a bone in inches is in numbers of inches) while
# that of a COLLADA file is used, to turn all into meters: of a file in millimeters, 1 mm becomes 0.001. With Z_UP that is turned as well,
# (x, y, z) to (x, z, -y), and no longer lies on the same bone from another format. And a mesh that its file mirrors, by a scale of -1 in glTF or
# in a 3MF's transform, as a left bone is made of a right one, keeps the order of its corners: all normals point inwards, the volume is negative.
# Exit status 0 in all of this, no message.
# Seen on 2026-12-01: "3MF, twice the size and moved, to 3MF: millimeter, ... 0..1 0..2 0..3" for 10..12 20..24 30..36, and the lines below.
# Usage: findings/assimp_place_and_unit.sh     needs python3, root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y assimp-utils=5.4.3+ds-2 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >units.py <<'P'
import base64
import json
import re
import struct
import subprocess
import zipfile

# A box of 1 x 2 x 3 with its faces outwards.
POINTS = [(x, y, z) for z in (0, 3) for y in (0, 2) for x in (0, 1)]
SIDES = (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)
TRIANGLES = [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))]


def named(ending):
    """Another file for each source."""
    named.count += 1
    return "in%d.%s" % (named.count, ending)


named.count = 0


def threemf(unit, *transforms):
    vertices = "".join('<vertex x="%g" y="%g" z="%g"/>' % p for p in POINTS)
    triangles = "".join('<triangle v1="%d" v2="%d" v3="%d"/>' % t for t in TRIANGLES)
    package = "http://schemas.openxmlformats.org/package/2006/"
    ours = "http://schemas.microsoft.com/3dmanufacturing/"
    items = "".join('<item objectid="1" transform="%s"/>' % t for t in transforms or ("1 0 0 0 1 0 0 0 1 0 0 0",))
    name = named("3mf")
    with zipfile.ZipFile("root/" + name, "w") as out:
        out.writestr("[Content_Types].xml", '<?xml version="1.0" encoding="UTF-8"?><Types xmlns="%scontent-types"><Default Extension="rels" '
                     'ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" '
                     'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>' % package)
        out.writestr("_rels/.rels", '<?xml version="1.0" encoding="UTF-8"?><Relationships xmlns="%srelationships"><Relationship Id="r" '
                     'Target="/3D/3dmodel.model" Type="%s2013/01/3dmodel"/></Relationships>' % (package, ours))
        out.writestr("3D/3dmodel.model", '<?xml version="1.0" encoding="UTF-8"?><model unit="%s" xmlns="%score/2015/02"><resources>'
                     '<object id="1" type="model"><mesh><vertices>%s</vertices><triangles>%s</triangles></mesh></object></resources>'
                     '<build>%s</build></model>' % (unit, ours, vertices, triangles, items))
    return name


def collada(meter, up):
    numbers = " ".join("%g %g %g" % p for p in POINTS)
    corners = " ".join("%d %d %d" % t for t in TRIANGLES)
    params = "".join('<param name="%s" type="float"/>' % axis for axis in "XYZ")
    name = named("dae")
    with open("root/" + name, "w") as out:
        out.write('<?xml version="1.0" encoding="utf-8"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
                  '<asset><created>2026-01-01T00:00:00Z</created><modified>2026-01-01T00:00:00Z</modified>'
                  '<unit name="unit" meter="%s"/><up_axis>%s</up_axis></asset><library_geometries><geometry id="g"><mesh><source id="s">'
                  '<float_array id="a" count="24">%s</float_array><technique_common><accessor source="#a" count="8" stride="3">%s</accessor>'
                  '</technique_common></source><vertices id="v"><input semantic="POSITION" source="#s"/></vertices><triangles count="12">'
                  '<input semantic="VERTEX" source="#v" offset="0"/><p>%s</p></triangles></mesh></geometry></library_geometries>'
                  '<library_visual_scenes><visual_scene id="w"><node id="n"><instance_geometry url="#g"/></node></visual_scene>'
                  '</library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>' % (meter, up, numbers, params, corners))
    return name


def gltf(scale):
    data = b"".join(struct.pack("<3f", *p) for p in POINTS) + b"".join(struct.pack("<3H", *t) for t in TRIANGLES)
    text = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "scale": scale}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
             "buffers": [{"byteLength": len(data), "uri": text}],
             "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 3]},
                           {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}]}
    name = named("gltf")
    with open("root/" + name, "w") as out:
        json.dump(scene, out)
    return name


def exported(source, kind):
    subprocess.run(["chroot", "root", "/usr/bin/assimp", "export", "/" + source, "/out." + kind], check=True, stdout=subprocess.DEVNULL)
    if kind == "3mf":
        with zipfile.ZipFile("root/out.3mf") as archive:
            text = next(archive.read(name).decode() for name in archive.namelist() if name.endswith(".model"))
        points = [tuple(float(re.search(axis + '="([^"]*)"', v)[1]) for axis in "xyz") for v in re.findall("<vertex [^>]*>", text)]
        note = "%s, %d points, %d transforms, " % (re.search('unit="([^"]*)"', text)[1], len(points), text.count("transform="))
    else:
        with open("root/out." + kind) as text:
            points = [tuple(map(float, line.split()[1:])) for line in text if line.split()[:1] == ["vertex"]]
        volume = sum((a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
                     for a, b, c in zip(points[::3], points[1::3], points[2::3]))
        note = "volume %.3g, " % volume
    if not points:
        return note + "nothing"
    return note + " ".join("%g..%g" % (min(p[k] for p in points), max(p[k] for p in points)) for k in range(3))


SAME = "1 0 0 0 1 0 0 0 1 0 0 0"
MOVED_ON = "1 0 0 0 1 0 0 0 1 100 0 0"
MOVED = "2 0 0 0 2 0 0 0 2 10 20 30"
MIRRORED = "-1 0 0 0 1 0 0 0 1 0 0 0"
for kind in ("3mf", "stl"):
    for name, source in (("3MF in millimeters", threemf("millimeter")), ("3MF in inches", threemf("inch")),
                         ("3MF, twice the size and moved", threemf("millimeter", MOVED)),
                         ("3MF, built twice", threemf("millimeter", SAME, MOVED_ON)), ("3MF, mirrored", threemf("millimeter", MIRRORED)),
                         ("glTF", gltf([1, 1, 1])), ("glTF, mirrored", gltf([-1, 1, 1])), ("COLLADA in meters", collada("1", "Y_UP")),
                         ("COLLADA in millimeters", collada("0.001", "Y_UP")), ("COLLADA in meters, Z_UP", collada("1", "Z_UP"))):
        print("%s to %s: %s" % (name, kind.upper(), exported(source, kind)))
P
python3 units.py | tee seen
diff seen - <<'E' || exit 1
3MF in millimeters to 3MF: millimeter, 8 points, 0 transforms, 0..1 0..2 0..3
3MF in inches to 3MF: millimeter, 8 points, 0 transforms, 0..1 0..2 0..3
3MF, twice the size and moved to 3MF: millimeter, 8 points, 0 transforms, 0..1 0..2 0..3
3MF, built twice to 3MF: millimeter, 16 points, 0 transforms, 0..1 0..2 0..3
3MF, mirrored to 3MF: millimeter, 8 points, 0 transforms, 0..1 0..2 0..3
glTF to 3MF: millimeter, 0 points, 0 transforms, nothing
glTF, mirrored to 3MF: millimeter, 0 points, 0 transforms, nothing
COLLADA in meters to 3MF: millimeter, 36 points, 0 transforms, 0..1 0..2 0..3
COLLADA in millimeters to 3MF: millimeter, 36 points, 0 transforms, 0..1 0..2 0..3
COLLADA in meters, Z_UP to 3MF: millimeter, 36 points, 0 transforms, 0..1 0..2 0..3
3MF in millimeters to STL: volume 6, 0..1 0..2 0..3
3MF in inches to STL: volume 6, 0..1 0..2 0..3
3MF, twice the size and moved to STL: volume 48, 10..12 20..24 30..36
3MF, built twice to STL: volume 12, 0..101 0..2 0..3
3MF, mirrored to STL: volume -6, -1..0 0..2 0..3
glTF to STL: volume 6, 0..1 0..2 0..3
glTF, mirrored to STL: volume -6, -1..0 0..2 0..3
COLLADA in meters to STL: volume 6, 0..1 0..2 0..3
COLLADA in millimeters to STL: volume 6e-09, 0..0.001 0..0.002 0..0.003
COLLADA in meters, Z_UP to STL: volume 6, 0..1 0..3 -2..0
E
