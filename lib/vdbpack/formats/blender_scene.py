"""A packed bone in Blender (3.4 and later): true spheres, the bone's surface, camera and light.

    blender -P NAME.py                                        in the window
    blender -b -P NAME.py -- --color region --render bone.png     a picture, without one
    blender -b -P NAME.py -- --grow 120 --render grow_####.png    120 pictures of the bone growing

Options follow a lone "--"; `-- --help` lists them. The files that PACK names lie beside this script
and move with it. In the window, the tab "vdb_pack" of the 3D view's sidebar (key N) colors the
spheres again.
"""

import argparse
import math
import os
import re
import sys
import zipfile
import zlib

import bpy
from mathutils import Matrix

try:
    import numpy as np
except ImportError:
    sys.exit("Blender's Python has no numpy, which reads the spheres; on Debian: "
             "apt-get install python3-numpy")

PACK = {}  # filled in by the writer
SPHERES = "vdb_pack spheres"


def fail(message):
    """Ends the run; in a window, where work may lie unsaved, only the script."""
    message = f"{PACK.get('name', 'blender_scene.py')}: {message}"
    if bpy.app.background:
        sys.exit(message)
    raise RuntimeError(message)


def set_all(target, **values):
    for name, value in values.items():
        setattr(target, name, value)


def numbers(example, low=-1e9, high=1e9, kind=float, mark=","):
    """A type of options: as many numbers as the example has, parted by the mark."""
    def parse(text):
        try:
            values = [kind(word) for word in text.split(mark)]
        except ValueError:
            values = []
        if len(values) == len(example.split(mark)) and all(low <= v <= high for v in values):
            return values if mark in example else values[0]
        raise argparse.ArgumentTypeError(f"'{text}': write it like {example}, with numbers from "
                                         f"{low:g} to {high:g}")
    return parse


def cut_plane(text):
    """`x=3` keeps what lies at x <= 3, `x>3` what lies above: (axis, position, sign)."""
    found = re.fullmatch(r"([xyz])([=<>])([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)", text)
    if not found:
        raise argparse.ArgumentTypeError(f"'{text}': a plane such as x=0, y<2.5 or z>100 expected")
    axis, mark, position = found.groups()
    return "xyz".index(axis), float(position), -1 if mark == ">" else 1


def parse_arguments(words):
    parser = argparse.ArgumentParser(
        prog=f"blender -P {PACK['name']} --", description="Shows a pack of spheres in Blender.",
        epilog="A value that starts with a minus needs an equals sign: --view=-1,0,0")
    add = parser.add_argument
    add("--color", default="radius", help="column to color by, such as region, depth or order")
    add("--range", type=numbers("0.5,2"), metavar="A,B", help="values of the first and last color")
    add("--render", metavar="FILE.png", help="writes a picture; with --grow and #### all frames")
    add("--grow", type=numbers("120", 1, 1e6, int), nargs="?", const=120, metavar="FRAMES",
        help="spheres appear in the order they were placed (in 120 frames)")
    add("--cut", type=cut_plane, action="append", default=[], metavar="PLANE",
        help="x=V keeps x <= V, x>V the rest, in the unit of the file; may be repeated")
    add("--surface", default="", metavar="GRID", help="also shows a level set, such as solid")
    add("--opacity", type=numbers("0.25", 0, 1), default=0.25, help="of that surface (0.25)")
    add("--no-spheres", action="store_true", help="leaves the spheres out of the picture")
    add("--view", type=numbers("0.3,-1,0.2"), metavar="X,Y,Z", help="from where to look")
    add("--up", type=numbers("0,0,1"), default=[0, 0, 1], metavar="X,Y,Z", help="up in the picture")
    add("--size", type=numbers("1600x1200", 16, 16384, int, "x"), default=[1200, 1200],
        metavar="WxH", help="of the picture, pixels (1200x1200)")
    add("--samples", type=numbers("64", 1, 1e6, int), default=64, help="rays a pixel (64)")
    add("--background", choices=("white", "black", "transparent"), default="white")
    add("--save", metavar="FILE.blend", help="writes the scene for later")
    arguments = parser.parse_args(words)
    if not any(arguments.view or [1]) or not any(arguments.up):
        parser.error("--view and --up: 0,0,0 is no direction")
    return arguments


def beside(name):
    """The path of a file beside this script, which is a file or a text in Blender's editor."""
    text = getattr(getattr(bpy.context, "space_data", None), "text", None)
    for place in (globals().get("__file__", ""), bpy.path.abspath(text.filepath) if text else ""):
        if os.path.isfile(place):
            return os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(place)), name))
    fail("cannot tell where this script lies; save it, or run blender -P FILE")


def read_spheres():
    """All positions, and the columns of numbers by name."""
    path = beside(PACK["points"])
    try:
        with np.load(path) as file:
            columns = {name: file[name] for name in file.files}
    except (OSError, ValueError, zipfile.BadZipFile) as problem:
        fail(f"{path}: cannot be read: {problem}; keep it beside the script")
    place, radius = columns.pop("positions"), columns.pop("radii")
    if len(place) != PACK["count"] or zlib.crc32(place) != PACK["crc32"]:
        fail(f"{path}: is not the file that was written with this script; write both again with "
             "vdb_pack")
    return place, {"radius": radius, **{name: values for name, values in columns.items()
                                        if values.shape == radius.shape
                                        and values.dtype.kind in "if"}}


def attribute_name(column):
    """Points take what is called radius for their own, whatever radius is set in Mesh to Points."""
    return "radius_" + PACK["unit"] if column == "radius" else column


def make_points(place, columns, scale):
    """A mesh of vertices alone, with a column each as attribute."""
    mesh = bpy.data.meshes.new(SPHERES)
    mesh.vertices.add(len(place))
    mesh.vertices.foreach_set("co", (place * scale).astype(np.float32).ravel())
    for name, values in (*columns.items(), ("drawn_radius", columns["radius"] * scale)):
        whole = values.dtype.kind == "i"
        attribute = mesh.attributes.new(attribute_name(name), "INT" if whole else "FLOAT", "POINT")
        attribute.data.foreach_set("value", values.astype(np.int32 if whole else np.float32))
    mesh.update()
    return mesh


# blender_nodes.py


def add_object(collection, name, data, is_hidden=False, axes=np.eye(3), position=(0, 0, 0)):
    added = bpy.data.objects.new(name, data)
    collection.objects.link(added)
    added.hide_render = is_hidden
    added.hide_set(is_hidden)
    added.matrix_world = Matrix.Translation(position) @ Matrix(axes.T.tolist()).to_4x4()
    return added


def add_surfaces(collection, center, scale, shown, material):
    """The .vdb as a volume where the spheres are, and each of its level sets as a mesh."""
    volume = bpy.data.volumes.new("vdb_pack volume")
    volume.filepath = beside(PACK["volume"]) if PACK["volume"] else ""
    if PACK["volume"] and not volume.grids.load():
        print(f"{volume.filepath}: cannot be read: {volume.grids.error_message}; showing the spheres "
              "alone")
    grids = {grid.name: grid for grid in volume.grids if grid.data_type == "FLOAT"}
    if shown and shown not in grids:
        fail(f"--surface {shown}: there is no such level set; "
             f"use {', '.join(grids) or 'none: there are no level sets'}")
    holder = add_object(collection, "vdb_pack volume", volume, True)  # a level set is no fog
    set_all(holder, scale=(scale,) * 3, location=-scale * center)
    for name, grid in grids.items():
        skin = add_object(collection, f"vdb_pack {name}", bpy.data.meshes.new(name), name != shown)
        set_all(skin.modifiers.new("Volume to Mesh", "VOLUME_TO_MESH"), object=holder,
                grid_name=name, threshold=0.0, resolution_mode="GRID", use_smooth_shade=True)
        # Blender lays voxels' corners where the file has their centers: half a voxel too far.
        skin.location = [-0.5 * scale * edge for edge in grid.matrix_object.to_scale()]
        add_nodes(skin, f"vdb_pack {name}", material)


def basis(ahead, up):
    """Right, up and backward of a camera that looks from `ahead` at the origin."""
    back = np.array(ahead) / np.linalg.norm(ahead)
    for above in (up, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
        right = np.cross(above, back)
        if np.linalg.norm(right) > 1e-6 * np.linalg.norm(above):  # else it looks along `above`
            break
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def make_camera(scene, collection, place, radius, view, up):
    """A camera that sees all spheres and little else; clipped close around them."""
    if view is None:
        # From the front and a little above; circles from straight above.
        upright = abs(up[1]) < max(abs(up[0]), abs(up[2]))
        right, above, front = basis((0, -1.0, 0) if upright else (0, 0, 1.0), up)
        view = (0, 0, 1.0) if PACK["dim"] == 2 else 0.45 * right + 0.3 * above + front
    axes = basis(view, up)
    camera = bpy.data.cameras.new("vdb_pack camera")
    camera.lens = 70
    size = np.array((scene.render.resolution_x, scene.render.resolution_y))
    tangent = 0.5 * camera.sensor_width / camera.lens * size / size.max()
    place = place @ axes.T
    low, high = (place - radius[:, None]).min(axis=0), (place + radius[:, None]).max(axis=0)
    middle, deep = 0.5 * (low + high), 0.5 * (high - low)[2]
    place -= middle
    # In each direction the farthest sphere out decides, the sooner the nearer it is.
    reach = (np.abs(place[:, :2]) + 1.05 * radius[:, None]) / tangent + place[:, 2:]
    distance = 1.04 * float(reach.max())
    camera.clip_start = max(0.5 * (distance - deep), 1e-3 * distance)
    camera.clip_end = 4 * (distance + deep)
    scene.camera = add_object(collection, "vdb_pack camera", camera, False, axes,
                              (middle + (0, 0, distance)) @ axes)
    return axes, camera


def make_light(scene, collection, axes, background):
    sun = bpy.data.lights.new("vdb_pack sun", "SUN")
    set_all(sun, energy=3.0, angle=math.radians(12))  # soft shadows
    # Over the left shoulder of who looks.
    add_object(collection, "vdb_pack sun", sun, False, basis((-0.6, 0.8, 1.0) @ axes, axes[1]))
    # The soft fill comes from everywhere; the camera sees a plain color instead.
    scene.world = bpy.data.worlds.new("vdb_pack fill")
    nodes = shader_nodes(scene.world)
    fill = nodes.add("ShaderNodeBackground", (0.9, 0.95, 1.0, 1.0), 0.45)
    plain = 0.0 if background == "black" else 1.0
    seen = nodes.add("ShaderNodeBackground", (plain, plain, plain, 1.0), 1.0)
    ray = nodes.add("ShaderNodeLightPath").node.outputs["Is Camera Ray"]
    nodes.add("ShaderNodeOutputWorld", nodes.add("ShaderNodeMixShader", ray, fill, seen))


def make_scene(arguments):
    scene = bpy.data.scenes.new(os.path.splitext(PACK["name"])[0])
    for window in bpy.context.window_manager.windows:
        window.scene = scene
    # A build without a denoiser (Debian's) stops a render that asks for one.
    denoises = bool(getattr(sys.modules.get("_cycles"), "with_openimagedenoise", False))
    set_all(scene.render, engine="CYCLES", resolution_x=arguments.size[0],
            resolution_y=arguments.size[1], film_transparent=arguments.background == "transparent")
    set_all(scene.cycles, samples=arguments.samples, preview_samples=16, max_bounces=4,
            transparent_max_bounces=64, use_denoising=denoises, use_preview_denoising=denoises)
    scene.view_settings.view_transform = "Standard"  # colors as they are named
    if arguments.grow:  # all of it, until played
        set_all(scene, frame_start=1, frame_end=arguments.grow, frame_current=arguments.grow)
    return scene


def limits_text(name, limits):
    unit = " " + PACK["unit"] if name in ("radius", "depth") else ""
    return f"{limits[0]:.4g} to {limits[1]:.4g}{unit}"


def show_in_windows(scene, camera, material, limits, color):
    """Every 3D view looks through the camera; its sidebar has a tab with the columns to color by."""
    for window in bpy.context.window_manager.windows:
        for space in (s for area in window.screen.areas for s in area.spaces if s.type == "VIEW_3D"):
            space.clip_start, space.clip_end = camera.clip_start / 20, camera.clip_end * 5
            # Solid shows the spheres in gray, Material Preview not at all (3.4).
            space.shading.type = "RENDERED"
            space.region_3d.view_perspective = "CAMERA"

    def changed(owner, _context):
        color_by(material, owner.vdb_pack_color, limits[owner.vdb_pack_color])

    def draw(panel, context):
        name = context.scene.vdb_pack_color
        panel.layout.prop(context.scene, "vdb_pack_color", text="Color")
        panel.layout.label(text=limits_text(name, limits[name]))
        panel.layout.label(text=f"{PACK['count']} spheres, lengths in {PACK['unit']}")

    bpy.types.Scene.vdb_pack_color = bpy.props.EnumProperty(
        name="Color", items=[(name, name, limits_text(name, limits[name])) for name in limits],
        update=changed)
    bpy.utils.register_class(type("VDBPACK_PT_pack", (bpy.types.Panel,), {
        "bl_label": "Spheres", "bl_category": "vdb_pack", "bl_space_type": "VIEW_3D",
        "bl_region_type": "UI", "draw": draw}))
    scene.vdb_pack_color = color


def chosen_colors(arguments, columns):
    """Least and greatest value of each column to color by, and those of the colors."""
    limits = {name: (float(np.nanmin(values)), float(np.nanmax(values)))
              for name, values in columns.items() if name != "id" and np.isfinite(values).any()}
    if "region" in limits:
        limits["region"] = (0.0, 1.0)
    if arguments.color not in limits:
        fail(f"there is no column '{arguments.color}' to color by; use {', '.join(limits)}")
    if arguments.grow and "order" not in limits:
        fail("--grow: the pack has no column 'order'; pack it again")
    low, high = arguments.range or limits[arguments.color]
    if low > high:
        fail(f"--range {low:g},{high:g}: the lesser number comes first")
    return limits, (low, high)


def main():
    arguments = parse_arguments(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    if PACK["count"] == 0:
        fail("the pack holds no spheres; nothing to show")
    place, columns = read_spheres()
    center = 0.5 * (place.min(axis=0) + place.max(axis=0))
    # Blender units in one unit of the file: a power of ten for an object of 1 to 10 units.
    extent = np.ptp(place, axis=0).max() + 2 * columns["radius"].max()
    scale = 10.0 ** -math.floor(math.log10(extent))
    kept = np.ones(len(place), bool)
    for axis, position, sign in arguments.cut:
        kept &= sign * (place[:, axis] - position) <= 0
    if not kept.any():
        fail("the cuts leave no sphere; move them, or turn them around (x<0, x>0)")
    place = place[kept] - center
    columns = {name: values[kept] for name, values in columns.items()}
    limits, colors = chosen_colors(arguments, columns)

    scene = make_scene(arguments)
    collection = bpy.data.collections.new(scene.name)
    scene.collection.children.link(collection)
    material = sphere_material()
    color_by(material, arguments.color, colors)
    spheres = add_object(collection, SPHERES, make_points(place, columns, scale),
                         arguments.no_spheres)
    growth = (*limits["order"], arguments.grow) if arguments.grow else None
    add_nodes(spheres, SPHERES, material, lambda *points: true_spheres(*points, growth))
    for name, value in (("unit_of_length", PACK["unit"]), ("blender_units_in_one_unit", scale),
                        ("center", center.tolist()), ("generator", PACK["generator"])):
        spheres[name] = value
    cuts = [(axis, (at - center[axis]) * scale, sign) for axis, at, sign in arguments.cut]
    add_surfaces(collection, center, scale, arguments.surface,
                 surface_material(arguments.opacity, cuts))
    axes, camera = make_camera(scene, collection, place * scale, columns["radius"] * scale,
                               arguments.view, arguments.up)
    make_light(scene, collection, axes, arguments.background)
    print(f"{PACK['name']}: {len(place)} of {PACK['count']} spheres, colored by {arguments.color} "
          f"from {limits_text(arguments.color, colors)}; {scale:g} Blender units a {PACK['unit']}")
    if not bpy.app.background:
        show_in_windows(scene, camera, material, limits, arguments.color)
    if arguments.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(arguments.save))
    if arguments.render:
        scene.render.filepath = os.path.abspath(arguments.render)
        if not os.path.isdir(os.path.dirname(scene.render.filepath)):
            fail(f"--render {arguments.render}: there is no such folder; create it first")
        animated = bool(arguments.grow) and "#" in os.path.basename(arguments.render)
        bpy.ops.render.render(animation=animated, write_still=not animated, scene=scene.name)


main()
