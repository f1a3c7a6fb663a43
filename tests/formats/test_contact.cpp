#include "formats/lattice_pack.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/numbers.h"

namespace {

/// The rows of a contact list below its header.
std::vector<std::vector<double>> rowsOf(const std::string& content) {
    std::istringstream in(content);
    std::string line;
    std::getline(in, line);
    REQUIRE(line == "i,j,gap,nx,ny,nz,region_i,region_j");
    std::vector<std::vector<double>> rows;
    while (std::getline(in, line)) {
        rows.emplace_back();
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');) {
            rows.back().emplace_back();
            REQUIRE(parseNumber(cell, rows.back().back()));
        }
    }
    return rows;
}

}  // namespace

DIM_TEST_CASE("a contact list holds ids, gaps, normals and regions") {
    Vec<Dim> center;
    for (int d = 0; d < Dim; ++d) center[d] = 700;
    auto pack = latticePack<Dim>(200, center, 20, 31);
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        pack.id.push_back(static_cast<std::int64_t>(1000000000000 + 3 * i));
    const auto contacts = listContacts(pack.spheres, 0.1);
    REQUIRE(contacts.size() > 20);
    const TemporaryFolder scratch;
    writeContacts(pack, contacts, scratch.file("c.csv"));
    const auto rows = rowsOf(contentOf(scratch.file("c.csv")));
    REQUIRE(rows.size() == contacts.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const auto& row = rows[k];
        const auto i = contacts[k].i, j = contacts[k].j;
        REQUIRE(row.size() == 8);
        REQUIRE(row[0] == static_cast<double>(pack.id[i]));
        REQUIRE(row[1] == static_cast<double>(pack.id[j]));
        REQUIRE(row[2] == contacts[k].gap);
        double square = 0, along = 0;
        for (int d = 0; d < 3; ++d) {
            const double n = row[static_cast<std::size_t>(3 + d)];
            square += n * n;
            if (d < Dim) along += n * (pack.spheres[j].center[d] - pack.spheres[i].center[d]);
        }
        REQUIRE(square == Approx(1).epsilon(1e-14));
        // From i to j, and as long as radii and gap together.
        REQUIRE(along == Approx(pack.spheres[i].radius + pack.spheres[j].radius + row[2]));
        if (Dim == 2) REQUIRE(row[5] == 0);
        REQUIRE(row[6] == pack.region[i]);
        REQUIRE(row[7] == pack.region[j]);
    }
    const auto written = contentOf(scratch.file("c.csv"));
    for (const int threads : {1, 4}) {
        withThreads(threads, [&] { writeContacts(pack, contacts, scratch.file("d.csv")); });
        REQUIRE(contentOf(scratch.file("d.csv")) == written);
    }
}

TEST_CASE("a contact list is in the requested unit, with indices if there are no ids") {
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}, {{{0, 0, 4}}, 1}, {{{0, 0, 2.5}}, 1}};
    const auto contacts = listContacts(pack.spheres, 0.6);
    const TemporaryFolder scratch;
    writeContacts(pack, contacts, scratch.file("c.csv"), Unit::micrometer);
    REQUIRE(contentOf(scratch.file("c.csv")) ==
            "i,j,gap,nx,ny,nz,region_i,region_j\n"
            "0,2,500.0,0.0,0.0,1.0,0,0\n"
            "1,2,-500.0,0.0,0.0,-1.0,0,0\n");
    writeContacts(pack, {}, scratch.file("none.csv"));
    REQUIRE(rowsOf(contentOf(scratch.file("none.csv"))).empty());
    // Spheres around one center have no direction.
    pack.spheres[1] = pack.spheres[0];
    writeContacts(pack, {{0, 1, -2}}, scratch.file("c.csv"));
    REQUIRE(rowsOf(contentOf(scratch.file("c.csv"))) ==
            std::vector<std::vector<double>>{{0, 1, -2, 0, 0, 0, 0, 0}});
}

TEST_CASE("contacts of another pack are refused and leave the former file") {
    Pack<3> pack;
    pack.spheres.resize(3, {{}, 1});
    const TemporaryFolder scratch;
    putContent(scratch.file("c.csv"), "before");
    for (const Contact wrong :
         {Contact{0, 3, 0}, Contact{1, 1, 0}, Contact{9, 0, 0}, Contact{0, 1, std::nan("")},
          Contact{0, 1, std::numeric_limits<double>::infinity()}})
        REQUIRE_THROWS_AS(writeContacts(pack, {{0, 1, 0}, wrong}, scratch.file("c.csv")),
                          ParameterError);
    pack.region = {0, 1};
    REQUIRE_THROWS_AS(writeContacts(pack, {{0, 1, 0}}, scratch.file("c.csv")), ParameterError);
    REQUIRE(contentOf(scratch.file("c.csv")) == "before");
    REQUIRE(scratch.files() == 1);
    pack.region.clear();
    REQUIRE_THROWS_AS(writeContacts(pack, {}, scratch.file("no/c.csv")), IoError);
}
