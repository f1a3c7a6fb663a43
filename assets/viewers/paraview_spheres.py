"""Shows a pack (.vtkhdf, .vtp or .pvtp of vdb_pack) in ParaView as spheres of true radius; 5.10 and later.

    paraview bone.vtkhdf paraview_spheres.py                   in the window, for the open file
    pvpython paraview_spheres.py bone.vtkhdf --color region --render bone.png     a picture

The same by hand: representation Point Gaussian, shader preset Sphere, Gaussian radius 1, scale by
the array "radius" without a scale function, color by the array of your choice.
"""

import argparse
import os
import sys

from paraview import simple

COLOR = "radius"  # radius, region, depth, order, contacts


def fail(message):
    sys.exit(f"paraview_spheres.py: {message}")


def numbers(text, count, form):
    try:
        values = [float(t) for t in text.replace("x", ",").split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise argparse.ArgumentTypeError(f"'{text}': {form} expected")
    return values


def parse_arguments():
    parser = argparse.ArgumentParser(description="Shows a pack as spheres in ParaView.")
    parser.add_argument("file", nargs="?", help=".vtkhdf, .hdf, .vtp or .pvtp; in the window: what is open")
    parser.add_argument("--color", default=COLOR, help=f"array to color by (default {COLOR})")
    parser.add_argument("--render", metavar="FILE.png", help="writes a picture")
    parser.add_argument("--view", type=lambda t: numbers(t, 3, "three numbers such as 1,-1,0.3"),
                        default=[0.45, -1, 0.3], metavar="X,Y,Z", help="from where to look")
    parser.add_argument("--up", type=lambda t: numbers(t, 3, "three numbers such as 0,0,1"),
                        default=[0, 0, 1], metavar="X,Y,Z", help="up in the picture")
    parser.add_argument("--size", type=lambda t: numbers(t, 2, "a size such as 1200x900"),
                        default=[1200, 1200], metavar="WxH", help="of the picture, pixels")
    return parser.parse_args()


def source_of(file):
    if file is None:
        source = simple.GetActiveSource()
        if source is None:
            fail("no file is open; name one: paraview FILE.vtkhdf paraview_spheres.py")
        return source
    if not os.path.isfile(file):
        fail(f"{file}: there is no such file")
    try:
        source = simple.OpenDataFile(os.path.abspath(file))
    except RuntimeError:
        source = None
    if source is None:
        fail(f"{file}: this ParaView knows no such file; a .vtkhdf opens in 5.11 under the name .hdf")
    return source


def main():
    arguments = parse_arguments()
    source = source_of(arguments.file)
    source.UpdatePipeline()
    arrays = source.PointData
    if arrays.GetArray("radius") is None:
        fail("the data has no array 'radius'; write it with vdb_pack ... -o FILE.vtkhdf")
    if arrays.GetArray(arguments.color) is None:
        fail(f"there is no array '{arguments.color}' to color by; use {', '.join(arrays.keys())}")

    view = simple.GetActiveViewOrCreate("RenderView")
    shown = simple.Show(source, view)
    shown.SetRepresentationType("Point Gaussian")
    shown.ShaderPreset = "Sphere"
    shown.GaussianRadius = 1.0
    shown.ScaleByArray = 1
    shown.SetScaleArray = ["POINTS", "radius"]
    shown.UseScaleFunction = 0
    simple.ColorBy(shown, ("POINTS", arguments.color))
    shown.RescaleTransferFunctionToDataRange(True)
    shown.SetScalarBarVisibility(view, True)

    low, high = zip(*[source.GetDataInformation().GetBounds()[i:i + 2] for i in (0, 2, 4)])
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    view.CameraFocalPoint = middle
    view.CameraPosition = [m + d for m, d in zip(middle, arguments.view)]
    view.CameraViewUp = arguments.up
    view.ResetCamera()
    simple.Render(view)
    if arguments.render:
        size = [int(s) for s in arguments.size]
        simple.SaveScreenshot(arguments.render, view, ImageResolution=size)


main()
