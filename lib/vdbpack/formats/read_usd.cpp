// Pixar's USD as text (.usda, .usd, within .usdz): the points of one Points prim, with its
// transformations and those of the prims around it.
//
// Layers, references, variants and splines are not composed: Pixar's usdcat --flatten does.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/usd_text.h"
#include "vdbpack/formats/zip_archive.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::size_t kDeepest = 200;  ///< prims within prims
constexpr std::string_view kBinary = "PXR-USDC";

/// Moves, turns and scales: p becomes p * turn + shift, as USD multiplies.
struct Affine {
    std::array<Vec<3>, 3> turn = {Vec<3>{{1, 0, 0}}, Vec<3>{{0, 1, 0}}, Vec<3>{{0, 0, 1}}};
    Vec<3> shift{{0, 0, 0}};

    Vec<3> turned(const Vec<3>& p) const {
        return turn[0] * p[0] + turn[1] * p[1] + turn[2] * p[2];
    }
    Vec<3> operator()(const Vec<3>& p) const { return turned(p) + shift; }
    /// This one, and then `next`.
    Affine then(const Affine& next) const {
        return {{next.turned(turn[0]), next.turned(turn[1]), next.turned(turn[2])}, next(shift)};
    }
};

/// About axis 0, 1 or 2, in degrees.
Affine rotation(std::size_t axis, double degrees) {
    const double angle = degrees * 3.14159265358979323846 / 180;
    Affine about;
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto iu = static_cast<int>(u), iv = static_cast<int>(v);
    about.turn[u][iu] = about.turn[v][iv] = std::cos(angle);
    about.turn[u][iv] = std::sin(angle);
    about.turn[v][iu] = -std::sin(angle);
    return about;
}

Affine orientation(double w, Vec<3> q) {
    const double size = std::sqrt(w * w + dot(q, q));
    w /= size;
    q = q * (1 / size);
    Affine a;
    for (int i = 0; i < 3; ++i) {
        Vec<3> e{{0, 0, 0}};
        e[i] = 1;
        a.turn[static_cast<std::size_t>(i)] = e + cross(q, cross(q, e) + e * w) * 2.0;
    }
    return a;
}

/// The other way. @return nothing where it flattens.
std::optional<Affine> inverse(const Affine& a) {
    const std::array<Vec<3>, 3> across = {cross(a.turn[1], a.turn[2]), cross(a.turn[2], a.turn[0]),
                                          cross(a.turn[0], a.turn[1])};
    const double volume = dot(a.turn[0], across[0]);
    if (volume == 0 || !std::isfinite(volume)) return std::nullopt;
    Affine back;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            back.turn[i][static_cast<int>(j)] = across[j][static_cast<int>(i)] / volume;
    back.shift = back.turned(a.shift) * -1.0;
    return back;
}

/// A named array of a prim.
struct Attribute {
    std::string name;       ///< as in the file
    std::string shown;      ///< its displayName; may be empty
    bool perPoint = false;  ///< whether its interpolation says so
    UsdArray values;
};

class Prim {
public:
    bool defined = false;  ///< rather than a class, or the change of a prim elsewhere
    std::string path;
    std::string type;
    std::vector<std::string> operations;  ///< xformOpOrder

    /// In the order of the file; of Points all, of others transformations.
    const std::vector<Attribute>& attributes() const { return attributes_; }
    const Attribute* find(const std::string& name) const {
        const auto at = places_.find(name);
        return at == places_.end() ? nullptr : &attributes_[at->second];
    }
    /// Replaces one of the same name: of a value and values by time, these come later.
    void add(Attribute attribute) {
        const auto [at, isNew] = places_.emplace(attribute.name, attributes_.size());
        if (isNew)
            attributes_.push_back(std::move(attribute));
        else
            attributes_[at->second] = std::move(attribute);
    }

private:
    std::vector<Attribute> attributes_;
    std::map<std::string, std::size_t> places_;
};

/// What the values of a type are; none: they are not read.
enum class ValueKind { none, whole, real, text };

ValueKind kindOf(std::string_view type) {
    if (endsWith(type, "[]")) type.remove_suffix(2);
    if (type == "string" || type == "token") return ValueKind::text;
    for (const char* whole : {"bool", "uchar", "int", "uint"})
        if (startsWith(type, whole)) return ValueKind::whole;
    for (const char* real : {"half", "float", "double", "point3", "normal3", "vector3", "color",
                             "texCoord", "quat", "timecode", "matrix4d"})
        if (startsWith(type, real)) return ValueKind::real;
    return ValueKind::none;
}

/// The transformation of one operation, such as "xformOp:rotateXYZ:name". @return nothing for one
/// that is not known or has other numbers than it needs.
std::optional<Affine> operationOf(std::string_view name, const std::vector<double>& v) {
    constexpr std::string_view kPrefix = "xformOp:";
    if (!startsWith(name, kPrefix)) return std::nullopt;
    name.remove_prefix(kPrefix.size());
    const auto kind = name.substr(0, name.find(':'));
    Affine a;
    if (kind == "translate" && v.size() == 3) {
        a.shift = {{v[0], v[1], v[2]}};
    } else if (kind == "scale" && v.size() == 3) {
        for (std::size_t d = 0; d < 3; ++d) a.turn[d] = a.turn[d] * v[d];
    } else if (kind == "orient" && v.size() == 4) {
        a = orientation(v[0], {{v[1], v[2], v[3]}});
    } else if (kind == "transform" && v.size() == 16) {
        for (std::size_t r = 0; r < 3; ++r) a.turn[r] = {{v[4 * r], v[4 * r + 1], v[4 * r + 2]}};
        a.shift = {{v[12], v[13], v[14]}};
    } else if (startsWith(kind, "rotate")) {
        // Axes by letters, one number each: those of rotateXYZ are in the order x, y, z.
        const auto axes = kind.substr(6);
        if (axes.empty() || axes.size() != v.size()) return std::nullopt;
        for (const char axis : axes) {
            const auto d = static_cast<std::size_t>(axis - 'X');
            if (axis < 'X' || axis > 'Z') return std::nullopt;
            a = a.then(rotation(d, v.size() == 1 ? v[0] : v[d]));
        }
    } else {
        return std::nullopt;
    }
    return a;
}

class UsdFile {
public:
    UsdFile(const std::string& path, std::string_view text, const PackReadOptions& options)
        : path_(path), options_(options), words_(text, path), unit_(options.unit) {}

    Pack<3> read() {
        if (words_.accept('(')) readMetadata();
        prims_.emplace_back();  // around all
        prims_.back().defined = true;
        while (!words_.atEnd()) readStatement();
        if (!found_) failMissing();
        return packOf(*found_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw InputError(path_ + ": " + what); }
    /// About the prim that is read.
    [[noreturn]] void failPrim(const Prim& prim, const std::string& what) const {
        fail(fmt::format("prim {}: {}", quotedExcerpt(prim.path), what));
    }

    [[noreturn]] void failMissing() const {
        if (!options_.gridName.empty())
            fail(fmt::format("has no Points prim {} with points; found: {}",
                             quotedExcerpt(options_.gridName), passed_.empty() ? "none" : passed_));
        fail(
            "has no Points prim with points. References and variants are not followed: "
            "usdcat --flatten puts them into one .usda");
    }

    std::string word() {
        const char c = words_.peek();
        if (c == '"' || c == '\'') return words_.quoted();
        const auto name = words_.name();
        if (name.empty()) words_.failWhere("a name is needed");
        return std::string(name);
    }

    /// Takes "key =", before which a type or an operation on a list may stand.
    /// @return nothing for a text that stands alone, which is a comment.
    std::optional<std::string> readKey() {
        const char first = words_.peek();
        std::string key = word();
        if ((first == '"' || first == '\'') && words_.peek() != '=') return std::nullopt;
        while (!words_.accept('=')) key = word();
        return key;
    }

    /// The entries up to a bracket: calls `take(key)` where the value of one comes.
    template <class Take>
    void readEntries(char close, const Take& take) {
        while (!words_.accept(close)) {
            if (words_.accept(';') || words_.accept(',')) continue;
            if (const auto key = readKey()) take(*key);
        }
    }

    void readMetadata() {
        readEntries(')', [this](const std::string& key) {
            if (key == "metersPerUnit")
                takeUnit(words_.number());
            else if (key == "customLayerData" && words_.accept('{'))
                readEntries('}', [this](const std::string& entry) {
                    if (entry == kCellKey)
                        cellText_ = words_.quoted();
                    else
                        words_.skipValue();
                });
            else
                words_.skipValue();
        });
    }

    void takeUnit(double meters) {
        for (const Unit unit :
             {Unit::meter, Unit::centimeter, Unit::millimeter, Unit::micrometer}) {
            if (!(std::abs(meters / metersPer(unit) - 1) < 1e-6)) continue;
            unit_ = unit;
            return;
        }
        words_.fail(
            fmt::format("metersPerUnit is {}; m, cm, mm and um are read, which are 1, 0.01, 0.001 "
                        "and 1e-06. Convert the stage to one of them",
                        meters));
    }

    /// A statement between the braces of a prim, or outside of all.
    void readStatement() {
        if (words_.accept(';')) return;
        std::string_view type, name = words_.name();
        if (name == "def" || name == "over" || name == "class") {
            readPrim(name == "def");
        } else if (name == "variantSet") {
            words_.quoted();
            words_.expect('=');
            words_.skipValue();
        } else {
            if (name.empty()) words_.failWhere("a prim or an attribute is needed");
            // Before the name: operations on lists, "custom", "uniform", "rel", a type.
            while (!words_.statementEnds() && words_.peek() != '=' && words_.peek() != '(') {
                type = std::exchange(name, words_.name());
                if (name.empty()) words_.failWhere("'=' and a value are needed");
            }
            readAttribute(type, name);
        }
    }

    void readAttribute(std::string_view type, std::string_view name) {
        Attribute attribute;
        attribute.name = name;
        const ValueKind kind = kindOf(type);
        const bool order = name == "xformOpOrder";
        const bool kept = kind != ValueKind::none &&
                          (order || startsWith(name, "xformOp:") || isWanted(prims_.back()));
        const bool given = words_.accept('=') && readValue(attribute, kind, kept);
        if (words_.accept('('))
            readEntries(')', [&](const std::string& key) {
                if (key == "interpolation") {
                    const std::string value = words_.quoted();
                    attribute.perPoint = value == "vertex" || value == "varying";
                } else if (key == "displayName") {
                    attribute.shown = words_.quoted();
                } else {
                    words_.skipValue();
                }
            });
        if (!given) return;
        if (order)
            prims_.back().operations = std::move(attribute.values.texts);
        else
            prims_.back().add(std::move(attribute));
    }

    /// The value of an attribute, of several by time the last. @return whether there is one to
    /// keep.
    bool readValue(Attribute& attribute, ValueKind kind, bool kept) {
        constexpr std::string_view kByTime = ".timeSamples";
        const bool byTime = endsWith(attribute.name, kByTime);
        if (byTime) attribute.name.resize(attribute.name.size() - kByTime.size());
        if (!kept || attribute.name.find('.') != std::string::npos) {  // .connect, .spline
            words_.skipValue();
            return false;
        }
        if (!byTime) return readArray(attribute.values, kind);
        words_.expect('{');
        std::optional<double> last;
        while (words_.peek() != '}') {
            const double time = words_.number();
            words_.expect(':');
            UsdArray values;
            if (readArray(values, kind) && !(last && *last > time)) {
                last = time;
                attribute.values = std::move(values);
            }
            if (!words_.accept(',')) break;
        }
        words_.expect('}');
        return last.has_value();
    }

    /// @return false for None.
    bool readArray(UsdArray& values, ValueKind kind) {
        if (words_.acceptNone()) return false;
        values = words_.array(kind == ValueKind::whole);
        const bool numbers = !values.reals.empty() || !values.wholes.empty();
        if (kind == ValueKind::text ? numbers : !values.texts.empty())
            words_.fail("the array before has texts for numbers, or numbers for texts; correct it");
        return true;
    }

    void readPrim(bool defined) {
        if (prims_.size() > kDeepest)
            words_.fail(fmt::format("prims are nested deeper than {}; flatten them", kDeepest));
        Prim prim;
        prim.defined = defined && prims_.back().defined;
        prim.type = words_.name();
        prim.path = prims_.back().path + "/" + words_.quoted();
        if (words_.accept('(')) readEntries(')', [this](const auto&) { words_.skipValue(); });
        words_.expect('{');
        prims_.push_back(std::move(prim));
        while (!words_.accept('}')) readStatement();
        prim = std::move(prims_.back());
        prims_.pop_back();
        const bool isIt = isWanted(prim) && prim.find("points") != nullptr;
        if (isIt || (found_ && prims_.size() < depth_)) {
            placeWithin(prim);
            depth_ = prims_.size();
        }
        if (isIt)
            found_ = std::move(prim);
        else if (prim.type == "Points" && passed_.size() < 400)
            passed_ += (passed_.empty() ? "" : ", ") + prim.path;
    }

    /// Whether its points are to be read: those of the first, or of that with the name asked for.
    bool isWanted(const Prim& prim) const {
        const std::string& name = options_.gridName;
        return !found_ && prim.defined && prim.type == "Points" &&
               (name.empty() || prim.path == name || endsWith(prim.path, "/" + name));
    }

    /// Applies the transformation of a prim, the one found or one around it.
    void placeWithin(const Prim& prim) {
        if (reset_) return;
        constexpr std::string_view kReset = "!resetXformStack!", kInvert = "!invert!";
        for (auto op = prim.operations.rbegin(); op != prim.operations.rend(); ++op) {
            if (*op == kReset) {
                reset_ = true;  // nothing around it counts
                continue;
            }
            const bool inverted = startsWith(*op, kInvert);
            const std::string name = inverted ? op->substr(kInvert.size()) : *op;
            const Attribute* attribute = prim.find(name);
            if (attribute == nullptr) continue;
            auto step = operationOf(name, attribute->values.reals);
            if (step && inverted) step = inverse(*step);
            if (!step)
                failPrim(prim, fmt::format("{} is no transformation that is read: translate, "
                                           "scale, rotateX to rotateZYX, orient or transform",
                                           quotedExcerpt(*op)));
            place_ = place_.then(*step);
        }
    }

    /// By what radii are multiplied.
    double scaleOf(const Prim& prim) const {
        const auto& t = place_.turn;
        const double square = dot(t[0], t[0]);
        for (std::size_t i = 0; i < 3; ++i) {
            const double off =
                std::max(std::abs(dot(t[i], t[i]) - square), std::abs(dot(t[i], t[(i + 1) % 3])));
            if (!(off <= 1e-6 * square))
                failPrim(prim,
                         "its transformation makes ellipsoids of spheres; scale all axes alike");
        }
        return std::sqrt(square);
    }

    /// What the values of an attribute are called in the pack; empty: they are left out.
    static std::string columnOf(const Prim& prim, const Attribute& attribute) {
        if (attribute.name == "ids") return "id";
        const auto isTaken = [&prim](const std::string& name) {
            const std::string low = lowered(name);
            return low == "x" || low == "y" || low == "z" || low == "radius" ||
                   (low == "id" && prim.find("ids") != nullptr);
        };
        constexpr std::string_view kPrimvar = "primvars:";
        const bool primvar = startsWith(attribute.name, kPrimvar);
        if (attribute.name == "points" || attribute.name == "widths" ||
            !(attribute.perPoint || attribute.name == "velocities" ||
              attribute.name == "accelerations"))
            return {};
        std::string name = primvar ? attribute.name.substr(kPrimvar.size()) : attribute.name;
        if (!attribute.shown.empty() && !isTaken(attribute.shown)) name = attribute.shown;
        return isTaken(name) ? std::string() : name;
    }

    struct Values {
        const Attribute* attribute;
        const std::vector<std::int64_t>* indices;  ///< null: one value a point

        std::size_t operator()(std::size_t i) const {
            return indices == nullptr ? i : static_cast<std::size_t>((*indices)[i]);
        }
    };

    /// The values of an attribute for `n` points, each its own or by their indices.
    Values valuesOf(const Prim& prim, const Attribute& attribute, std::size_t n) const {
        const Attribute* by = prim.find(attribute.name + ":indices");
        const std::size_t size = attribute.values.size();
        if (by == nullptr) {
            requireCount(prim, attribute, size, n);
            return {&attribute, nullptr};
        }
        requireCount(prim, *by, by->values.wholes.size(), n);
        for (const std::int64_t i : by->values.wholes)
            if (i < 0 || static_cast<std::uint64_t>(i) >= size)
                failPrim(prim, fmt::format("{} has an index {} for {} values; correct it",
                                           quotedExcerpt(by->name), i, size));
        return {&attribute, &by->values.wholes};
    }

    void requireCount(const Prim& prim, const Attribute& attribute, std::size_t count,
                      std::size_t n) const {
        if (count != n)
            failPrim(prim, fmt::format("{} has {} values for {} points; the file is damaged",
                                       quotedExcerpt(attribute.name), count, n));
    }

    Pack<3> packOf(const Prim& prim) {
        const Attribute& points = *prim.find("points");
        const Attribute* widths = prim.find("widths");
        const std::size_t n = points.values.size();
        if (points.values.reals.size() != 3 * n)
            failPrim(prim, "its points do not have three coordinates; correct them");
        if (widths == nullptr || (n > 0 && widths->values.size() == 0))
            failPrim(prim, "has no widths, which are the diameters of the points; write them");
        if (widths->values.reals.size() != widths->values.size())
            failPrim(prim, "its widths are not one number a point; correct them");
        const bool sameWidth = widths->values.size() == 1;
        if (!sameWidth) requireCount(prim, *widths, widths->values.size(), n);

        std::vector<std::string> names = {"x", "y", "z", "radius"};
        std::vector<Values> further;
        for (const Attribute& attribute : prim.attributes()) {
            const std::string name = columnOf(prim, attribute);
            if (name.empty()) continue;
            further.push_back(valuesOf(prim, attribute, n));
            const std::size_t components = attribute.values.components;
            for (std::size_t c = 0; c < components; ++c)
                names.push_back(components == 1 ? name : fmt::format("{}_{}", name, c));
        }
        PackBuilder builder(path_, names, unit_);
        std::size_t column = 4;
        for (const Values& values : further) {
            if (!values.attribute->values.texts.empty()) builder.makeText(column);
            column += values.attribute->values.components;
        }
        requireMemoryToRead(path_, builder.bytesOf(n), options_.memoryLimit);
        builder.reserve(n);
        const double half = scaleOf(prim) / 2;
        const auto& p = points.values.reals;
        for (std::size_t i = 0; i < n; ++i) {
            const auto where = [i] { return fmt::format("point {}", i); };
            builder.addRow();
            const Vec<3> center = place_({{p[3 * i], p[3 * i + 1], p[3 * i + 2]}});
            for (int d = 0; d < 3; ++d) builder.set(static_cast<std::size_t>(d), center[d]);
            builder.set(3, half * widths->values.reals[sameWidth ? 0 : i]);
            column = 4;
            for (const Values& values : further) {
                const UsdArray& array = values.attribute->values;
                const std::size_t row = values(i);
                for (std::size_t c = 0; c < array.components; ++c, ++column) {
                    const std::size_t k = row * array.components + c;
                    if (builder.isText(column))
                        builder.setText(column, array.texts[k]);
                    else if (!(array.whole ? builder.set(column, array.wholes[k])
                                           : builder.set(column, array.reals[k])))
                        builder.failCell(where(), column, "out of range");
                }
            }
            if (!builder.problem().empty()) builder.failRow(where());
        }
        Pack<3> pack = builder.finish();
        if (cellText_.empty()) return pack;
        const auto cell = parseCellText(cellText_, unit_);
        if (!cell)
            fail(fmt::format("{} is no periodic cell; remove {}", quotedExcerpt(cellText_),
                             kCellKey));
        pack.cell = *cell;
        return pack;
    }

    std::string path_;
    const PackReadOptions& options_;
    UsdWords words_;
    Unit unit_;
    std::string cellText_;
    std::vector<Prim> prims_;  ///< from the outermost to the one that is read
    std::optional<Prim> found_;
    std::size_t depth_ = 0;  ///< prims around the outermost one whose transformation `place_` has
    std::string passed_;     ///< paths of other Points
    Affine place_;
    bool reset_ = false;
};

/// @throws InputError for what is no text of USD.
Pack<3> readText(const std::string& path, std::string_view text, const PackReadOptions& options) {
    constexpr std::string_view kMagic = "#usda ";
    if (startsWith(text, kBinary))
        throw InputError(path +
                         ": is a binary USD file; usdcat -o FILE.usda converts it into one that is "
                         "read");
    if (!startsWith(text, kMagic))
        throw InputError(path + ": does not begin with " + std::string(kMagic) +
                         "1.0; a text file of USD is needed");
    // Numbers take at least as much in memory as in a text, some four times as much.
    requireMemoryToRead(path, 3 * static_cast<double>(text.size()), options.memoryLimit);
    return UsdFile(path, text, options).read();
}

}  // namespace

Pack<3> readUsd(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    file.skipByteOrderMark();
    return readText(path, file.peek(static_cast<std::size_t>(file.remaining())), options);
}

Pack<3> readUsdz(const std::string& path, const PackReadOptions& options) {
    ZipArchive archive(path);
    if (archive.members() == 0)
        throw InputError(path + ": is empty; the first file in a .usdz is a .usda, .usd or .usdc");
    // The first file is the one that a package stands for.
    const auto member = archive.member(0);
    requireMemoryToRead(path, static_cast<double>(member.size), options.memoryLimit);
    const std::string text = archive.content(member);
    return readText(path + ": " + printable(member.name), text, options);
}

}  // namespace vdbpack
