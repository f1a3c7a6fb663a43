// Time of writing a pack, compared with packing.
#pragma once

/// Packs a box, writes its spheres to each format and prints the time of each, compared with the
/// time of packing it with normal effort.
/// @param side  of the box, mm; radii are uniform from 1 to 2 mm.
void benchWrite(int threads, double side);
