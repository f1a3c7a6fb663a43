"""A packed bone in Blender (3.4 and later): true spheres, the bone's surface, camera and light.

    blender -P NAME.py                                        in the window
    blender -b -P NAME.py -- --color region --render bone.png     a picture, without one
    blender -b -P NAME.py -- --grow 120 --render grow_####.png    120 pictures of the bone growing

Options follow a lone "--" (`-- --help` lists them); their defaults are the constants below. The
files that PACK names lie beside this script and move with it. In the window, the tab "vdb_pack" of
the 3D view's sidebar (key N) colors the spheres again. It is one long file because it is written
beside each pack and runs without anything else of vdb_pack.
"""

import argparse
import math
import os
import sys
import zlib

import bpy

try:
    import numpy as np
except ImportError:
    sys.exit("Blender's Python has no numpy, which reads the spheres; on Debian: "
             "apt-get install python3-numpy")

# ---- What to show -------------------------------------------------------------------------------

COLOR = "radius"  # radius, region, depth, order, contacts, or another column of the file
SURFACE = ""      # show this level set too: surface, solid or voids; "" is none
OPACITY = 0.25    # of that surface
VIEW = ""         # from where the camera looks, as "x,y,z"; "" is a view from the front
UP = "0,0,1"      # what is up in the picture
CUT = []          # planes such as "x=0" (keeps x <= 0) or "z>100", in the unit of the file
SIZE = "1200x1200"
SAMPLES = 64      # of Cycles, a pixel
BACKGROUND = "white"  # white, black or transparent

# ---- What the files hold; written by vdb_pack ---------------------------------------------------

PACK = {}  # filled in by the writer

# -------------------------------------------------------------------------------------------------

RAMPS = {
    # Dark blue to pale yellow through green, even in lightness, fit for color-blind readers.
    "even": ["#26336F", "#1F6B99", "#299E94", "#85C770", "#F5E382"],
    # Cortical bone like ivory, trabecular like brick.
    "region": ["#4A78A8", "#F0D9A0"],
}
SURFACE_COLOR = "#E3D9C6"
LENGTHS = ("radius", "depth")
SPHERES = "vdb_pack spheres"
NOT_SHOWN = ("x", "y", "z", "id")


def fail(message):
    """Ends the run; in a window, where work may lie unsaved, only the script."""
    message = f"{PACK.get('name', 'blender_scene.py')}: {message}"
    if bpy.app.background:
        sys.exit(message)
    raise RuntimeError(message)


# ---- Options ------------------------------------------------------------------------------------


def vector(text):
    try:
        values = [float(t) for t in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 3 or not all(map(math.isfinite, values)) or not any(values):
        raise argparse.ArgumentTypeError(f"'{text}': three numbers such as 0.3,-1,0.2 expected")
    return np.array(values)


def cut_plane(text):
    """`x=3` keeps what lies at x <= 3, `x>3` what lies above: (axis, position, sign)."""
    for sign, mark in ((1, "="), (1, "<"), (-1, ">")):
        axis, found, position = text.partition(mark)
        if found and axis in ("x", "y", "z"):
            try:
                position = float(position)
            except ValueError:
                break
            if math.isfinite(position):
                return "xyz".index(axis), position, sign
    raise argparse.ArgumentTypeError(f"'{text}': a plane such as x=0, y<2.5 or z>100 expected")


def image_size(text):
    parts = text.split("x")
    if len(parts) != 2 or not all(p.isdigit() and 16 <= int(p) <= 16384 for p in parts):
        raise argparse.ArgumentTypeError(f"'{text}': a size such as 1600x1200 expected")
    return int(parts[0]), int(parts[1])


def positive(text):
    if not text.isdigit() or not 1 <= int(text) <= 1000000:
        raise argparse.ArgumentTypeError(f"'{text}': a whole number from 1 to 1000000 expected")
    return int(text)


def share(text):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"'{text}': a number from 0 to 1 expected")
    return value


def parse_arguments(words):
    parser = argparse.ArgumentParser(
        prog=f"blender -P {PACK['name']} --", description="Shows a pack of spheres in Blender.",
        epilog="A value that starts with a minus needs an equals sign: --view=-1,0,0")
    add = parser.add_argument
    add("--color", default=COLOR, help=f"column to color by (default {COLOR})")
    add("--range", metavar="A,B", help="values of the first and the last color (default: all)")
    add("--render", metavar="FILE.png", help="renders and writes a picture; with --grow, all "
        "frames where the name holds ####, else the last")
    add("--grow", type=positive, nargs="?", const=120, metavar="FRAMES",
        help="key frames: spheres appear in the order they were placed (default 120 frames)")
    add("--cut", type=cut_plane, action="append", metavar="PLANE",
        help="x=V keeps x <= V, x>V the rest, in the unit of the file; may be repeated")
    add("--surface", default=SURFACE, metavar="GRID", help="shows a level set as well")
    add("--opacity", type=share, default=OPACITY, help="of that surface, 0 to 1")
    add("--no-spheres", action="store_true", help="leaves the spheres out of the picture")
    add("--view", type=vector, default=VIEW or None, metavar="X,Y,Z", help="from where to look")
    add("--up", type=vector, default=UP, metavar="X,Y,Z", help=f"up in the picture (default {UP})")
    add("--size", type=image_size, default=SIZE, metavar="WxH", help="of the picture, pixels")
    add("--samples", type=positive, default=SAMPLES, help="rays a pixel")
    add("--background", choices=("white", "black", "transparent"), default=BACKGROUND)
    add("--save", metavar="FILE.blend", help="writes the scene for later")
    arguments = parser.parse_args(words)
    if arguments.cut is None:
        try:
            arguments.cut = [cut_plane(text) for text in CUT]
        except argparse.ArgumentTypeError as problem:
            parser.error(f"CUT: {problem}")
    return arguments


# ---- The spheres --------------------------------------------------------------------------------


def folder():
    """Where this script lies: as a file, or as a text opened in Blender's editor."""
    places = [globals().get("__file__", "")]
    text = getattr(getattr(bpy.context, "space_data", None), "text", None)
    if text is not None:
        places.append(bpy.path.abspath(text.filepath))
    for place in places:
        if place and os.path.isfile(place):
            return os.path.dirname(os.path.abspath(place))
    fail("cannot tell where this script lies; save it, or run blender -P FILE")


def read_spheres():
    """All spheres as a structured array; positions relative to PACK["center"]."""
    path = os.path.join(folder(), PACK["points"])
    try:
        data = np.load(path, mmap_mode=None, allow_pickle=False)
    except (OSError, ValueError) as problem:
        fail(f"{path}: cannot be read: {problem}; keep it beside the script")
    if len(data) != PACK["count"] or zlib.crc32(data.view(np.uint8)) != PACK["crc32"]:
        fail(f"{path}: is not the file that was written with this script; write both again with "
             "vdb_pack")
    return data


def kept(data, cuts):
    """What the cut planes leave of the spheres, by their centers."""
    stays = np.ones(len(data), bool)
    for axis, position, sign in cuts:
        stays &= sign * (data["xyz"[axis]] - (position - PACK["center"][axis])) <= 0
    if not stays.any():
        fail("the cuts leave no sphere; move them, or turn them around (x<0, x>0)")
    return data[stays]


def choose_scale(data):
    """Blender units in one unit of the file: a power of ten for an object of 1 to 10 units."""
    extent = max(np.ptp(data[axis]) for axis in "xyz") + 2 * float(data["radius"].max())
    return 10.0 ** -math.floor(math.log10(extent))


def attribute_name(column):
    """Points take what is called radius for their own, whatever radius is set in Mesh to Points."""
    return "radius_" + PACK["unit"] if column == "radius" else column


def make_points(data, scale):
    """A mesh of vertices alone, with a column each as attribute."""
    mesh = bpy.data.meshes.new(SPHERES)
    mesh.vertices.add(len(data))
    place = np.stack([data[axis] for axis in "xyz"], axis=1).astype(np.float32) * np.float32(scale)
    mesh.vertices.foreach_set("co", place.ravel())
    for name in data.dtype.names:
        if name in ("x", "y", "z"):
            continue
        whole = data.dtype[name].kind in "iu"
        attribute = mesh.attributes.new(attribute_name(name), "INT" if whole else "FLOAT",
                                        "POINT")
        values = np.ascontiguousarray(data[name], np.int32 if whole else np.float32)
        attribute.data.foreach_set("value", values)
    drawn = mesh.attributes.new("drawn_radius", "FLOAT", "POINT")
    drawn.data.foreach_set("value", data["radius"].astype(np.float32) * np.float32(scale))
    mesh.update()
    return mesh


def group_sockets(tree):
    """Geometry in, geometry out: 4.0 has another way to say so."""
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")


class Nodes:
    """Adds nodes to a tree, from left to right, and links them."""

    def __init__(self, tree):
        self.tree = tree
        tree.nodes.clear()

    def add(self, kind, *inputs, **settings):
        """Inputs are sockets to link or values to set, by place; None leaves one as it is."""
        node = self.tree.nodes.new(kind)
        node.location = (200 * len(self.tree.nodes), 0)
        for key, value in settings.items():
            setattr(node, key, value)
        for socket, value in zip(node.inputs, inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return node

    def attribute(self, name):
        node = self.add("GeometryNodeInputNamedAttribute", name, data_type="FLOAT")
        return next(s for s in node.outputs if s.enabled and s.name == "Attribute")

    def math(self, operation, a, b):
        return self.add("ShaderNodeMath", a, b, operation=operation).outputs[0]


def sphere_nodes(material, grow):
    """Points that render as true spheres. `grow`: first and last order and frames, or None."""
    tree = bpy.data.node_groups.new(SPHERES, "GeometryNodeTree")
    group_sockets(tree)
    nodes = Nodes(tree)
    points = nodes.add("NodeGroupInput").outputs[0]
    radius = nodes.attribute("drawn_radius")
    if grow:
        first, last, frames = grow
        placed = nodes.add("ShaderNodeValue", label="placed up to", name="placed")
        # A sphere swells while the next hundredth is placed.
        swell = max(1.0, (last - first) / 100)
        edit = bpy.context.preferences.edit
        usual, edit.keyframe_new_interpolation_type = edit.keyframe_new_interpolation_type, "LINEAR"
        for frame, value in ((1, first), (frames, last + swell)):
            placed.outputs[0].default_value = value
            placed.outputs[0].keyframe_insert("default_value", frame=frame)
        edit.keyframe_new_interpolation_type = usual
        age = nodes.math("SUBTRACT", placed.outputs[0], nodes.attribute("order"))
        size = nodes.add("ShaderNodeMath", age, swell, operation="DIVIDE", use_clamp=True)
        radius = nodes.math("MULTIPLY", radius, size.outputs[0])
        unborn = nodes.add("FunctionNodeCompare", age, 0.0, operation="LESS_EQUAL",
                           data_type="FLOAT").outputs[0]
        points = nodes.add("GeometryNodeDeleteGeometry", points, unborn, domain="POINT").outputs[0]
    points = nodes.add("GeometryNodeMeshToPoints", points, None, None, radius).outputs[0]
    points = nodes.add("GeometryNodeSetMaterial", points, None, material).outputs[0]
    nodes.add("NodeGroupOutput", points)
    return tree


# ---- Colors -------------------------------------------------------------------------------------


def linear(color):
    """#RRGGBB as the linear RGBA that shaders count in."""
    channels = [int(color[i:i + 2], 16) / 255 for i in (1, 3, 5)]
    return [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels] + [1.0]


def principled(nodes, color, roughness):
    shader = nodes.add("ShaderNodeBsdfPrincipled", color)
    shader.inputs["Roughness"].default_value = roughness
    for name in ("Specular", "Specular IOR Level"):  # renamed in 4.0
        if name in shader.inputs:
            shader.inputs[name].default_value = 0.3
    return shader.outputs[0]


def sphere_material():
    material = bpy.data.materials.new(SPHERES)
    material.use_nodes = True
    nodes = Nodes(material.node_tree)
    column = nodes.add("ShaderNodeAttribute", name="column", attribute_type="GEOMETRY")
    share_of = nodes.add("ShaderNodeMapRange", column.outputs["Fac"], name="range")
    ramp = nodes.add("ShaderNodeValToRGB", share_of.outputs[0], name="ramp")
    nodes.add("ShaderNodeOutputMaterial", principled(nodes, ramp.outputs[0], 0.45))
    return material


def color_by(material, name, limits):
    nodes = material.node_tree.nodes
    nodes["column"].attribute_name = attribute_name(name)
    low, high = limits
    nodes["range"].inputs["From Min"].default_value = low
    nodes["range"].inputs["From Max"].default_value = high if high > low else low + 1
    ramp = nodes["ramp"].color_ramp
    colors = RAMPS.get(name, RAMPS["even"])
    ramp.interpolation = "LINEAR"
    while len(ramp.elements) > 1:
        ramp.elements.remove(ramp.elements[0])
    ramp.elements[0].position = 0.0
    ramp.elements[0].color = linear(colors[0])
    for i, color in enumerate(colors[1:], 1):
        ramp.elements.new(i / (len(colors) - 1)).color = linear(color)


def column_limits(data):
    """Least and largest value of each column to color by."""
    limits = {}
    for name in data.dtype.names:
        values = data[name][np.isfinite(data[name])]
        if name not in NOT_SHOWN and len(values) > 0:
            limits[name] = (float(values.min()), float(values.max()))
    if "region" in limits:
        limits["region"] = (0.0, 1.0)
    return limits


def surface_material(opacity, cuts, scale):
    """Translucent, and clear beyond the cut planes."""
    material = bpy.data.materials.new("vdb_pack surface")
    material.use_nodes = True
    if hasattr(material, "blend_method"):  # of EEVEE, until 4.2
        material.blend_method = "BLEND" if opacity < 1 else "CLIP"
    nodes = Nodes(material.node_tree)
    amount = opacity
    if cuts:
        position = nodes.add("ShaderNodeNewGeometry").outputs["Position"]
        place = nodes.add("ShaderNodeSeparateXYZ", position).outputs
        for axis, where, sign in cuts:
            at = (where - PACK["center"][axis]) * scale
            inside = nodes.math("LESS_THAN" if sign > 0 else "GREATER_THAN", place[axis], at)
            amount = nodes.math("MULTIPLY", inside, amount)
    clear = nodes.add("ShaderNodeBsdfTransparent").outputs[0]
    solid = principled(nodes, linear(SURFACE_COLOR), 0.6)
    nodes.add("ShaderNodeOutputMaterial",
              nodes.add("ShaderNodeMixShader", amount, clear, solid).outputs[0])
    return material


# ---- The level sets -----------------------------------------------------------------------------


def make_volume(collection, scale):
    """The .vdb as a volume object, where the spheres are; hidden: a level set is no fog."""
    path = os.path.normpath(os.path.join(folder(), PACK["volume"]))
    volume = bpy.data.volumes.new("vdb_pack volume")
    volume.filepath = path
    if not os.path.isfile(path) or not volume.grids.load():
        why = volume.grids.error_message or "there is no such file"
        print(f"{path}: cannot be read: {why}; showing the spheres alone")
        return None
    holder = bpy.data.objects.new("vdb_pack volume", volume)
    holder.scale = (scale,) * 3
    holder.location = [-scale * c for c in PACK["center"]]
    collection.objects.link(holder)
    holder.hide_render = True
    holder.hide_set(True)
    return holder


def make_surface(collection, volume, grid, material):
    """A level set as a mesh: Volume to Mesh at distance 0."""
    skin = bpy.data.objects.new(f"vdb_pack {grid.name}", bpy.data.meshes.new(grid.name))
    collection.objects.link(skin)
    mesher = skin.modifiers.new("Volume to Mesh", "VOLUME_TO_MESH")
    mesher.object = volume
    mesher.grid_name = grid.name
    mesher.threshold = 0.0
    mesher.resolution_mode = "GRID"
    mesher.use_smooth_shade = True
    # Blender lays voxels' corners where the file has their centers: half a voxel too far.
    voxel = grid.matrix_object.to_scale()
    skin.location = [-0.5 * volume.scale[0] * edge for edge in voxel]
    skin.data.materials.append(material)
    # Meshes made by a modifier take the material from a node.
    tree = bpy.data.node_groups.new(f"vdb_pack {grid.name}", "GeometryNodeTree")
    group_sockets(tree)
    nodes = Nodes(tree)
    shape = nodes.add("NodeGroupInput").outputs[0]
    shape = nodes.add("GeometryNodeSetMaterial", shape, None, material).outputs[0]
    nodes.add("NodeGroupOutput", shape)
    skin.modifiers.new("Material", "NODES").node_group = tree
    return skin


# ---- Camera and light ---------------------------------------------------------------------------


def basis(ahead, up):
    """Right, up and backward of a camera that looks from `ahead` at the origin."""
    back = ahead / np.linalg.norm(ahead)
    right = np.cross(up, back)
    for other in ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
        if np.linalg.norm(right) < 1e-6 * np.linalg.norm(up):  # looking along `up`
            right = np.cross(other, back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def pose(target, axes, position):
    """Puts an object at `position`, its axes along `axes`."""
    from mathutils import Matrix
    matrix = Matrix([list(row) for row in axes]).transposed().to_4x4()
    matrix.translation = position
    target.matrix_world = matrix


def make_camera(scene, collection, data, scale, view, up):
    """A camera that sees all spheres and little else; clipped close around them."""
    flat = PACK["dim"] == 2
    if view is None:
        # From the front and a little above; circles from straight above.
        upright = abs(up[1]) < max(abs(up[0]), abs(up[2]))
        right, above, front = basis(np.array((0, -1.0, 0) if upright else (0, 0, 1.0)), up)
        view = np.array((0, 0, 1.0)) if flat else 0.45 * right + 0.3 * above + front
    axes = basis(view, up)
    camera = bpy.data.cameras.new("vdb_pack camera")
    camera.lens = 70
    width, height = scene.render.resolution_x, scene.render.resolution_y
    tangent = 0.5 * camera.sensor_width / camera.lens / max(width, height) * np.array(
        (width, height))
    radius = data["radius"].astype(float) * scale
    place = np.stack([data[axis].astype(float) for axis in "xyz"], axis=1) * scale @ axes.T
    low = (place - radius[:, None]).min(axis=0)
    high = (place + radius[:, None]).max(axis=0)
    middle = 0.5 * (low + high)
    place -= middle
    # In each direction the farthest sphere out decides, the sooner the nearer it is.
    distance = max(
        float(np.max((np.abs(place[:, k]) + 1.05 * radius) / tangent[k] + place[:, 2]))
        for k in (0, 1)) * 1.04
    deep = 0.5 * (high[2] - low[2])
    camera.clip_start = max(0.5 * (distance - deep), 1e-3 * distance)
    camera.clip_end = 4 * (distance + deep)
    holder = bpy.data.objects.new("vdb_pack camera", camera)
    collection.objects.link(holder)
    pose(holder, axes, (middle + (0, 0, distance)) @ axes)
    scene.camera = holder
    return axes, camera


def make_light(scene, collection, axes, background):
    sun = bpy.data.lights.new("vdb_pack sun", "SUN")
    sun.energy = 3.0
    sun.angle = math.radians(12)  # soft shadows
    holder = bpy.data.objects.new("vdb_pack sun", sun)
    collection.objects.link(holder)
    # Over the left shoulder of who looks.
    pose(holder, basis(np.array((-0.6, 0.8, 1.0)) @ axes, axes[1]), (0, 0, 0))
    # The soft fill comes from everywhere; the camera sees a plain color instead.
    world = bpy.data.worlds.new("vdb_pack fill")
    world.use_nodes = True
    nodes = Nodes(world.node_tree)
    fill = nodes.add("ShaderNodeBackground", (0.9, 0.95, 1.0, 1.0), 0.45).outputs[0]
    plain = (0.0,) * 3 if background == "black" else (1.0,) * 3
    seen = nodes.add("ShaderNodeBackground", (*plain, 1.0), 1.0).outputs[0]
    ray = nodes.add("ShaderNodeLightPath").outputs["Is Camera Ray"]
    nodes.add("ShaderNodeOutputWorld", nodes.add("ShaderNodeMixShader", ray, fill, seen).outputs[0])
    scene.world = world


def make_scene(arguments):
    scene = bpy.data.scenes.new(os.path.splitext(PACK["name"])[0])
    scene.render.engine = "CYCLES"
    scene.cycles.samples = arguments.samples
    scene.cycles.preview_samples = 16
    scene.cycles.max_bounces = 4
    scene.cycles.transparent_max_bounces = 64
    try:
        import _cycles
        denoises = bool(_cycles.with_openimagedenoise)
    except (ImportError, AttributeError):
        denoises = False
    # A build without a denoiser (Debian's) stops a render that asks for one.
    scene.cycles.use_denoising = denoises
    scene.cycles.use_preview_denoising = denoises
    scene.render.resolution_x, scene.render.resolution_y = arguments.size
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = arguments.background == "transparent"
    scene.render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"  # colors as they are named
    return scene


def show_in_windows(scene, camera):
    """Every 3D view looks through the camera, with clipping that suits the object."""
    for window in bpy.context.window_manager.windows:
        window.scene = scene
        for area in window.screen.areas:
            if area.type != "VIEW_3D":
                continue
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    space.clip_start = camera.clip_start / 20
                    space.clip_end = camera.clip_end * 5
                    # Solid shows the spheres in gray, Material Preview not at all (3.4).
                    space.shading.type = "RENDERED"
                    space.region_3d.view_perspective = "CAMERA"


# ---- The sidebar --------------------------------------------------------------------------------


def add_sidebar(scene, material, limits, color):
    """A tab with the columns to color by."""
    items = [(name, name, f"{low:.4g} to {high:.4g}") for name, (low, high) in limits.items()]

    def changed(owner, _context):
        color_by(material, owner.vdb_pack_color, limits[owner.vdb_pack_color])

    class VDBPACK_PT_pack(bpy.types.Panel):
        bl_label = "Spheres"
        bl_category = "vdb_pack"
        bl_space_type = "VIEW_3D"
        bl_region_type = "UI"

        def draw(self, context):
            self.layout.prop(context.scene, "vdb_pack_color", text="Color")
            name = context.scene.vdb_pack_color
            unit = " " + PACK["unit"] if name in LENGTHS else ""
            low, high = limits[name]
            self.layout.label(text=f"{low:.4g} to {high:.4g}{unit}")
            self.layout.label(text=f"{PACK['count']} spheres, lengths in {PACK['unit']}")

    former = getattr(bpy.types, "VDBPACK_PT_pack", None)
    if former is not None:
        bpy.utils.unregister_class(former)
    bpy.types.Scene.vdb_pack_color = bpy.props.EnumProperty(
        name="Color", items=items, update=changed)
    bpy.utils.register_class(VDBPACK_PT_pack)
    scene.vdb_pack_color = color


# ---- All together -------------------------------------------------------------------------------


def chosen_range(arguments, limits):
    if arguments.color not in limits:
        fail(f"there is no column '{arguments.color}' to color by; use {', '.join(limits)}")
    if arguments.range is None:
        return limits[arguments.color]
    try:
        low, high = (float(t) for t in arguments.range.split(","))
    except ValueError:
        low = high = math.nan
    if not low < high:
        fail(f"--range '{arguments.range}': two numbers such as 0.5,2 expected, the lesser first")
    return low, high


def render(scene, arguments):
    path = os.path.abspath(arguments.render)
    if not os.path.isdir(os.path.dirname(path)):
        fail(f"--render {arguments.render}: there is no such folder; create it first")
    animated = arguments.grow and "#" in os.path.basename(path)
    scene.render.filepath = path
    bpy.ops.render.render(animation=bool(animated), write_still=not animated, scene=scene.name)


def main():
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    arguments = parse_arguments(words)
    if PACK["count"] == 0:
        fail("the pack holds no spheres; nothing to show")
    data = read_spheres()
    scale = choose_scale(data)
    data = kept(data, arguments.cut)
    limits = column_limits(data)
    colors = chosen_range(arguments, limits)

    scene = make_scene(arguments)
    for window in bpy.context.window_manager.windows:
        window.scene = scene
    collection = bpy.data.collections.new(scene.name)
    scene.collection.children.link(collection)

    material = sphere_material()
    grow = None
    if arguments.grow:
        if "order" not in limits:
            fail("--grow: the pack has no column 'order'; pack it again")
        grow = (*limits["order"], arguments.grow)
        scene.frame_start, scene.frame_end = 1, arguments.grow
        scene.frame_current = arguments.grow  # all of it, until played
    spheres = bpy.data.objects.new(SPHERES, make_points(data, scale))
    spheres.modifiers.new("Spheres", "NODES").node_group = sphere_nodes(material, grow)
    spheres.data.materials.append(material)
    collection.objects.link(spheres)
    if arguments.no_spheres:
        spheres.hide_render = True
        spheres.hide_set(True)
    spheres["unit_of_length"] = PACK["unit"]
    spheres["blender_units_in_one_unit"] = scale
    spheres["center"] = PACK["center"]
    spheres["generator"] = PACK["generator"]
    color_by(material, arguments.color, colors)

    volume = make_volume(collection, scale) if PACK["volume"] else None
    grids = [g for g in volume.data.grids if g.data_type == "FLOAT"] if volume else []
    if arguments.surface and arguments.surface not in [g.name for g in grids]:
        fail(f"--surface {arguments.surface}: there is no such level set; "
             f"use {', '.join(g.name for g in grids) or 'none: there are no level sets'}")
    skin = surface_material(arguments.opacity, arguments.cut, scale)
    for grid in grids:
        shown = make_surface(collection, volume, grid, skin)
        shown.hide_render = grid.name != arguments.surface
        shown.hide_set(shown.hide_render)

    axes, camera = make_camera(scene, collection, data, scale, arguments.view, arguments.up)
    make_light(scene, collection, axes, arguments.background)
    unit = " " + PACK["unit"] if arguments.color in LENGTHS else ""
    print(f"{PACK['name']}: {len(data)} of {PACK['count']} spheres, colored by {arguments.color} "
          f"from {colors[0]:.4g} to {colors[1]:.4g}{unit}; {scale:g} Blender units a "
          f"{PACK['unit']}")
    if not bpy.app.background:
        show_in_windows(scene, camera)
        add_sidebar(scene, material, limits, arguments.color)
    if arguments.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(arguments.save))
    if arguments.render:
        render(scene, arguments)


main()
