"""Materials and modifiers of blender_scene.py, into which CMake inserts what follows the imports."""

import bpy

# Colors are linear RGBA.
EVEN_RAMP = [  # dark blue to pale yellow through green, even in lightness
    (0.019, 0.033, 0.159, 1.0), (0.014, 0.147, 0.319, 1.0), (0.022, 0.342, 0.296, 1.0),
    (0.235, 0.571, 0.162, 1.0), (0.913, 0.768, 0.223, 1.0)]
REGION_RAMP = [(0.068, 0.188, 0.392, 1.0), (0.871, 0.694, 0.352, 1.0)]  # cortical, trabecular
SURFACE_COLOR = (0.768, 0.694, 0.565, 1.0)


class Nodes:
    """Adds nodes to a tree, from left to right, and links them."""

    def __init__(self, tree):
        self.tree = tree
        tree.nodes.clear()

    def add(self, kind, *inputs, **settings):
        """Inputs are sockets to link or values to set, by place; None leaves one as it is.
        @return the first output in use"""
        node = self.tree.nodes.new(kind)
        set_all(node, location=(200 * len(self.tree.nodes), 0), **settings)
        for socket, value in zip(node.inputs, inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return next((socket for socket in node.outputs if socket.enabled), None)

    def math(self, operation, *values, **settings):
        return self.add("ShaderNodeMath", *values, operation=operation, **settings)


def shader_nodes(owner):
    """The nodes of a new material or world."""
    if bpy.app.version < (5, 0, 0):
        owner.use_nodes = True  # later versions always use them
    return Nodes(owner.node_tree)


def principled(nodes, color, roughness):
    shader = nodes.add("ShaderNodeBsdfPrincipled", color)
    shader.node.inputs["Roughness"].default_value = roughness
    return shader


def add_nodes(target, name, material, change=lambda nodes, shape: shape):
    """A modifier of nodes: the geometry, what `change` makes of it, the material."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        if hasattr(tree, "interface"):  # since 4.0
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        else:
            getattr(tree, way.lower() + "s").new("NodeSocketGeometry", "Geometry")
    nodes = Nodes(tree)
    shape = change(nodes, nodes.add("NodeGroupInput"))
    nodes.add("NodeGroupOutput", nodes.add("GeometryNodeSetMaterial", shape, None, material))
    target.modifiers.new(name, "NODES").node_group = tree
    target.data.materials.append(material)


def true_spheres(nodes, points, growth):
    """Points that render as spheres. `growth`: first and last order and frames, or None."""
    def attribute(name):
        return nodes.add("GeometryNodeInputNamedAttribute", name, data_type="FLOAT")

    radius = attribute("drawn_radius")
    if growth:
        first, last, frames = growth
        # A sphere swells while the next hundredth is placed.
        swell = max(1.0, (last - first) / 100)
        rate = (last + swell - first) / max(1, frames - 1)
        frame = nodes.add("GeometryNodeInputSceneTime").node.outputs["Frame"]
        placed = nodes.math("MULTIPLY_ADD", frame, rate, first - rate)
        age = nodes.math("SUBTRACT", placed, attribute("order"))
        radius = nodes.math("MULTIPLY", radius, nodes.math("DIVIDE", age, swell, use_clamp=True))
        unborn = nodes.add("FunctionNodeCompare", age, 0.0, operation="LESS_EQUAL",
                           data_type="FLOAT")
        points = nodes.add("GeometryNodeDeleteGeometry", points, unborn, domain="POINT")
    return nodes.add("GeometryNodeMeshToPoints", points, None, None, radius)


def sphere_material():
    material = bpy.data.materials.new(SPHERES)
    nodes = shader_nodes(material)
    column = nodes.add("ShaderNodeAttribute", name="column", attribute_type="GEOMETRY")
    share = nodes.add("ShaderNodeMapRange", column.node.outputs["Fac"], name="range")
    ramp = nodes.add("ShaderNodeValToRGB", share, name="ramp")
    nodes.add("ShaderNodeOutputMaterial", principled(nodes, ramp, 0.45))
    return material


def color_by(material, name, limits):
    nodes = material.node_tree.nodes
    nodes["column"].attribute_name = attribute_name(name)
    low, high = limits
    nodes["range"].inputs["From Min"].default_value = low
    nodes["range"].inputs["From Max"].default_value = high if high > low else low + 1
    elements = nodes["ramp"].color_ramp.elements
    colors = REGION_RAMP if name == "region" else EVEN_RAMP
    while len(elements) > 1:
        elements.remove(elements[0])
    elements[0].position, elements[0].color = 0.0, colors[0]
    for i, color in enumerate(colors[1:], 1):
        elements.new(i / (len(colors) - 1)).color = color


def surface_material(opacity, cuts):
    """Translucent, and clear beyond the cut planes (in Blender units)."""
    material = bpy.data.materials.new("vdb_pack surface")
    nodes = shader_nodes(material)
    place = nodes.add("ShaderNodeSeparateXYZ", nodes.add("ShaderNodeNewGeometry")).node.outputs
    for axis, at, sign in cuts:
        inside = nodes.math("LESS_THAN" if sign > 0 else "GREATER_THAN", place[axis], at)
        opacity = nodes.math("MULTIPLY", inside, opacity)
    clear = nodes.add("ShaderNodeBsdfTransparent")
    nodes.add("ShaderNodeOutputMaterial", nodes.add("ShaderNodeMixShader", opacity, clear,
                                                    principled(nodes, SURFACE_COLOR, 0.6)))
    return material
