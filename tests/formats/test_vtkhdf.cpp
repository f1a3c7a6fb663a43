// VTKHDF files, and packs in pieces.
#include "formats/file_text.h"
#include "formats/lattice_pack.h"
#include "support/test.h"
#include "support/thread_ranks.h"

#include "vdbpack/formats/hdf5_handle.h"
#include "vdbpack/formats/pack_parts.h"
#include "vdbpack/formats/pack_view.h"

#include <numeric>

namespace {

/// The spheres of a pack by rising id, with what is known of them.
template <class T>
std::vector<T> byId(const Pack<3>& pack, const std::vector<T>& values) {
    std::vector<std::size_t> order(pack.spheres.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return pack.id[a] < pack.id[b]; });
    std::vector<T> sorted;
    for (const std::size_t i : order) sorted.push_back(values[i]);
    return sorted;
}

/// Every `count`-th sphere of a pack, from the `rank`-th on; from the second third of the ranks
/// none.
Pack<3> shareOf(const Pack<3>& pack, int rank, int count) {
    Pack<3> share;
    share.columns.push_back({"stiffness", {}, {}});
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        if (static_cast<int>(i) % count != rank) continue;
        share.spheres.push_back(pack.spheres[i]);
        share.id.push_back(pack.id[i]);
        share.region.push_back(pack.region[i]);
        share.depth.push_back(pack.depth[i]);
        share.columns[0].numbers.push_back(pack.columns[0].numbers[i]);
    }
    return share;
}

}  // namespace

TEST_CASE("a .vtkhdf gives back every number bit for bit") {
    auto pack = packWithColumns(70000, "stiffness", "clump", {"a", "b"});
    const std::string file = GENERATE(as<std::string>{}, "p.vtkhdf", "p.hdf");
    const Pack<3> read = readBack(pack, file);
    CHECK((read.spheres == pack.spheres));
    requireSameAttributes(read, pack);
    pack.columns.pop_back();  // columns of texts are left out
    requireSameColumns(read, pack);
    PackWriteOptions options;
    options.unit = Unit::micrometer;
    const Pack<3> scaled = readBack(pack, file, options);
    for (std::size_t i = 0; i < pack.spheres.size(); i += 7)
        for (int d = 0; d < 3; ++d)
            CHECK(fromMillimeters(scaled.spheres[i].center[d], options.unit) ==
                  fromMillimeters(pack.spheres[i].center[d], options.unit));
}

TEST_CASE("an empty pack passes through the files of pieces") {
    const auto file = GENERATE(as<std::string>{}, "p.vtkhdf", "p.pvtp");
    CHECK(readBack(Pack<3>{}, file).spheres.empty());
}

TEST_CASE("files that are no VTKHDF of points are refused with the cause") {
    const TemporaryFolder scratch;
    const std::string file = scratch.file("p.vtkhdf");
    putContent(file, "no HDF5");
    CHECK_THAT(messageOf<InputError>([&] { readPack(file); }), Contains("HDF5"));
    CHECK_THROWS_AS(readPack(scratch.file("none.vtkhdf")), IoError);
    auto pack = latticePack<3>(2000, {{0, 0, 0}}, 20, 1);
    writePack(pack, file);
    const std::string whole = contentOf(file);
    for (const double share : {0.02, 0.3, 0.9}) {
        CAPTURE(share);
        putContent(
            file,
            whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
        CHECK_THROWS_AS(readPack(file), InputError);
    }
}

TEST_CASE("a missing piece of a .pvtp is named") {
    const TemporaryFolder scratch;
    writePack(latticePack<3>(20, {{0, 0, 0}}, 20, 1), scratch.file("p.pvtp"));
    std::remove(scratch.file("p_0000.vtp").c_str());
    CHECK_THAT(messageOf<IoError>([&] { readPack(scratch.file("p.pvtp")); }),
               Contains("p_0000.vtp"));
}

TEST_CASE("ranks write one pack, whatever their shares") {
    const TemporaryFolder scratch;
    const auto file = GENERATE(as<std::string>{}, "p.vtkhdf", "p.pvtp");
    auto pack = latticePack<3>(5000, {{9, 0, 0}}, 30, 3);
    pack.columns.push_back({"stiffness", {}, {}});
    for (std::size_t i = 0; i < 5000; ++i) {
        pack.id.push_back(static_cast<std::int64_t>(i));
        pack.columns[0].numbers.push_back(0.1 * static_cast<double>(i));
    }
    RankOffice office(4);
    onRanks(office, [&](Ranks& ranks) {
        // The first rank and the last have none.
        const Pack<3> share =
            ranks.rank() == 0 || ranks.rank() == 3 ? Pack<3>{} : shareOf(pack, ranks.rank() - 1, 2);
        const PackView view(share, Unit::millimeter);
        if (file == "p.pvtp")
            writePvtp(&ranks, view, {}, scratch.file(file));
        else
            writeVtkHdf(&ranks, view, {}, scratch.file(file));
    });
    Pack<3> read = readPack(scratch.file(file));
    REQUIRE(read.spheres.size() == pack.spheres.size());
    CHECK(byId(read, read.spheres) == pack.spheres);
    CHECK(byId(read, read.region) == pack.region);
    CHECK(byId(read, read.depth) == pack.depth);
    CHECK(byId(read, read.columns[0].numbers) == pack.columns[0].numbers);
}

TEST_CASE("names of columns that HDF5 takes for paths are written with underscores") {
    auto pack = latticePack<3>(20, {{0, 0, 0}}, 20, 1);
    for (const char* name : {"HU/1000", "HU.1000", "."})
        pack.columns.push_back({name, std::vector<double>(20, 1), {}});
    const Pack<3> read = readBack(pack, "p.vtkhdf");
    REQUIRE(read.columns.size() == 3);
    CHECK(read.columns[0].name == "HU_1000");
    CHECK(read.columns[1].name == "HU_1000_2");
    CHECK(read.columns[2].name == "_");
}

TEST_CASE("of several time steps of a .vtkhdf the last one is read, with a warning") {
    const TemporaryFolder scratch;
    const std::string file = scratch.file("p.vtkhdf");
    Pack<3> pack;  // a step of two spheres, and one of three
    for (int i = 0; i < 5; ++i) pack.spheres.push_back({{{1.0 * i, 0, 0}}, 1.0 + i});
    writePack(pack, file);
    {
        const Hdf5 whole(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
        const Hdf5 group(H5Gopen2(whole, "VTKHDF", H5P_DEFAULT), H5Gclose);
        const auto put = [](hid_t where, const char* name, std::vector<std::int64_t> values) {
            const hsize_t size = values.size();
            const Hdf5 space(H5Screate_simple(1, &size, nullptr), H5Sclose);
            const Hdf5 set(H5Dcreate2(where, name, H5T_NATIVE_INT64, space, H5P_DEFAULT,
                                      H5P_DEFAULT, H5P_DEFAULT),
                           H5Dclose);
            REQUIRE(H5Dwrite(set, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >=
                    0);
        };
        REQUIRE(H5Ldelete(group, "NumberOfPoints", H5P_DEFAULT) >= 0);
        put(group, "NumberOfPoints", {2, 1, 2});
        const auto make = [](hid_t where, const char* name) {
            return Hdf5(H5Gcreate2(where, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
        };
        const Hdf5 steps = make(group, "Steps"), data = make(steps, "PointDataOffsets");
        put(steps, "NumberOfParts", {1, 2});
        put(steps, "PartOffsets", {0, 1});
        put(steps, "PointOffsets", {0, 2});
        put(data, "radius", {0, 2});
        put(data, "id", {0, 2});
    }
    std::vector<std::string> warnings;
    PackReadOptions options;
    options.callbacks = keepingWarnings({}, warnings);
    const Pack<3> last = readPack(file, options);
    CHECK(last.spheres == std::vector<Sphere<3>>(pack.spheres.begin() + 2, pack.spheres.end()));
    CHECK(last.id == std::vector<std::int64_t>{2, 3, 4});
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Contains(file) && Contains("last"));
}
