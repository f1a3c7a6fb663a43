#include "vdbpack/voids/orientation.h"

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"
#include "vdbpack/voids/direction_field.h"
#include "vdbpack/voids/field_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// The parts of a text between separators.
std::vector<std::string> parts(const std::string& text, char separator) {
    std::vector<std::string> found;
    for (std::size_t at = 0;;) {
        const std::size_t end = std::min(text.find(separator, at), text.size());
        found.emplace_back(trimmed(std::string_view(text).substr(at, end - at)));
        if (end == text.size()) return found;
        at = end + 1;
    }
}

const char* formOf(int dim) {
    return dim == 3 ? "tz=SPEC;tx=SPEC" : "phi=SPEC";
}

[[noreturn]] void failAngles(const std::string& angles, const std::string& what,
                             const std::string& forms) {
    throw ParameterError(
        fmt::format("`orientation.angles` '{}': {}; write {} or isotropic", angles, what, forms));
}

/// Directions about the first axis of the frame: z in space, x in the plane.
template <int Dim>
class Scatter {
public:
    explicit Scatter(const std::optional<VoidAngles>& given) {
        if (!given) return;
        if (Dim == 3 ? given->phi.has_value() : given->tz || given->tx)
            failAngles(given->text,
                       fmt::format("has an angle of the {}", Dim == 3 ? "plane" : "space"),
                       formOf(Dim));
        isotropic_ = given->isotropic;
        const AngleDistribution none;
        thetaZ_ = given->tz.value_or(none);
        thetaX_ = given->tx.value_or(none);
        phi_ = given->phi.value_or(none);
    }

    bool isotropic() const { return isotropic_; }

    Vec<Dim> draw(RandomStream& random) const {
        if constexpr (Dim == 3) {
            const double first = random.uniform(), second = random.uniform();
            if (!isotropic_) return axisOf(thetaZ_.quantile(first), thetaX_.quantile(second));
            // The area of a slice of a sphere is proportional to its height (Archimedes).
            const double z = 2 * first - 1, across = std::sqrt(1 - z * z);
            const double turn = 2 * kPi * second;
            return {{across * std::cos(turn), across * std::sin(turn), z}};
        } else {
            const double share = random.uniform();
            return axisOf(isotropic_ ? kPi * share : phi_.quantile(share));
        }
    }

private:
    bool isotropic_ = false;
    AngleDistribution thetaZ_, thetaX_, phi_;
};

/// `v` after the shortest rotation that maps z to `onto` or -`onto`, whichever points upward.
Vec<3> carried(const Vec<3>& v, const Vec<3>& onto) {
    const Vec<3> d = onto[2] < 0 ? -onto : onto;
    const Vec<3> k{{-d[1], d[0], 0}};  // z x d
    return normalized(v * d[2] + cross(k, v) + k * (dot(k, v) / (1 + d[2])));
}
/// `v` after the rotation that maps x to `onto`.
Vec<2> carried(const Vec<2>& v, const Vec<2>& onto) {
    return normalized(Vec<2>{{onto[0] * v[0] - onto[1] * v[1], onto[1] * v[0] + onto[0] * v[1]}});
}

template <int Dim>
class Free : public Orientation<Dim> {
public:
    explicit Free(Scatter<Dim> scatter) : scatter_(std::move(scatter)) {}
    Vec<Dim> axis(const Vec<Dim>&, RandomStream& random) const override {
        return scatter_.draw(random);
    }

private:
    Scatter<Dim> scatter_;
};

template <int Dim>
class AboutAxis : public Orientation<Dim> {
public:
    AboutAxis(Scatter<Dim> scatter, const Vec<Dim>& axis)
        : scatter_(std::move(scatter)), axis_(axis) {}
    Vec<Dim> axis(const Vec<Dim>&, RandomStream& random) const override {
        return carried(scatter_.draw(random), axis_);
    }

private:
    Scatter<Dim> scatter_;
    Vec<Dim> axis_;
};

template <int Dim>
class AboutField : public Orientation<Dim> {
public:
    AboutField(Scatter<Dim> scatter, std::shared_ptr<const DirectionField> field,
               double sliceHeight)
        : scatter_(std::move(scatter)), field_(std::move(field)), sliceHeight_(sliceHeight) {}

    Vec<Dim> axis(const Vec<Dim>& at, RandomStream& random) const override {
        const Vec<Dim> turned = scatter_.draw(random);
        if constexpr (Dim == 3) {
            return carried(turned, field_->at(at));
        } else {
            const Vec<3> u = field_->at({{at[0], at[1], sliceHeight_}});
            const Vec<2> inPlane{{u[0], u[1]}};
            // A shorter projection is only rounding.
            if (!(length(inPlane) > 1e-6)) return turned;
            return carried(turned, normalized(inPlane));
        }
    }

private:
    Scatter<Dim> scatter_;
    std::shared_ptr<const DirectionField> field_;
    double sliceHeight_;
};

[[noreturn]] void failAxis(const std::string& text, const std::string& what) {
    throw ParameterError(fmt::format(
        "`orientation.axis` '{}': {}; write X,Y,Z (in a plane also X,Y) with finite numbers that "
        "are not all zero, or long",
        text, what));
}

}  // namespace

VoidAngles VoidAngles::parse(const std::string& text) {
    VoidAngles angles;
    angles.text = text;
    angles.isotropic = trimmed(text) == "isotropic";
    if (angles.isotropic) return angles;
    const auto fail = [&](const std::string& what) {
        failAngles(text, what, fmt::format("{} (in a plane {})", formOf(3), formOf(2)));
    };
    for (const auto& part : parts(text, ';')) {
        const auto equals = part.find('=');
        const std::string name(trimmed(std::string_view(part).substr(0, equals)));
        std::optional<AngleDistribution>* const angle = name == "tz"    ? &angles.tz
                                                        : name == "tx"  ? &angles.tx
                                                        : name == "phi" ? &angles.phi
                                                                        : nullptr;
        if (angle == nullptr || equals == std::string::npos)
            fail(fmt::format("'{}' is not one of the angles", part));
        if (*angle) fail(fmt::format("angle '{}' is given twice", name));
        *angle = AngleDistribution::parse(part.substr(equals + 1));
    }
    return angles;
}

VoidAxis::VoidAxis(const Vec<3>& along)
    : text(fmt::format("{:.6g},{:.6g},{:.6g}", along[0], along[1], along[2])), direction(along) {}

VoidAxis VoidAxis::parse(const std::string& text) {
    if (text == "long") {
        VoidAxis axis({});
        axis.text = text;
        axis.isLong = true;
        return axis;
    }
    const auto numbers = parts(text, ',');
    if (numbers.size() != 3 && numbers.size() != 2)
        failAxis(text, fmt::format("has {} components", numbers.size()));
    VoidAxis axis({});
    axis.text = text;
    axis.components = static_cast<int>(numbers.size());
    for (std::size_t d = 0; d < numbers.size(); ++d)
        if (!parseNumber(numbers[d], axis.direction.c[d]) || !std::isfinite(axis.direction.c[d]))
            failAxis(text, fmt::format("'{}' is not a finite number", numbers[d]));
    return axis;
}

template <int Dim>
Vec<Dim> directionOf(const VoidAxis& axis) {
    if (axis.components < Dim) failAxis(axis.text, "has 2 components");
    double most = 0;
    for (const double component : axis.direction.c) most = std::max(most, std::fabs(component));
    Vec<Dim> result;
    for (int d = 0; d < Dim; ++d) result[d] = most > 0 ? axis.direction[d] / most : 0;
    if (!(length(result) > 1e-6))
        failAxis(axis.text, Dim == 3 ? "has no direction" : "has no direction within the plane");
    return normalized(result);
}

template <int Dim>
std::shared_ptr<const Orientation<Dim>> makeOrientation(const OrientationRecipe& recipe,
                                                        const Box<Dim>& bounds,
                                                        double sliceHeight) {
    const bool fixed = recipe.axis.has_value(), varying = !recipe.field.empty();
    if (fixed && varying)
        throw ParameterError(
            fmt::format("`orientation.axis` '{}' and `orientation.field` '{}' both define the "
                        "direction; leave one "
                        "of them out",
                        recipe.axis->text, recipe.field));
    Scatter<Dim> scatter(recipe.angles);
    if (scatter.isotropic() && (fixed || varying))
        throw ParameterError(fmt::format(
            "`orientation.angles` 'isotropic' ignores `orientation.{}` '{}'; write the "
            "scatter about "
            "it as {}, or leave one of them out",
            fixed ? "axis" : "field", fixed ? recipe.axis->text : recipe.field, formOf(Dim)));
    if (fixed)
        return std::make_shared<AboutAxis<Dim>>(std::move(scatter), directionOf<Dim>(*recipe.axis));
    if (!varying) return std::make_shared<Free<Dim>>(std::move(scatter));
    auto field = readDirectionField(recipe.field);
    requireCovered(recipe.field + ": the direction field", field->bounds(), bounds, sliceHeight);
    return std::make_shared<AboutField<Dim>>(std::move(scatter), std::move(field), sliceHeight);
}

template Vec<2> directionOf(const VoidAxis&);
template Vec<3> directionOf(const VoidAxis&);
template std::shared_ptr<const Orientation<2>> makeOrientation<2>(const OrientationRecipe&,
                                                                  const Box<2>&, double);
template std::shared_ptr<const Orientation<3>> makeOrientation<3>(const OrientationRecipe&,
                                                                  const Box<3>&, double);

}  // namespace vdbpack
