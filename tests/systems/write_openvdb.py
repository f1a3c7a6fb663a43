"""Writes level sets by this system's OpenVDB, as its codecs allow.

usage: write_openvdb.py FOLDER
"""

import sys

try:
    import openvdb
except ImportError:
    import pyopenvdb as openvdb


def main():
    folder = sys.argv[1]
    for half in (False, True):
        ball = openvdb.createLevelSetSphere(radius=10.0, center=(20, 30, 40), voxelSize=0.5)
        ball.name = "ball"
        ball.saveFloatAsHalf = half
        same = ball.deepCopy()
        fog = openvdb.FloatGrid()
        fog.name = "fog"
        fog.fill((0, 0, 0), (20, 20, 20), 1.0)
        openvdb.write(f"{folder}/{'half' if half else 'float'}.vdb", grids=[fog, ball, same])
    print("OpenVDB", ".".join(map(str, openvdb.LIBRARY_VERSION)))


if __name__ == "__main__":
    main()
