#include "bench_densify.h"

#include "bench_clock.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <stdexcept>

using namespace vdbpack;

namespace {

struct Job {
    std::string domain, unit = "mm", spec = "uniform:1,2";
    double fraction = 0;  ///< infinity: as dense as possible
    double count = 0;  ///< radii are scaled so that the front places about this many; 0: not scaled
};

Job parseJob(const std::string& word) {
    std::vector<std::string> parts{""};
    for (const char c : word) {
        if (c == '=')
            parts.emplace_back();
        else
            parts.back() += c;
    }
    if (parts.size() < 2 || parts.size() > 4)
        throw std::runtime_error(word + ": write DOMAIN[@UNIT]=FRACTION[=SPEC[=COUNT]]");
    Job job;
    const auto at = parts[0].find('@');
    job.domain = parts[0].substr(0, at);
    if (at != std::string::npos) job.unit = parts[0].substr(at + 1);
    job.fraction = parts[1] == "max" ? std::numeric_limits<double>::infinity()
                                     : std::strtod(parts[1].c_str(), nullptr);
    if (parts.size() > 2) job.spec = parts[2];
    if (parts.size() > 3) job.count = std::strtod(parts[3].c_str(), nullptr);
    return job;
}

constexpr int kTubes = 3;

/// Distance to the wall of tubes of radius `r` along the three axes, mm, negative inside; a tube
/// runs through the middle of each pitch and ends at the box.
double distanceToTubes(const Vec<3>& x, double r, double pitch) {
    double least = std::numeric_limits<double>::infinity();
    for (int d = 0; d < 3; ++d) {
        double square = 0;
        for (int e = 0; e < 3; ++e) {
            if (e == d) continue;
            const double off = x[e] - (std::floor(x[e] / pitch) + 0.5) * pitch;
            square += off * off;
        }
        least = std::min(least, std::sqrt(square) - r);
    }
    for (int d = 0; d < 3; ++d) least = std::max({least, -x[d], x[d] - kTubes * pitch});
    return least;
}

/// Tubes of radius `r` along the three axes, 6 r apart, as a closed mesh: the faces of small cubes
/// with their vertices moved to the walls of the tubes.
TriangleMesh strutMesh(double r) {
    using Index = std::array<int, 3>;
    constexpr int kPerRadius = 6;
    const double pitch = 6 * r, h = r / kPerRadius;
    const int n = static_cast<int>(std::lround(pitch * kTubes / h)) + 3;
    const auto distance = [&](const Vec<3>& x) { return distanceToTubes(x, r, pitch); };
    const auto at = [&](const Index& i) {
        return Vec<3>{{(i[0] - 1.5) * h, (i[1] - 1.5) * h, (i[2] - 1.5) * h}};
    };
    const auto inside = [&](const Index& i) {
        return distance(at(i) + Box<3>::filled(0.5 * h)) < 0;
    };
    TriangleMesh mesh;
    std::map<Index, std::uint32_t> names;
    const auto vertex = [&](const Index& i) {
        const auto [found, isNew] =
            names.emplace(i, static_cast<std::uint32_t>(mesh.vertices.size()));
        if (isNew) {
            Vec<3> x = at(i);
            // Newton steps along the gradient, no farther than half a cube.
            for (int step = 0; step < 4; ++step) {
                Vec<3> slope;
                for (int d = 0; d < 3; ++d) {
                    Vec<3> by;
                    by[d] = 1e-4 * h;
                    slope[d] = (distance(x + by) - distance(x - by)) / (2e-4 * h);
                }
                if (const double s = squaredLength(slope); s > 0.1) x += slope * (-distance(x) / s);
            }
            const Vec<3> way = x - at(i);
            const double most = 0.45 * h, l = length(way);
            mesh.vertices.push_back(at(i) + (l > most ? way * (most / l) : way));
        }
        return found->second;
    };
    const auto moved = [](Index i, std::size_t axis, int by) {
        i[axis] += by;
        return i;
    };
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i)
                for (std::size_t d = 0; d < 3 && inside({i, j, k}); ++d)
                    for (const int side : {0, 1}) {
                        if (inside(moved({i, j, k}, d, 2 * side - 1))) continue;
                        // Around the face, counterclockwise from outside.
                        const std::size_t u = (d + 1 + (1 - side)) % 3,
                                          v = (d + 2 - (1 - side)) % 3;
                        const Index corner = moved({i, j, k}, d, side);
                        const std::uint32_t a = vertex(corner), b = vertex(moved(corner, u, 1)),
                                            c = vertex(moved(moved(corner, u, 1), v, 1)),
                                            e = vertex(moved(corner, v, 1));
                        mesh.triangles.push_back({a, b, c});
                        mesh.triangles.push_back({a, c, e});
                    }
    return mesh;
}

template <int Dim>
void run(const Job& job, const DomainSource& source, const Domain<Dim>& domain,
         SizeDistribution sizes, int threads) {
    PackOptions packing(sizes);
    if (job.count > 0) {
        sizes = sizes.scaled(scaleForCount(domain, packing, job.count));
        packing.sizes = sizes;
    }
    auto spheres = packSpheres(domain, packing).pack.spheres;
    DensifyOptions options;
    options.fraction = job.fraction;
    options.sizes = sizes;
    options.mixSizes = true;
    const double start = now();
    auto result = densify(domain, spheres, options);
    const double seconds = now() - start;
    spheres = std::move(result.spheres);
    const auto interior = interiorFraction(spheres, domain, 3 * sizes.max());
    std::vector<double> radii;
    for (const auto& s : spheres) radii.push_back(s.radius);
    const double ks = ksDistance(
        std::move(radii), [&](double r) { return sizes.cdf(r); },
        [&](double r) { return sizes.cdfBelow(r); });
    Pack<Dim> pack;
    pack.spheres = spheres;
    const double overlap = checkOverlap(spheres).max, out = source.protrusion(spheres).max;
    const ContactNetwork contacts = countContacts(spheres, 1e-3);
    fmt::print(
        "{:<22} {:<12} {:>8} {:>6.4f} {:>6} {:>6.4f} {:>6} {:>6} {:>7.2f} {:>6.1f} {:>6.4f} "
        "{:>6.4f} {:>5.2f} {:>5.2f} {:>6.4f} {:>7.1e} {:>7.1e} {}\n",
        std::filesystem::path(job.domain).filename().string(), job.spec, spheres.size(),
        result.before, std::isfinite(job.fraction) ? fmt::format("{:.3f}", job.fraction) : "max",
        result.after, interior ? fmt::format("{:.4f}", *interior) : "-", result.steps, seconds,
        1e6 * seconds * threads / static_cast<double>(spheres.size()), ks, solidLikeShare(spheres),
        contacts.meanOfSpheres, countContacts(spheres, 1e-4).meanOfSpheres,
        contacts.largestComponent, overlap, out, hashText(packHash(pack)));
    std::fflush(stdout);
    if (overlap > 0 || out > kVerifyTolerance) throw std::runtime_error("a pack is not sound");
}

void runJob(const Job& job, int threads) {
    DomainRecipe recipe;
    recipe.source = job.domain;
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / fmt::format("bench_densify_{}.stl", ::getpid());
    if (job.domain.rfind("struts:", 0) == 0) {
        writeStl(strutMesh(std::strtod(job.domain.c_str() + 7, nullptr)), file.string());
        recipe.source = file.string();
    }
    recipe.unit = parseUnit(job.unit);
    const DomainSource source(recipe);
    std::filesystem::remove(file);
    auto sizes = SizeDistribution::parse(job.spec, source.dim());
    if (job.count > 0)
        sizes = sizes.scaled(std::pow((source.dim() == 3 ? 0.61 : 0.82) * source.volume() /
                                          sizes.meanBall(source.dim()) / job.count,
                                      1.0 / source.dim()));
    const auto built = source.build(sizes.min(), sizes.max());
    if (built.space)
        run<3>(job, source, *built.space, sizes, threads);
    else
        run<2>(job, source, *built.plane, sizes, threads);
}

}  // namespace

void benchDensify(int threads, bool quick, std::vector<std::string> words) {
    if (words.empty() && quick)
        words = {"box:60,60,60=0.645", "box:100,100,6=0.57", "rect:200,200=0.835"};
    if (words.empty())
        words = {"box:120,120,120=0.645", "box:120,120,120=0.66", "box:120,120,120=max",
                 "box:373,373,373=0.645", "box:400,400,6=0.59",   "box:300,300,10=0.6",
                 "box:200,200,20=0.63",   "struts:6=0.6",         "box:60,60,60=0.62=constant:1",
                 "rect:600,600=0.835"};
    fmt::print(
        "{} threads; solid fractions of the front, target, reached, and deeper than three "
        "largest\nradii; us: microseconds of processor per sphere; ks: distance from SPEC; "
        "cryst: crystalline share;\nz3, z4: coordination number for gaps up to 0.001 and 0.0001 of "
        "the smaller radius; joined: share of\nthe spheres in the largest connected component "
        "(0.001)\n",
        threads);
    fmt::print(
        "{:<22} {:<12} {:>8} {:>6} {:>6} {:>6} {:>6} {:>6} {:>7} {:>6} {:>6} {:>6} "
        "{:>5} {:>5} {:>6} {:>7} {:>7} hash\n",
        "domain", "radii", "spheres", "front", "target", "after", "inner", "steps", "s", "us", "ks",
        "cryst", "z3", "z4", "joined", "overlap", "out");
    for (const auto& word : words) {
        const Job job = parseJob(word);
        withThreads(threads, [&] { runJob(job, threads); });
    }
}
