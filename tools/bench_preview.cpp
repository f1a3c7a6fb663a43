#include "bench_preview.h"

#include "bench_clock.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/preview/preview.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

using namespace vdbpack;

void benchPreview(int threads, double count) {
    const auto sizes = SizeDistribution::parse("uniform:1,2", 3);
    // The solid fraction is 0.64 in a large box, less next to its faces.
    const double side = std::cbrt(count * sizes.meanBall(3) / 0.635);
    Box<3> box;
    box.add({{-side / 2, -side / 2, -side / 2}});
    box.add({{side / 2, side / 2, side / 2}});
    PackOptions pack(sizes);
    pack.threads = threads;
    const double begun = now();
    const auto packed = packSpheres(*boxDomain<3>(box), pack).pack;
    fmt::print("box of {:.4g} mm, radii uniform:1,2, {} threads: {} spheres packed in {:.2f} s\n",
               side, threads, packed.spheres.size(), now() - begun);
    for (const bool cut : {false, true}) {
        SpacePreview scene;
        scene.pack = &packed;
        PreviewOptions options;
        if (cut) options.cut = PreviewCut{0, 0};
        const double start = now();
        const std::clock_t busy = std::clock();
        const Picture image = withThreads(threads, [&] { return renderPreview(scene, options); });
        const double drawn = now();
        // The time of all threads, which other load on the machine hardly changes.
        const double processor = static_cast<double>(std::clock() - busy) / CLOCKS_PER_SEC;
        const std::string png = encodePng(image);
        const double encoded = now();
        fmt::print(
            "{:<14} {} x {} pixels: drawn in {:.2f} s ({:.2f} of processor), PNG of {:.1f} MB in "
            "{:.2f} s\n",
            cut ? "cut at x = 0" : "whole", image.width, image.height, drawn - start, processor,
            static_cast<double>(png.size()) * 1e-6, encoded - drawn);
        std::fflush(stdout);
    }
}
