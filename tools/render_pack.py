#!/usr/bin/python3
"""Draws a pack of spheres, off screen, to a PNG file.

    tools/render_pack.py out/femur.csv -o femur.png
    tools/render_pack.py out/femur.vtp --mesh assets/meshes/femur.ply --cut y=0 --color depth \\
        --view 0.3,-1,0.2 -o femur.png

Reads .csv (columns by name: x, y, z, radius and whatever else is there) and .vtp (point data
`radius`). Needs Debian's python3-vtk9, and xvfb where there is no display. Spheres are drawn as
ball impostors with true depth: a million of them take half a minute in all, without a graphics
card. A value that starts with a minus needs an equals sign: --view=-1,0,0.
"""

import argparse
import array
import csv
import math
import os
import shutil
import struct
import sys
import zlib

# Dark blue to pale yellow through green, even in lightness, fit for color-blind readers.
COLORS = [
    (0.15, 0.20, 0.45),
    (0.12, 0.42, 0.60),
    (0.16, 0.62, 0.58),
    (0.52, 0.78, 0.44),
    (0.96, 0.89, 0.51),
]
# No bands show on spheres of few pixels.
PALETTE_SIZE = 256
# Pixels drawn for each one written, along an edge.
SUPERSAMPLING = 2


class Problem(Exception):
    """Something the caller can mend."""


def vector(text):
    """Three numbers, comma separated, not all zero."""
    try:
        values = tuple(float(t) for t in text.split(","))
    except ValueError:
        values = ()
    if len(values) != 3 or not all(map(math.isfinite, values)) or not any(values):
        raise argparse.ArgumentTypeError(f"'{text}': three numbers such as 0.3,-1,0.2 expected")
    return values


def cut_plane(text):
    """`x=3` keeps what lies at x <= 3, `x>3` what lies above: (axis, position, sign)."""
    for sign, mark in ((1, "="), (1, "<"), (-1, ">")):
        axis, found, position = text.partition(mark)
        if found and axis in ("x", "y", "z"):
            try:
                return "xyz".index(axis), float(position), sign
            except ValueError:
                break
    raise argparse.ArgumentTypeError(f"'{text}': a plane such as x=0, y<2.5 or z>100 expected")


def image_size(text):
    """`1600x1200` as two whole numbers."""
    parts = text.split("x")
    if len(parts) != 2 or not all(p.isdigit() and 16 <= int(p) <= 8192 for p in parts):
        raise argparse.ArgumentTypeError(f"'{text}': a size such as 1600x1200 expected")
    return int(parts[0]), int(parts[1])


def parse_arguments():
    parser = argparse.ArgumentParser(
        description="Draws a pack of spheres (.csv or .vtp) to a PNG file, off screen."
    )
    parser.add_argument("pack", help=".csv or .vtp")
    parser.add_argument("-o", "--output", required=True, help="PNG file to write")
    parser.add_argument("--mesh", help="surface to draw translucent (.ply, .stl, .obj)")
    parser.add_argument("--opacity", type=float, default=0.2, help="of the mesh [0.2]")
    parser.add_argument("--color", default="radius", help="column to color by [radius]")
    parser.add_argument("--range", help="LOW,HIGH of the colors [of the column]")
    parser.add_argument(
        "--cut",
        action="append",
        type=cut_plane,
        default=[],
        help="x=3 or x<3 drops spheres centered at x > 3, x>3 the others; may be repeated",
    )
    parser.add_argument(
        "--cut-mesh-only", action="store_true", help="cut the mesh, leave the spheres whole"
    )
    parser.add_argument(
        "--view",
        type=vector,
        default=(0.5, -1.0, 0.35),
        metavar="X,Y,Z",
        help="from the pack to the camera, as in --view=-1,0,0.2 [0.5,-1,0.35]",
    )
    parser.add_argument(
        "--up", type=vector, default=(0.0, 0.0, 1.0), metavar="X,Y,Z", help="[0,0,1]"
    )
    parser.add_argument("--zoom", type=float, default=1.0, help="[1: all is in the picture]")
    parser.add_argument("--size", type=image_size, default=(1600, 1200), help="[1600x1200]")
    parser.add_argument("--background", default="white", choices=("white", "black"))
    parser.add_argument("--no-bar", action="store_true", help="leave out the scale of colors")
    parser.add_argument("--label", help="name of the colors [column, mm]")
    return parser.parse_args()


def needs_display():
    """Runs this script again under xvfb-run where no display is at hand; never returns then."""
    if os.environ.get("DISPLAY"):
        return
    xvfb = shutil.which("xvfb-run")
    if not xvfb:
        raise Problem("no display: set DISPLAY, or apt-get install xvfb xauth")
    os.execv(xvfb, [xvfb, "-a", sys.executable, *sys.argv])


def read_csv(path):
    """Columns as double arrays; text columns are left out."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        names = next(rows, None)
        if not names:
            raise Problem(f"{path}: empty; a first line with the names of the columns is needed")
        columns = [array.array("d") for _ in names]
        for row in rows:
            if len(row) != len(names):
                raise Problem(
                    f"{path}: line {rows.line_num}: {len(row)} fields instead of {len(names)}"
                )
            for column, text in zip(columns, row):
                try:
                    column.append(float(text) if text else math.nan)
                except ValueError:
                    column.append(math.nan)
    return dict(zip((n.strip() for n in names), columns))


def read_vtp(vtk, path):
    """Columns as double arrays, positions as x, y and z."""
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    count = data.GetNumberOfPoints()
    if count == 0:
        raise Problem(f"{path}: no points, or not a .vtp file")
    points = data.GetPoints().GetData()
    columns = {}
    for axis, name in enumerate("xyz"):
        columns[name] = array.array("d", (points.GetComponent(i, axis) for i in range(count)))
    for k in range(data.GetPointData().GetNumberOfArrays()):
        values = data.GetPointData().GetArray(k)
        if values is not None and values.GetNumberOfComponents() == 1:
            columns[values.GetName()] = array.array(
                "d", (values.GetComponent(i, 0) for i in range(count))
            )
    return columns


def read_pack(vtk, path):
    """The pack's columns; positions and radii are finite, radii positive."""
    if not os.path.isfile(path):
        raise Problem(f"{path}: no such file")
    columns = read_vtp(vtk, path) if path.endswith(".vtp") else read_csv(path)
    for name in ("x", "y", "z", "radius"):
        if name not in columns:
            raise Problem(f"{path}: no column '{name}' (it has {', '.join(columns)})")
        if not all(map(math.isfinite, columns[name])):
            raise Problem(f"{path}: column '{name}' holds something that is not a finite number")
    if len(columns["radius"]) == 0:
        raise Problem(f"{path}: no spheres")
    if min(columns["radius"]) <= 0:
        raise Problem(f"{path}: a radius of {min(columns['radius'])}; radii must be positive")
    return columns


def dropped(cuts, x, y, z):
    """Whether a cut takes the point (x, y, z) away."""
    point = (x, y, z)
    return any(sign * (point[axis] - position) > 0 for axis, position, sign in cuts)


def spheres_of(vtk, columns, color, cuts):
    """Poly data with the point arrays `radius` and `color`, in local coordinates, and their origin.

    Positions are taken relative to the first sphere: graphics cards count in single precision.
    """
    x, y, z, radius = (columns[n] for n in ("x", "y", "z", "radius"))
    values = columns[color]
    kept = [i for i in range(len(x)) if not dropped(cuts, x[i], y[i], z[i])]
    if not kept:
        raise Problem("the cuts leave no sphere; move them, or turn them around (x<0, x>0)")
    origin = (x[kept[0]], y[kept[0]], z[kept[0]])
    points = vtk.vtkPoints()
    points.SetNumberOfPoints(len(kept))
    radii = vtk.vtkFloatArray()
    colors = vtk.vtkFloatArray()
    cells = vtk.vtkCellArray()
    for values_of, name in ((radii, "radius"), (colors, "color")):
        values_of.SetName(name)
        values_of.SetNumberOfTuples(len(kept))
    for k, i in enumerate(kept):
        points.SetPoint(k, x[i] - origin[0], y[i] - origin[1], z[i] - origin[2])
        radii.SetValue(k, radius[i])
        colors.SetValue(k, values[i])
        cells.InsertNextCell(1)
        cells.InsertCellPoint(k)
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.SetVerts(cells)
    data.GetPointData().AddArray(radii)
    data.GetPointData().SetScalars(colors)
    return data, origin


def mesh_of(vtk, path, origin, cuts):
    """The surface as poly data with normals, in the spheres' local coordinates."""
    readers = {
        ".ply": vtk.vtkPLYReader,
        ".stl": vtk.vtkSTLReader,
        ".obj": vtk.vtkOBJReader,
    }
    extension = os.path.splitext(path)[1].lower()
    if extension not in readers:
        raise Problem(f"{path}: unknown kind of mesh; .ply, .stl and .obj are read")
    if not os.path.isfile(path):
        raise Problem(f"{path}: no such file")
    reader = readers[extension]()
    reader.SetFileName(path)
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputConnection(reader.GetOutputPort())
    normals.SplittingOff()
    last = normals
    for axis, position, sign in cuts:
        plane = vtk.vtkPlane()
        plane.SetOrigin(*(position if a == axis else 0 for a in range(3)))
        plane.SetNormal(*(-sign if a == axis else 0 for a in range(3)))
        clip = vtk.vtkClipPolyData()
        clip.SetInputConnection(last.GetOutputPort())
        clip.SetClipFunction(plane)
        last = clip
    move = vtk.vtkTransform()
    move.Translate(*(-o for o in origin))
    shift = vtk.vtkTransformPolyDataFilter()
    shift.SetInputConnection(last.GetOutputPort())
    shift.SetTransform(move)
    shift.Update()
    if shift.GetOutput().GetNumberOfCells() == 0:
        raise Problem(f"{path}: no triangles left to draw")
    return shift.GetOutput()


def lookup_table(vtk):
    """COLORS as a table of 256 steps."""
    function = vtk.vtkColorTransferFunction()
    for k, rgb in enumerate(COLORS):
        function.AddRGBPoint(k / (len(COLORS) - 1), *rgb)
    table = vtk.vtkLookupTable()
    table.SetNumberOfTableValues(256)
    table.Build()
    for k in range(256):
        table.SetTableValue(k, *function.GetColor(k / 255), 1.0)
    table.SetNanColor(0.5, 0.5, 0.5, 1.0)
    return table


def color_range(arguments, values):
    """The two ends of the scale of colors."""
    if arguments.range:
        try:
            low, high = (float(t) for t in arguments.range.split(","))
        except ValueError:
            raise Problem(f"--range {arguments.range}: not two numbers such as 0.5,1") from None
    else:
        finite = [v for v in values if math.isfinite(v)]
        if not finite:
            raise Problem(f"column '{arguments.color}' holds no number; choose another --color")
        low, high = min(finite), max(finite)
    return (low, high) if high > low else (low - 0.5, low + 0.5)


def add_light(vtk, renderer):
    """A key from the upper left, a fill from the right, a little from below, with the camera."""
    renderer.AutomaticLightCreationOff()
    lights = (((-0.7, 0.9, 1.0), 0.85), ((1.0, 0.1, 0.7), 0.35), ((0.0, -1.0, 0.4), 0.15))
    for position, intensity in lights:
        light = vtk.vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*position)
        light.SetFocalPoint(0, 0, 0)
        light.SetIntensity(intensity)
        renderer.AddLight(light)


def cross(a, b):
    return [a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3] for k in range(3)]


def point_camera(renderer, drawn, view, up, zoom):
    """Looks along -view in parallel projection, so that the poly data `drawn` fill the picture."""
    right = cross(up, view)
    if math.hypot(*right) < 1e-6 * math.hypot(*view) * math.hypot(*up):
        raise Problem("--view and --up are parallel; name another --up")
    ahead = [v / math.hypot(*view) for v in view]
    right = [r / math.hypot(*right) for r in right]
    axes = (right, cross(ahead, right), ahead)
    low, high = [math.inf] * 3, [-math.inf] * 3
    for data in drawn:
        # Enough points to find the rim within the margin.
        for i in range(0, data.GetNumberOfPoints(), 1 + data.GetNumberOfPoints() // 50000):
            point = data.GetPoint(i)
            for k, axis in enumerate(axes):
                t = point[0] * axis[0] + point[1] * axis[1] + point[2] * axis[2]
                low[k] = min(low[k], t)
                high[k] = max(high[k], t)
    middle = [0.5 * (a + b) for a, b in zip(low, high)]
    center = [sum(m * axis[k] for m, axis in zip(middle, axes)) for k in range(3)]
    radii = drawn[0].GetPointData().GetArray("radius").GetRange()
    depth = high[2] - low[2] + 4 * radii[1]
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*center)
    camera.SetPosition(*(c + a * 2 * depth for c, a in zip(center, ahead)))
    camera.SetViewUp(*axes[1])
    width, height = renderer.GetRenderWindow().GetSize()
    tall = 0.5 * (high[1] - low[1]) + radii[1]
    wide = 0.5 * (high[0] - low[0]) + radii[1]
    camera.SetParallelScale(1.04 * max(tall, wide * height / width) / zoom)
    camera.SetClippingRange(depth, 3 * depth)


def render(vtk, arguments, columns):
    """The picture as vtkImageData, RGB."""
    cuts = arguments.cut
    spheres, origin = spheres_of(
        vtk, columns, arguments.color, [] if arguments.cut_mesh_only else cuts
    )
    low, high = color_range(arguments, columns[arguments.color])
    table = lookup_table(vtk)
    dark = arguments.background == "black"

    renderer = vtk.vtkRenderer()
    renderer.SetBackground((0.05, 0.05, 0.06) if dark else (1, 1, 1))
    add_light(vtk, renderer)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(*(SUPERSAMPLING * s for s in arguments.size))
    window.AddRenderer(renderer)

    balls = vtk.vtkOpenGLSphereMapper()
    balls.SetInputData(spheres)
    balls.SetScaleArray("radius")
    balls.SetLookupTable(table)
    balls.SetScalarRange(low, high)
    balls.SetUseLookupTableScalarRange(0)
    actor = vtk.vtkActor()
    actor.SetMapper(balls)
    actor.GetProperty().SetAmbient(0.12)
    actor.GetProperty().SetSpecular(0.25)
    actor.GetProperty().SetSpecularPower(25)
    renderer.AddActor(actor)

    drawn = [spheres]
    if arguments.mesh:
        drawn.append(mesh_of(vtk, arguments.mesh, origin, cuts))
        skin = vtk.vtkPolyDataMapper()
        skin.SetInputData(drawn[-1])
        skin.ScalarVisibilityOff()
        shell = vtk.vtkActor()
        shell.SetMapper(skin)
        shell.GetProperty().SetColor(0.85, 0.80, 0.70)
        shell.GetProperty().SetOpacity(arguments.opacity)
        renderer.AddActor(shell)
        if arguments.opacity < 1:
            # Translucent layers need sorting; peeling does that by pixel.
            renderer.SetUseDepthPeeling(1)
            renderer.SetMaximumNumberOfPeels(8)
            window.SetAlphaBitPlanes(1)

    point_camera(renderer, drawn, arguments.view, arguments.up, arguments.zoom)

    if not arguments.no_bar:
        bar = vtk.vtkScalarBarActor()
        bar.SetLookupTable(table)
        table.SetRange(low, high)
        lengths = ("radius", "depth")
        unit = ", mm" if arguments.color in lengths else ""
        bar.SetTitle(arguments.label or arguments.color + unit)
        bar.SetNumberOfLabels(3)
        bar.SetLabelFormat("%.3g")
        bar.SetUnconstrainedFontSize(True)
        bar.SetPosition(0.02, 0.06)
        bar.SetWidth(0.06)
        bar.SetHeight(0.3)
        for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
            text.SetFontSize(SUPERSAMPLING * arguments.size[1] // 50)
            text.SetColor((1, 1, 1) if dark else (0, 0, 0))
            text.ShadowOff()
            text.ItalicOff()
            text.BoldOff()
        renderer.AddActor2D(bar)

    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    # Averaging blocks of pixels smooths the spheres' rims, which multisampling does not reach.
    shrink = vtk.vtkImageShrink3D()
    shrink.SetInputConnection(grab.GetOutputPort())
    shrink.SetShrinkFactors(SUPERSAMPLING, SUPERSAMPLING, 1)
    shrink.MeanOn()
    shrink.Update()
    return shrink.GetOutput()


def write_png(vtk, image, path):
    """Writes a PNG of 256 colors, a third the size of one in full color; whole or not at all."""
    quantize = vtk.vtkImageQuantizeRGBToIndex()
    quantize.SetInputData(image)
    quantize.SetNumberOfColors(PALETTE_SIZE)
    quantize.Update()
    table = quantize.GetLookupTable()
    palette = bytearray()
    for k in range(min(PALETTE_SIZE, table.GetNumberOfTableValues())):
        palette += bytes(round(255 * c) for c in table.GetTableValue(k)[:3])
    to_bytes = vtk.vtkImageCast()
    to_bytes.SetInputConnection(quantize.GetOutputPort())
    to_bytes.SetOutputScalarTypeToUnsignedChar()
    to_bytes.Update()
    indexed = to_bytes.GetOutput()
    width, height, _ = indexed.GetDimensions()
    pixels = bytes(memoryview(indexed.GetPointData().GetScalars()))
    # VTK counts rows from the bottom; each row starts with its filter, 0 for none.
    rows = b"".join(
        b"\0" + pixels[y * width : (y + 1) * width] for y in range(height - 1, -1, -1)
    )

    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    data = (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0))
        + chunk(b"PLTE", bytes(palette))
        + chunk(b"IDAT", zlib.compress(rows, 9))
        + chunk(b"IEND", b"")
    )
    temporary = path + ".tmp"
    with open(temporary, "wb") as file:
        file.write(data)
    os.replace(temporary, path)


def main():
    arguments = parse_arguments()
    try:
        try:
            import vtk
        except ImportError:
            raise Problem(
                f"{sys.executable} has no module vtk: apt-get install python3-vtk9, and call this "
                "script with /usr/bin/python3"
            ) from None
        needs_display()
        columns = read_pack(vtk, arguments.pack)
        if arguments.color not in columns:
            raise Problem(f"{arguments.pack}: no column '{arguments.color}' to color by")
        write_png(vtk, render(vtk, arguments, columns), arguments.output)
    except (Problem, OSError) as problem:
        sys.exit(f"render_pack.py: {problem}")


if __name__ == "__main__":
    main()
