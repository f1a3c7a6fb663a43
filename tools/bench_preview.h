// Time of drawing pictures.
#pragma once

/// Packs a box with about `count` spheres and draws it whole and cut open at 1600 x 1200.
void benchPreview(int threads, double count);
