#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <Eigen/Core>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// The residual, as a share of the load, at which the energy is known to about its square: at 1e-3
/// it was within 2e-6 in a box of 8,559 spheres.
constexpr double kResidual = 2e-4;
constexpr int kMostIterations = 20000;
/// Loads below this share of the forces in the bonds are rounding: the forces are in balance.
constexpr double kBalanced = 1e-6;
/// Share of a diagonal that is added to blocks without an inverse, of spheres that turn freely.
constexpr double kFree = 1e-6;

/// A bond as one of its spheres has it.
struct HalfBond {
    std::uint32_t other;
    float x, y, z;   ///< its direction, towards the other sphere
    float own, arm;  ///< the arms of this sphere, and of the other
    float normal, tangential, bending, torsion;
};

/// Displacement and rotation, or force and moment, of a sphere.
struct Motion {
    Vec<3> move{}, turn{};
};

Motion motionIn(const double* values) {
    return {{{values[0], values[1], values[2]}}, {{values[3], values[4], values[5]}}};
}

/// What a bond does to its sphere when its ends are `apart` and turned by `turn`.
Motion pullOf(const HalfBond& h, const Vec<3>& apart, const Vec<3>& turn) {
    const Vec<3> n{{h.x, h.y, h.z}};
    const double normal = h.normal, tangential = h.tangential, bending = h.bending;
    const Vec<3> force = apart * tangential + n * ((normal - tangential) * dot(apart, n));
    const Vec<3> moment = turn * bending + n * ((h.torsion - bending) * dot(turn, n));
    return {force, cross(n, force) * static_cast<double>(h.own) + moment};
}

Motion pullOf(const HalfBond& h, const Motion& own, const Motion& other) {
    const Vec<3> n{{h.x, h.y, h.z}};
    const Vec<3> arms =
        own.turn * static_cast<double>(h.own) + other.turn * static_cast<double>(h.arm);
    return pullOf(h, other.move - own.move - cross(arms, n), other.turn - own.turn);
}

/// One of six strains, by Voigt's order.
Vec<3> strained(std::size_t load, const Vec<3>& x) {
    if (load < 3) {
        Vec<3> u{};
        u.c[load] = x.c[load];
        return u;
    }
    const std::size_t p = load == 3 ? 1 : 0, q = load == 5 ? 1 : 2;
    Vec<3> u{};
    u.c[p] = 0.5 * x.c[q];
    u.c[q] = 0.5 * x.c[p];
    return u;
}

}  // namespace

class BondOperator;

}  // namespace vdbpack

template <>
struct Eigen::internal::traits<vdbpack::BondOperator>
    : Eigen::internal::traits<Eigen::SparseMatrix<double>> {};

namespace vdbpack {

/// The forces of all bonds on free spheres: an operator without a matrix.
class BondOperator : public Eigen::EigenBase<BondOperator> {
public:
    using Scalar = double;
    using RealScalar = double;
    using StorageIndex = int;
    enum {
        ColsAtCompileTime = Eigen::Dynamic,
        MaxColsAtCompileTime = Eigen::Dynamic,
        IsRowMajor = false
    };

    BondOperator(const BondedBody& body, const Callbacks& callbacks);
    Eigen::Index rows() const { return 6 * static_cast<Eigen::Index>(isFree_.size()); }
    Eigen::Index cols() const { return rows(); }
    template <class Right>
    Eigen::Product<BondOperator, Right, Eigen::AliasFreeProduct> operator*(
        const Eigen::MatrixBase<Right>& x) const {
        return {*this, x.derived()};
    }

    /// Minus the forces and moments on free spheres that move so.
    Eigen::VectorXd forces(const Eigen::VectorXd& motion) const {
        callbacks_.stopIfCancelled();
        return minusSum([&](std::size_t i, const HalfBond& h) {
            return pullOf(h, motionIn(&motion[at(i)]), motionIn(&motion[at(h.other)]));
        });
    }
    /// The forces and moments on free spheres where all are strained alike.
    Eigen::VectorXd load(std::size_t strain) const {
        return -minusSum([&](std::size_t, const HalfBond& h) {
            const Vec<3> branch =
                Vec<3>{{h.x, h.y, h.z}} * (static_cast<double>(h.own) + static_cast<double>(h.arm));
            return pullOf(h, strained(strain, branch), {});
        });
    }
    /// The stiffness of each sphere where all others stand still.
    Eigen::Matrix<double, 6, 6> own(std::size_t i) const;
    std::size_t spheres() const { return isFree_.size(); }
    bool isFree(std::size_t i) const { return isFree_[i] != 0; }

private:
    static Eigen::Index at(std::size_t i) { return 6 * static_cast<Eigen::Index>(i); }
    template <class Pull>
    Eigen::VectorXd minusSum(const Pull& pull) const {
        Eigen::VectorXd sum(rows());
        parallelFor(std::size_t(0), isFree_.size(), [&](std::size_t i) {
            Motion all;
            if (isFree_[i])
                for (std::size_t k = ends_[i]; k < ends_[i + 1]; ++k) {
                    const Motion one = pull(i, halves_[k]);
                    all.move += one.move;
                    all.turn += one.turn;
                }
            for (int d = 0; d < 3; ++d) {
                sum[at(i) + d] = -all.move[d];
                sum[at(i) + 3 + d] = -all.turn[d];
            }
        });
        return sum;
    }

    const Callbacks& callbacks_;
    std::vector<HalfBond> halves_;   ///< by sphere
    std::vector<std::size_t> ends_;  ///< of each sphere's, with a 0 before
    std::vector<std::uint8_t> isFree_;
};

}  // namespace vdbpack

// How Eigen's solvers take an operator without a matrix.
namespace Eigen::internal {

template <class Right>
struct generic_product_impl<vdbpack::BondOperator, Right, SparseShape, DenseShape, GemvProduct>
    : generic_product_impl_base<vdbpack::BondOperator, Right,
                                generic_product_impl<vdbpack::BondOperator, Right>> {
    using Scalar = double;
    template <class Sum>
    static void scaleAndAddTo(Sum& sum, const vdbpack::BondOperator& bonds, const Right& motion,
                              double factor) {
        sum += factor * bonds.forces(motion);
    }
};

}  // namespace Eigen::internal

namespace vdbpack {

BondOperator::BondOperator(const BondedBody& body, const Callbacks& callbacks)
    : callbacks_(callbacks) {
    const std::size_t n = body.pack->spheres.size();
    ends_.assign(n + 1, 0);
    for (const Bond& b : *body.bonds) ++ends_[b.i + 1], ++ends_[b.j + 1];
    isFree_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        isFree_[i] = ends_[i + 1] > 0 && (body.boundary.empty() || body.boundary[i] == 0);
        ends_[i + 1] += ends_[i];
    }
    halves_.resize(ends_[n]);
    std::vector<std::size_t> next(ends_.begin(), ends_.end() - 1);
    for (const Bond& b : *body.bonds) {
        HalfBond h{b.j,
                   static_cast<float>(b.direction[0]),
                   static_cast<float>(b.direction[1]),
                   static_cast<float>(b.direction[2]),
                   static_cast<float>(b.armI),
                   static_cast<float>(b.armJ),
                   static_cast<float>(b.normal),
                   static_cast<float>(b.tangential),
                   static_cast<float>(b.bending),
                   static_cast<float>(b.torsion)};
        halves_[next[b.i]++] = h;
        h.other = b.i;
        h.x = -h.x, h.y = -h.y, h.z = -h.z;
        std::swap(h.own, h.arm);
        halves_[next[b.j]++] = h;
    }
}

Eigen::Matrix<double, 6, 6> BondOperator::own(std::size_t i) const {
    Eigen::Matrix<double, 6, 6> block = Eigen::Matrix<double, 6, 6>::Zero();
    for (std::size_t k = ends_[i]; k < ends_[i + 1]; ++k)
        for (int column = 0; column < 6; ++column) {
            std::array<double, 6> unit{};
            unit[static_cast<std::size_t>(column)] = 1;
            const Motion pull = pullOf(halves_[k], motionIn(unit.data()), {});
            for (int d = 0; d < 3; ++d) {
                block(d, column) -= pull.move[d];
                block(3 + d, column) -= pull.turn[d];
            }
        }
    return block;
}

namespace {

/// The inverse of each sphere's own stiffness.
class OwnStiffness {
public:
    OwnStiffness() = default;
    template <class Any>
    OwnStiffness& analyzePattern(const Any&) {
        return *this;
    }
    template <class Any>
    OwnStiffness& factorize(const Any&) {
        return *this;
    }
    OwnStiffness& compute(const BondOperator& bonds) {
        inverses_.resize(bonds.spheres());
        parallelFor(std::size_t(0), bonds.spheres(), [&](std::size_t i) {
            auto block = bonds.own(i);
            for (const int half : {0, 3}) {
                const double free = kFree * block.diagonal().segment<3>(half).sum();
                block.diagonal().segment<3>(half).array() += free > 0 ? free : 1;
            }
            inverses_[i] = block.inverse().cast<float>();
        });
        return *this;
    }
    Eigen::VectorXd solve(const Eigen::VectorXd& force) const {
        Eigen::VectorXd motion(force.size());
        parallelFor(std::size_t(0), inverses_.size(), [&](std::size_t i) {
            const auto at = 6 * static_cast<Eigen::Index>(i);
            motion.segment<6>(at) = inverses_[i].cast<double>() * force.segment<6>(at);
        });
        return motion;
    }
    static Eigen::ComputationInfo info() { return Eigen::Success; }

private:
    std::vector<Eigen::Matrix<float, 6, 6>> inverses_;
};

void requireBody(const BondedBody& body) {
    const std::size_t n = body.pack->spheres.size();
    if (!(body.volume > 0))
        throw ParameterError(
            fmt::format("stiffness: volume {} mm³; give that of the domain", body.volume));
    if (!body.boundary.empty() && body.boundary.size() != n)
        throw ParameterError(fmt::format("stiffness: {} marks of the boundary for {} spheres",
                                         body.boundary.size(), n));
    if (body.bonds->empty())
        throw ParameterError("stiffness: no two spheres are bonded; set a larger tolerance");
    const PeriodicCell<3>& cell = body.pack->cell;
    const bool held = std::any_of(body.boundary.begin(), body.boundary.end(),
                                  [](std::uint8_t mark) { return mark != 0; });
    if (!held && !(cell.isAlong(0) && cell.isAlong(1) && cell.isAlong(2)))
        throw ParameterError(
            "stiffness: no sphere is at the boundary, which holds the body; give the domain of "
            "the pack, or a thicker boundary");
}

/// The forces that a strain without relaxation makes in the bonds: their root sum of squares, N.
double affineForce(const std::vector<Bond>& bonds, std::size_t strain) {
    double squares = 0;
    for (const Bond& bond : bonds) {
        const Vec<3> u = strained(strain, bond.direction * bond.length);
        const Vec<3> force =
            u * bond.tangential +
            bond.direction * ((bond.normal - bond.tangential) * dot(u, bond.direction));
        squares += dot(force, force);
    }
    return std::sqrt(squares);
}

/// Energy that two strains without relaxation have in common, mJ (N mm).
double affineEnergy(const std::vector<Bond>& bonds, std::size_t a, std::size_t b) {
    double energy = 0;
    for (const Bond& bond : bonds) {
        const Vec<3> n = bond.direction, branch = n * bond.length;
        const Vec<3> u = strained(a, branch), v = strained(b, branch);
        energy +=
            bond.tangential * dot(u, v) + (bond.normal - bond.tangential) * dot(u, n) * dot(v, n);
    }
    return energy;
}

using Solver = Eigen::ConjugateGradient<BondOperator, Eigen::Lower | Eigen::Upper, OwnStiffness>;

void prepare(Solver& solver, const BondOperator& bonds) {
    solver.setMaxIterations(kMostIterations);
    solver.compute(bonds);
}

/// How free spheres move by `force` on them. @param rounding  of the forces, their norm.
Eigen::VectorXd motionBy(const Eigen::VectorXd& force, double rounding, Solver& solver) {
    if (force.norm() <= rounding) return Eigen::VectorXd::Zero(force.size());
    solver.setTolerance(std::max(kResidual, rounding / force.norm()));
    Eigen::VectorXd motion = solver.solve(force);
    if (solver.info() != Eigen::Success)
        throw ResourceError(
            fmt::format("stiffness: the solver has a residual of {:.2g} after {} iterations; bond "
                        "more spheres, by a larger tolerance",
                        solver.error(), solver.iterations()));
    return motion;
}

}  // namespace

double energyOf(const BondedBody& body, const std::vector<Vec<3>>& moves,
                const Callbacks& callbacks) {
    requireBody(body);
    const std::size_t n = body.pack->spheres.size();
    if (moves.size() != n || body.boundary.size() != n)
        throw ParameterError(
            fmt::format("stiffness: {} moves and {} marks of the boundary for {} "
                        "spheres",
                        moves.size(), body.boundary.size(), n));
    const BondOperator bonds(body, callbacks);
    Solver solver;
    prepare(solver, bonds);
    Eigen::VectorXd motion = Eigen::VectorXd::Zero(bonds.rows());
    for (std::size_t i = 0; i < n; ++i)
        for (int d = 0; body.boundary[i] && d < 3; ++d)
            motion[6 * static_cast<Eigen::Index>(i) + d] = moves[i][d];
    const Eigen::VectorXd force = -bonds.forces(motion);
    motion += motionBy(force, kBalanced * kResidual * force.norm(), solver);
    double twice = 0;
    for (const Bond& b : *body.bonds) {
        const Motion i = motionIn(&motion[6 * static_cast<Eigen::Index>(b.i)]);
        const Motion j = motionIn(&motion[6 * static_cast<Eigen::Index>(b.j)]);
        const Vec<3> turn = j.turn - i.turn;
        const Vec<3> apart =
            j.move - i.move - cross(i.turn * b.armI + j.turn * b.armJ, b.direction);
        const double along = dot(apart, b.direction), twist = dot(turn, b.direction);
        twice += b.normal * along * along + b.torsion * twist * twist +
                 b.tangential * (dot(apart, apart) - along * along) +
                 b.bending * (dot(turn, turn) - twist * twist);
    }
    return 0.5 * twice;
}

ApparentStiffness apparentStiffness(const BondedBody& body, const Callbacks& callbacks) {
    requireBody(body);
    const BondOperator bonds(body, callbacks);
    Solver solver;
    prepare(solver, bonds);
    ApparentStiffness result;
    for (std::size_t i = 0; i < bonds.spheres(); ++i) result.free += bonds.isFree(i);
    std::array<Eigen::VectorXd, 6> motions;
    for (std::size_t load = 0; load < 6; ++load) {
        callbacks.report("stiffness", static_cast<double>(load) / 6, 6);
        const Eigen::VectorXd force = bonds.load(load);
        const double rounding = kBalanced * affineForce(*body.bonds, load);
        motions[load] = motionBy(force, rounding, solver);
        if (force.norm() <= rounding) continue;
        result.iterations = std::max(result.iterations, static_cast<int>(solver.iterations()));
        result.residual = std::max(result.residual, solver.error());
    }
    for (std::size_t a = 0; a < 6; ++a) {
        // Both errors are of the second order: the energy of the two solutions, not of the loads.
        const Eigen::VectorXd force = bonds.load(a);
        const Eigen::VectorXd rest = force - bonds.forces(motions[a]);
        for (std::size_t b = 0; b < 6; ++b)
            result.stiffness[a].c[b] = (affineEnergy(*body.bonds, a, b) -
                                        motions[a].dot(bonds.load(b)) - motions[b].dot(rest)) /
                                       body.volume;
    }
    return result;
}

}  // namespace vdbpack
