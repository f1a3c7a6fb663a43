// Settings of a front, the same for all blocks of a pack.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/pack/front/sweep_waves.h"
#include "vdbpack/pack/pack_options.h"

namespace vdbpack {

/// Lengths of a front that follow from the requested sizes.
struct FrontLengths {
    /// How far a site where a further body stops the growth goes ahead of the sweep if the largest
    /// sphere fits there, mm; sites for smaller ones go ahead by less. 0: none does.
    double lead = 0;
    /// The same, in addition, for sites on walls towards which the front sweeps: large spheres come
    /// to lie there before those below leave them no room. mm.
    double wallLead = 0;
    /// The same for sites on spheres of earlier blocks ahead, across the faces of a periodic cell.
    double seamLead = 0;
    /// How far a site goes ahead of the sweep for each body that a sphere there touches, mm, and by
    /// less for one at a gap of up to `nearGap`, mm. 0: it does not matter how many are near.
    double crowdLead = 0, nearGap = 0;
    /// Radius for which sites are sought, mm: spheres placed there may be larger.
    double probe = 0;
    /// Sites where no sphere of this radius fits are not used, mm; 0: all are.
    double least = 0;
    /// Gap to the pivot up to which bodies limit the growth at its sites, mm; at least twice the
    /// probe. Bodies farther away hardly matter.
    double reach = 0;
    double minRadius = 0;   ///< of the distribution, mm
    double meanRadius = 0;  ///< of the distribution, mm
    double maxRadius = 0;   ///< of the distribution, mm
    /// Radius up to which spheres are frequent enough to be sought as neighbors, mm: the largest
    /// one, unless the distribution has a few that are far larger than most.
    double commonRadius = 0;
    /// Larger spheres rarely fit between others: they are set down ahead of the front, mm.
    double wideRadius = 0;
    double meanBall = 0;  ///< mean volume (2D: area) of a sphere, mm^Dim

    /// The lengths where all radii are multiplied by `factor`.
    /// @param layer  of the radii, which stays as it is, mm.
    FrontLengths scaled(double factor, double layer, int dim) const {
        FrontLengths s = *this;
        for (double* radius :
             {&s.probe, &s.minRadius, &s.meanRadius, &s.maxRadius, &s.commonRadius, &s.wideRadius})
            *radius = (*radius - layer) * factor + layer;
        if (least > 0) s.least = (least - layer) * factor + layer;
        for (double* length : {&s.lead, &s.wallLead, &s.seamLead, &s.reach})
            *length = *length * s.commonRadius / commonRadius;
        const double grown = s.meanRadius / meanRadius;
        s.crowdLead *= grown;
        s.nearGap *= grown;
        s.meanBall = meanBall * grown * grown * (dim == 3 ? grown : 1);
        return s;
    }
};

/// Directions and lengths that are the same for all blocks. Where sizes differ by place, the
/// lengths are those of the finest sizes of a block, and the largest radius is the largest of the
/// coarsest sizes; lengths of single spheres are `LocalLengths`.
template <int Dim>
struct FrontSettings : FrontLengths {
    Order order = Order::waves;
    bool evenSizes = true;  ///< PackOptions::evenSizes
    /// Unit direction in which the front sweeps: low values are filled first.
    Vec<Dim> sweep;
    SweepWaves<Dim> waves;  ///< of Order::waves
    Vec<Dim> middle;        ///< of the domain, where Order::center and fifo begin, mm
    /// Centers are whole multiples of this, mm; a power of two. Contacts keep a gap of about as
    /// much, so that rounding cannot make them overlaps.
    double quantum = 0x1p-24;
    double fieldError = 0;  ///< largest error of the domain's signedDistance, mm
    double fieldDepth = 0;  ///< depth at which it is clamped, mm
};

}  // namespace vdbpack
