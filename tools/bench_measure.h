// Time of measuring packs and samples.
#pragma once

/// Packs a box and takes all measures of the pack, then the morphometry of a trabecular sample, on
/// `threads` threads; prints results and seconds of both.
/// @param side   of the box, mm, with radii 1 to 2.
/// @param edge   of the sample, voxels.
void benchMeasure(int threads, double side, int edge);
