// What writing a pack costs beside packing.
#pragma once

/// Packs a box and prints what writing its spheres to each format takes beside packing it with
/// normal effort.
/// @param side  of the box, mm; radii are uniform from 1 to 2 mm.
void benchWrite(int threads, double side);
