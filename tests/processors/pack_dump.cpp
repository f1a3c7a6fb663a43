// Writes packs, bit for bit, to a file: built for several processors, the files must be equal.
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/pack/packer.h"

#include <cstdio>

using namespace vdbpack;

namespace {

template <int Dim>
void dump(std::FILE* file, const Domain<Dim>& domain, const PackOptions& options,
          const std::vector<Sphere<Dim>>& existing = {}) {
    for (const Sphere<Dim>& s : packSpheres(domain, options, {}, existing).pack.spheres) {
        std::fwrite(s.center.c.data(), sizeof(double), Dim, file);
        std::fwrite(&s.radius, sizeof(double), 1, file);
    }
}

template <int Dim>
void dumpAll(std::FILE* file) {
    const double side = Dim == 3 ? 50 : 250;
    const auto box = boxDomain<Dim>({Box<Dim>::filled(-side / 2), Box<Dim>::filled(side / 2)});
    HalfSpace<Dim> cut;
    for (int d = 0; d < Dim; ++d) cut.normal[d] = 1 + 0.3 * d;
    cut.offset = 5;
    const auto ball = clippedDomain<Dim>(ballDomain<Dim>(side / 2), {cut});
    for (const Effort effort : {Effort::fast, Effort::normal, Effort::dense})
        for (const std::uint64_t seed : {1, 2, 3}) {
            PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
            options.effort = effort;
            options.seed = seed;
            options.blockSide = 16;
            dump<Dim>(file, *box, options);
            dump<Dim>(file, *ball, options);
        }
    PackOptions wide(SizeDistribution::parse("lognormal:0.6,0.8,0.5,5", Dim));
    wide.gap = 0.01;
    dump<Dim>(file, *ball, wide, {{{}, 4.3}});
    for (const Order order : {Order::waves, Order::wall, Order::center, Order::fifo}) {
        wide.order = order;
        dump<Dim>(file, *ball, wide);
    }
}

}  // namespace

int main(int argc, char** argv) {
    std::FILE* file = argc > 1 ? std::fopen(argv[1], "wb") : nullptr;
    if (!file) return 2;
    dumpAll<3>(file);
    dumpAll<2>(file);
    return std::fclose(file) == 0 ? 0 : 1;
}
