// Fields of directions in .vdb files, written here as others would.
#include "support/grids.h"
#include "support/test.h"
#include "voids/turning.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/core/tensor.h"
#include "vdbpack/voids/direction_field.h"

namespace {

using openvdb::Coord;

constexpr int kVoxels = 24;
constexpr double kVoxel = 2.5;  // mm
constexpr double kSide = kVoxels * kVoxel;

/// Voxels turned by 30 degrees about z and moved; also the way from the place of a voxel to the
/// field's x.
openvdb::math::Transform::Ptr turnedTransform(double voxel = kVoxel) {
    const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
    transform->postRotate(kPi / 6, openvdb::math::Z_AXIS);
    transform->postTranslate(openvdb::Vec3d(100, -50, 20));
    return transform;
}

Vec<3> placeOf(const openvdb::math::Transform& transform, const openvdb::Vec3d& voxel) {
    const auto p = transform.indexToWorld(voxel);
    return {{p[0], p[1], p[2]}};
}

/// The field at a place, by what its first coordinate is beyond that of the grid's origin.
Vec<3> expectedAt(const Vec<3>& x) {
    return turning({{x[0] - 70, 0, 0}}, kSide);
}

/// Fills a cube of voxels with `value(place)`.
template <class GridType, class Value>
typename GridType::Ptr filled(const std::string& name, const Value& value,
                              const openvdb::math::Transform::Ptr& transform = turnedTransform()) {
    const auto grid = newGrid<GridType>();
    grid->setName(name);
    grid->setTransform(transform);
    auto accessor = grid->getAccessor();
    for (int i = 0; i < kVoxels; ++i)
        for (int j = 0; j < kVoxels; ++j)
            for (int k = 0; k < kVoxels; ++k) {
                const Coord voxel(i, j, k);
                accessor.setValueOn(voxel, value(placeOf(*transform, voxel.asVec3d())));
            }
    return grid;
}

class VdbFile {
public:
    explicit VdbFile(const openvdb::GridPtrVec& grids, const std::string& name = "field.vdb")
        : path_(folder_.file(name)) {
        openvdb::initialize();
        openvdb::io::File(path_).write(grids);
    }
    std::shared_ptr<const DirectionField> read(double scale = 1) const {
        return readDirectionField(path_, scale);
    }
    std::string failure() const {
        return messageOf<InputError>([&] { read(); });
    }

private:
    TemporaryFolder folder_;
    std::string path_;
};

openvdb::Vec3s toVec3s(const Vec<3>& u) {
    return openvdb::Vec3s(openvdb::Vec3d(u[0], u[1], u[2]));
}

openvdb::GridBase::Ptr turningGrid() {
    return filled<openvdb::Vec3SGrid>("direction",
                                      [](const Vec<3>& x) { return toVec3s(expectedAt(x)); });
}

/// Compression along the turning direction.
Tensor stressAt(const Vec<3>& x) {
    const Vec<3> u = expectedAt(x);
    Tensor t{};
    addScaled(t, -3, dyad(u));
    addScaled(t, 1, dyad(cross(u, {{0, 0, 1}})));
    return t;
}

/// The largest angle between field and truth, in voxels and between them, degrees.
double worstError(const DirectionField& field) {
    const auto transform = turnedTransform();
    RandomStream random(12, 1);
    double worst = 0;
    for (int n = 0; n < 3000; ++n) {
        openvdb::Vec3d voxel;
        for (int d = 0; d < 3; ++d) voxel[d] = (kVoxels - 1) * random.uniform();
        if (n % 3 == 0) voxel = Coord::floor(voxel).asVec3d();
        const Vec<3> x = placeOf(*transform, voxel);
        worst = std::max(worst, degreesBetween(field.at(x), expectedAt(x)));
    }
    return worst;
}

}  // namespace

TEST_CASE("a grid of vectors is met between its voxels, wherever they lie") {
    CHECK(worstError(*VdbFile({turningGrid()}).read()) < 0.05);
    const auto doubles = filled<openvdb::Vec3DGrid>("u", [](const Vec<3>& x) {
        const Vec<3> u = expectedAt(x) * 1e-30;
        return openvdb::Vec3d(u[0], u[1], u[2]);
    });
    CHECK(worstError(*VdbFile({doubles}).read()) < 0.05);
}

TEST_CASE("a grid of vectors flipped at random is the same field") {
    RandomStream flip(13, 1);
    const auto flipped = filled<openvdb::Vec3SGrid>("direction", [&](const Vec<3>& x) {
        return toVec3s(expectedAt(x) * (flip.uniform() < 0.5 ? -1 : 1));
    });
    CHECK(worstError(*VdbFile({flipped}).read()) < 0.05);
}

TEST_CASE("a tensor is read from a pair of vector grids and from six scalar ones") {
    const auto part = [](std::size_t first) {
        return [first](const Vec<3>& x) {
            const Tensor t = stressAt(x);
            return toVec3s({{t[first], t[first + 1], t[first + 2]}});
        };
    };
    CHECK(worstError(*VdbFile({filled<openvdb::Vec3SGrid>("stress_offdiagonal", part(3)),
                               filled<openvdb::Vec3SGrid>("stress_diagonal", part(0))})
                          .read()) < 0.05);
    const std::vector<std::vector<std::string>> naming{
        {"xx", "yy", "zz", "xy", "yz", "xz"},
        {"stress.XX", "stress.YY", "stress.ZZ", "stress.XY", "stress.YZ", "stress.XZ"},
        {"S11", "S22", "S33", "S12", "S23", "S13"}};
    for (const auto& names : naming) {
        CAPTURE(names);
        openvdb::GridPtrVec grids;
        for (std::size_t c = 0; c < 6; ++c)
            grids.push_back(filled<openvdb::FloatGrid>(
                names[c], [c](const Vec<3>& x) { return static_cast<float>(stressAt(x)[c]); }));
        // Others in the file do not matter, nor in which order they come.
        grids.push_back(filled<openvdb::FloatGrid>("density", [](const Vec<3>&) { return 1.f; }));
        std::reverse(grids.begin(), grids.end());
        CHECK(worstError(*VdbFile(grids).read()) < 0.05);
    }
    const auto zeros = filled<openvdb::DoubleGrid>("xx", [](const Vec<3>&) { return 0.0; });
    openvdb::GridPtrVec grids{zeros};
    for (const char* name : {"yy", "zz", "xy", "yz", "xz"}) {
        grids.push_back(zeros->deepCopyGrid());
        grids.back()->setName(name);
    }
    CHECK_THAT(VdbFile(grids).failure(), Contains("field.vdb"));
    grids.back()->setTransform(turnedTransform(1));
    CHECK_THAT(VdbFile(grids).failure(), Contains("'xx'") && Contains("'xz'"));
    grids.pop_back();
    CHECK_THAT(VdbFile(grids).failure(), Contains("field.vdb"));
}

TEST_CASE("voxels without a direction leave it to their neighbors") {
    // A shell of voxels one thick, zero or inactive elsewhere.
    const auto grid = filled<openvdb::Vec3SGrid>(
        "direction", [](const Vec<3>& x) { return toVec3s(expectedAt(x)); });
    auto accessor = grid->getAccessor();
    for (int i = 0; i < kVoxels; ++i)
        for (int j = 0; j < kVoxels; ++j)
            for (int k = 0; k < kVoxels; ++k) {
                if (k == 7) continue;
                if (i % 2 == 0)
                    accessor.setValueOn(Coord(i, j, k), openvdb::Vec3s(0));
                else
                    accessor.setValueOff(Coord(i, j, k), openvdb::Vec3s(5, 5, 5));
            }
    const auto field = VdbFile({grid}).read();
    const auto transform = turnedTransform();
    for (const double k : {7.0, 6.5, 7.9}) {
        const Vec<3> x = placeOf(*transform, {11.25, 12.5, k});
        CHECK(degreesBetween(field->at(x), expectedAt(x)) < 0.5);
    }
    // Farther away leaves of voxels stand for theirs.
    const Vec<3> x = placeOf(*transform, {11.25, 12.5, 20});
    CHECK(degreesBetween(field->at(x), expectedAt(x)) < 20);
    CHECK(length(field->at({{1e30, 0, 0}})) == Approx(1));
    // The box of the voxels that tell something, a voxel wider.
    const auto bounds = field->bounds();
    CHECK(bounds.lo[2] == Approx(20 + 6 * kVoxel));
    CHECK(bounds.hi[2] == Approx(20 + 8 * kVoxel));
}

TEST_CASE("a field in another unit and one made of tiles are placed in mm") {
    const auto grid = newGrid<openvdb::Vec3SGrid>();
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.001));
    grid->fill(openvdb::CoordBBox(Coord(0), Coord(63)), openvdb::Vec3s(0, -2, 0));
    const auto field = VdbFile({grid}).read(1000);
    CHECK(length(field->bounds().lo - Vec<3>{{-1, -1, -1}}) < 1e-9);
    CHECK(length(field->bounds().hi - Vec<3>{{64, 64, 64}}) < 1e-9);
    for (const double at : {0.5, 31.2, 80.0})
        CHECK(degreesBetween(field->at({{at, at, at}}), {{0, 1, 0}}) < 1e-9);
}

TEST_CASE("a .vdb file without one field of directions is refused") {
    const auto density = filled<openvdb::FloatGrid>("density", [](const Vec<3>&) { return 1.f; });
    CHECK_THAT(VdbFile({density}).failure(),
               Contains("field.vdb") && Contains("'density'") && Contains("NAME_diagonal"));
    const auto other = turningGrid();
    other->setName("velocity");
    CHECK_THAT(VdbFile({turningGrid(), other}).failure(),
               Contains("'direction'") && Contains("'velocity'"));
    const auto alone = turningGrid();
    alone->setName("stress_diagonal");
    CHECK_THAT(VdbFile({alone}).failure(), Contains("'stress_diagonal'"));
    const auto broken = filled<openvdb::Vec3SGrid>("direction", [](const Vec<3>&) {
        return openvdb::Vec3s(1, 0, std::numeric_limits<float>::quiet_NaN());
    });
    CHECK_THAT(VdbFile({broken}).failure(), Contains("'direction'") && Contains("(0, 0, 0)"));
    CHECK_THAT(VdbFile({openvdb::Vec3SGrid::create()}).failure(), Contains("field.vdb"));
    const TextFile text("x,y,z\n", "field.vdb");
    CHECK_THROWS_AS(readDirectionField(text.path()), InputError);
    CHECK_THROWS_AS(readDirectionField("/nowhere/field.vdb"), IoError);
}
