"""A packed bone in Blender (3.4 and later): true spheres, the bone's surface, camera and light.

    blender -P NAME.py                                        in the window
    blender -b -P NAME.py -- --color region --render bone.png     a picture, without one
    blender -b -P NAME.py -- --grow 120 --render grow_####.png    120 pictures of the bone growing

Options follow a lone "--"; `-- --help` lists them. The files that PACK names lie beside this script
and move with it. In the window, the tab "vdb_pack" of the 3D view's sidebar (key N) colors the
spheres again.
"""

import argparse
import os
import sys
import zlib

import bpy
from mathutils import Matrix

try:
    import numpy as np
except ImportError:
    sys.exit("Blender's Python has no numpy; on Debian: apt-get install python3-numpy")

PACK = {}  # filled in by the writer
SPHERES = "vdb_pack spheres"
# Points take what is called radius for their own, whatever radius is set in Mesh to Points.
RENAMED = {"radius": "radius_" + PACK["unit"]}
# Colors are linear RGBA.
EVEN_RAMP = [  # dark blue to pale yellow through green, even in lightness
    (0.019, 0.033, 0.159, 1.0), (0.014, 0.147, 0.319, 1.0), (0.022, 0.342, 0.296, 1.0),
    (0.235, 0.571, 0.162, 1.0), (0.913, 0.768, 0.223, 1.0)]
REGION_RAMP = 2 * [(0.068, 0.188, 0.392, 1.0)] + 3 * [(0.871, 0.694, 0.352, 1.0)]  # 0 and 1


def fail(message):
    """Ends the run; in a window, where work may lie unsaved, only the script."""
    raise (SystemExit if bpy.app.background else RuntimeError)(f"{PACK['name']}: {message}")


def set_all(target, **values):
    for name, value in values.items():
        setattr(target, name, value)


def numbers(example, low=-1e9, high=1e9, kind=float, mark=","):
    """A type of options: as many numbers as the example has, parted by the mark."""
    def parse(text):
        values = [kind(word) for word in text.split(mark)]
        if len(values) != len(example.split(mark)) or not all(low <= v <= high for v in values):
            raise ValueError
        return values if mark in example else values[0]
    parse.__name__ = f"numbers (such as {example}, from {low:g} to {high:g})"
    return parse


def cut_plane(text):
    """`x=3` keeps what lies at x <= 3, `x>3` what lies above: (axis, position, sign)."""
    return "xyz".index(text[:1]), float(text[2:]), (1, 1, -1)["=<>".index(text[1:2])]


def parse_arguments(words):
    parser = argparse.ArgumentParser(
        f"blender -P {PACK['name']} --", description="Shows a pack of spheres in Blender. "
        "A value that starts with a minus needs an equals sign: --view=-1,0,0")
    add = parser.add_argument
    add("--color", default="radius", help="column to color by, such as region, depth or order")
    add("--range", type=numbers("0.5,2"), metavar="A,B", help="values of the first and last color")
    add("--render", metavar="FILE.png", help="writes a picture; with --grow and #### all frames")
    add("--grow", type=numbers("120", 1, 1e6, int), nargs="?", const=120, metavar="FRAMES",
        help="spheres appear in the order they were placed (in 120 frames)")
    cut_plane.__name__ = "plane (such as x=0, y<2.5 or z>100)"
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
    except Exception as problem:  # of files, of zip archives, of arrays
        fail(f"{path}: cannot be read: {problem}; keep it beside the script")
    place, radius = columns.pop("positions"), columns.pop("radii")
    if len(place) != PACK["count"] or zlib.crc32(place) != PACK["crc32"]:
        fail(f"{path}: is not the file that was written with this script; write both again with "
             "vdb_pack")
    columns = {k: v for k, v in columns.items() if v.shape == radius.shape and v.dtype.kind in "if"}
    return place, {"radius": radius, **columns}


def make_points(place, columns, scale):
    """A mesh of vertices alone, with a column each as attribute."""
    mesh = bpy.data.meshes.new(SPHERES)
    mesh.vertices.add(len(place))
    mesh.vertices.foreach_set("co", (place * scale).astype(np.float32).ravel())
    for name, values in (*columns.items(), ("drawn_radius", columns["radius"] * scale)):
        kind, held = ("INT", np.int32) if values.dtype.kind == "i" else ("FLOAT", np.float32)
        attribute = mesh.attributes.new(RENAMED.get(name, name), kind, "POINT")
        attribute.data.foreach_set("value", values.astype(held))
    mesh.update()
    return mesh


def node_adder(owner):
    """A function that adds a node to a new tree, material or world. Inputs are sockets to link or
    values to set, by place; None leaves one as it is. It returns the first output in use."""
    if bpy.app.version < (5, 0, 0) and hasattr(owner, "use_nodes"):
        owner.use_nodes = True  # later versions always use them
    tree = getattr(owner, "node_tree", owner)
    tree.nodes.clear()
    def add(kind, *inputs, **settings):
        node = tree.nodes.new(kind)
        set_all(node, location=(200 * len(tree.nodes), 0), **settings)
        for socket, value in zip(node.inputs, inputs):
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return next((socket for socket in node.outputs if socket.enabled), None)
    return add


def add_nodes(target, name, material, change=lambda add, shape: shape):
    """A modifier of nodes: the geometry, what `change` makes of it, the material."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        if hasattr(tree, "interface"):  # since 4.0
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        else:
            getattr(tree, way.lower() + "s").new("NodeSocketGeometry", "Geometry")
    add = node_adder(tree)
    shape = change(add, add("NodeGroupInput"))
    add("NodeGroupOutput", add("GeometryNodeSetMaterial", shape, None, material))
    target.modifiers.new(name, "NODES").node_group = tree
    target.data.materials.append(material)


def true_spheres(add, points, growth):
    """Points that render as spheres. `growth`: first and last order and frames, or None."""
    radius = add("GeometryNodeInputNamedAttribute", "drawn_radius", data_type="FLOAT")
    if growth:
        first, last, frames = growth
        # A sphere swells while the next hundredth is placed.
        swell = max(1.0, (last - first) / 100)
        rate = (last + swell - first) / max(1, frames - 1)
        frame = add("GeometryNodeInputSceneTime").node.outputs["Frame"]
        placed = add("ShaderNodeMath", frame, rate, first - rate, operation="MULTIPLY_ADD")
        order = add("GeometryNodeInputNamedAttribute", "order", data_type="FLOAT")
        age = add("ShaderNodeMath", placed, order, operation="SUBTRACT")
        part = add("ShaderNodeMath", age, swell, operation="DIVIDE", use_clamp=True)
        radius = add("ShaderNodeMath", radius, part, operation="MULTIPLY")
        unborn = add("FunctionNodeCompare", age, 0.0, operation="LESS_EQUAL", data_type="FLOAT")
        points = add("GeometryNodeDeleteGeometry", points, unborn, domain="POINT")
    return add("GeometryNodeMeshToPoints", points, None, None, radius)


def sphere_material():
    material = bpy.data.materials.new(SPHERES)
    add = node_adder(material)
    column = add("ShaderNodeAttribute", name="column", attribute_type="GEOMETRY")
    share = add("ShaderNodeMapRange", column.node.outputs["Fac"], name="range")
    ramp = add("ShaderNodeValToRGB", share, name="ramp")
    add("ShaderNodeOutputMaterial", add("ShaderNodeBsdfPrincipled", ramp))
    return material


def color_by(material, name, limits):
    nodes = material.node_tree.nodes
    nodes["column"].attribute_name = RENAMED.get(name, name)
    low, high = limits
    nodes["range"].inputs["From Min"].default_value = low
    nodes["range"].inputs["From Max"].default_value = high if high != low else low + 1
    elements = nodes["ramp"].color_ramp.elements
    for i, color in enumerate(REGION_RAMP if name == "region" else EVEN_RAMP):
        element = elements[i] if i < len(elements) else elements.new(0.25 * i)
        set_all(element, position=0.25 * i, color=color)


def surface_material(opacity, cuts):
    """Translucent, and clear beyond the cut planes (in Blender units)."""
    material = bpy.data.materials.new("vdb_pack surface")
    add = node_adder(material)
    place = add("ShaderNodeSeparateXYZ", add("ShaderNodeNewGeometry")).node.outputs
    for axis, at, sign in cuts:
        side = "LESS_THAN" if sign > 0 else "GREATER_THAN"
        inside = add("ShaderNodeMath", place[axis], at, operation=side)
        opacity = add("ShaderNodeMath", inside, opacity, operation="MULTIPLY")
    bone = add("ShaderNodeBsdfPrincipled", (0.768, 0.694, 0.565, 1.0))
    clear = add("ShaderNodeBsdfTransparent")
    add("ShaderNodeOutputMaterial", add("ShaderNodeMixShader", opacity, clear, bone))
    return material


def add_object(collection, name, data, is_hidden=False, axes=np.eye(3), position=(0, 0, 0)):
    added = bpy.data.objects.new(name, data)
    collection.objects.link(added)
    added.hide_render = is_hidden
    added.hide_set(is_hidden)
    added.matrix_world = Matrix.Translation(position) @ Matrix(axes.T.tolist()).to_4x4()
    return added


def add_surfaces(collection, center, scale, arguments):
    """The .vdb as a volume where the spheres are, and each of its level sets as a mesh."""
    cuts = [(axis, (at - center[axis]) * scale, sign) for axis, at, sign in arguments.cut]
    material, shown = surface_material(arguments.opacity, cuts), arguments.surface
    volume = bpy.data.volumes.new("vdb_pack volume")
    volume.filepath = beside(PACK["volume"]) if PACK["volume"] else ""
    if PACK["volume"] and not volume.grids.load():
        print(f"{volume.filepath}: cannot be read: {volume.grids.error_message}; no level sets")
    grids = {grid.name: grid for grid in volume.grids if grid.data_type == "FLOAT"}
    if shown and shown not in grids:
        fail(f"--surface {shown}: there is no such level set among: {', '.join(grids) or 'none'}")
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
    # Where it looks along `up`, another direction is above.
    sides = (np.cross(above, back) for above in (up / np.linalg.norm(up), (0, 1, 0), (1, 0, 0)))
    right = next(side for side in sides if np.linalg.norm(side) > 1e-6)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def make_camera(scene, collection, place, radius, arguments):
    """A camera that sees all spheres and little else; clipped close around them."""
    view, up, size = arguments.view, arguments.up, np.array(arguments.size)
    if view is None:
        # From the front and a little above; circles from straight above.
        upright = abs(up[1]) < max(abs(up[0]), abs(up[2]))
        right, above, front = basis((0, -1.0, 0) if upright else (0, 0, 1.0), up)
        view = (0, 0, 1.0) if PACK["dim"] == 2 else 0.45 * right + 0.3 * above + front
    axes = basis(view, up)
    camera = bpy.data.cameras.new("vdb_pack camera")
    camera.lens = 70
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
    set_all(sun, energy=3.0, angle=np.radians(12))  # soft shadows
    # Over the left shoulder of who looks.
    add_object(collection, "vdb_pack sun", sun, False, basis((-0.6, 0.8, 1.0) @ axes, axes[1]))
    # The soft fill comes from everywhere; the camera sees a plain color instead.
    scene.world = bpy.data.worlds.new("vdb_pack fill")
    add = node_adder(scene.world)
    fill = add("ShaderNodeBackground", (0.9, 0.95, 1.0, 1.0), 0.45)
    plain = 0.0 if background == "black" else 1.0
    seen = add("ShaderNodeBackground", (plain, plain, plain, 1.0), 1.0)
    ray = add("ShaderNodeLightPath").node.outputs["Is Camera Ray"]
    add("ShaderNodeOutputWorld", add("ShaderNodeMixShader", ray, fill, seen))


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
    def draw(panel, context):
        name = context.scene.vdb_pack_color
        panel.layout.prop(context.scene, "vdb_pack_color", text="Color")
        panel.layout.label(text=limits_text(name, limits[name]))
        panel.layout.label(text=f"{PACK['count']} spheres, lengths in {PACK['unit']}")
    bpy.types.Scene.vdb_pack_color = bpy.props.EnumProperty(
        name="Color", items=[(name, name, limits_text(name, limits[name])) for name in limits],
        update=lambda own, _: color_by(material, own.vdb_pack_color, limits[own.vdb_pack_color]))
    bpy.utils.register_class(type("VDBPACK_PT_pack", (bpy.types.Panel,), {
        "bl_label": "Spheres", "bl_category": "vdb_pack", "bl_space_type": "VIEW_3D",
        "bl_region_type": "UI", "draw": draw}))
    scene.vdb_pack_color = color


def column_limits(arguments, columns):
    """Least and greatest value of each column to color by."""
    limits = {name: (0.0, 1.0) if name == "region" else (float(np.nanmin(v)), float(np.nanmax(v)))
              for name, v in columns.items() if name != "id" and np.isfinite(v).any()}
    if arguments.color not in limits:
        fail(f"there is no column '{arguments.color}' to color by; use {', '.join(limits)}")
    if arguments.grow and "order" not in limits:
        fail("--grow: the pack has no column 'order'; pack it again")
    return limits


def main():
    arguments = parse_arguments(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    if PACK["count"] == 0:
        fail("the pack holds no spheres; nothing to show")
    place, columns = read_spheres()
    center = 0.5 * (place.min(axis=0) + place.max(axis=0))
    # Blender units in one unit of the file: a power of ten for an object of 1 to 10 units.
    extent = np.ptp(place, axis=0).max() + 2 * columns["radius"].max()
    scale = float(10.0 ** -np.floor(np.log10(extent)))
    kept = np.ones(len(place), bool) & np.all(
        [sign * (place[:, axis] - position) <= 0 for axis, position, sign in arguments.cut], axis=0)
    if not kept.any():
        fail("the cuts leave no sphere; move them, or turn them around (x<0, x>0)")
    place = place[kept] - center
    columns = {name: values[kept] for name, values in columns.items()}
    limits = column_limits(arguments, columns)
    colors = arguments.range or limits[arguments.color]
    scene = make_scene(arguments)
    collection = bpy.data.collections.new(scene.name)
    scene.collection.children.link(collection)
    material = sphere_material()
    color_by(material, arguments.color, colors)
    spheres = add_object(collection, SPHERES, make_points(place, columns, scale),
                         arguments.no_spheres)
    growth = (*limits["order"], arguments.grow) if arguments.grow else None
    add_nodes(spheres, SPHERES, material, lambda *points: true_spheres(*points, growth))
    spheres["unit_of_length"], spheres["blender_units_in_one_unit"] = PACK["unit"], scale
    spheres["center"], spheres["generator"] = center.tolist(), PACK["generator"]
    add_surfaces(collection, center, scale, arguments)
    axes, camera = make_camera(scene, collection, place * scale, columns["radius"] * scale, arguments)
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
