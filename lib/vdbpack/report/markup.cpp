#include "vdbpack/report/markup.h"

#include "vdbpack/io/text.h"
#include "vdbpack/report/report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

/// Arrays up to this long are written in one cell.
constexpr std::size_t kShortArray = 9;

/// Bytes of the character of UTF-8 at `at`; 0 if there is none, or one that XML excludes.
std::size_t characterLength(const std::string& text, std::size_t at) {
    const std::size_t length = utf8Bytes(std::string_view(text).substr(at));
    return length == 3 && text.compare(at, 3, "\xEF\xBF\xBE") >= 0 ? 0 : length;
}

std::string cell(const Json& value, const std::string& key) {
    if (value.is_null()) return "–";
    if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_unsigned() && key != "seed") return grouped(value.get<std::uint64_t>());
    if (value.is_number_integer()) return value.dump();
    if (value.is_number()) return figureText(value.get<double>());
    std::string text;
    const bool nested = value.is_array() && !value.empty() && value.front().is_structured();
    for (const auto& [name, part] : value.items()) {
        if (!text.empty()) text += nested ? "; " : ", ";
        text += (value.is_object() ? name + " " : "") + cell(part, name);
    }
    return text.empty() ? "none" : text;
}

bool isColumn(const Json& value) {
    return value.is_array() && value.size() > kShortArray &&
           std::none_of(value.begin(), value.end(),
                        [](const Json& v) { return v.is_structured(); });
}

bool isRecords(const Json& value) {
    return value.is_array() && !value.empty() &&
           std::all_of(value.begin(), value.end(), [](const Json& v) { return v.is_object(); });
}

std::string scrolled(const std::string& table) {
    return "<div class='scroll'>" + table + "</div>\n";
}

/// Columns of equal length as a table; the first column is the index of the row.
std::string columnTable(const std::vector<std::pair<std::string, Json>>& columns) {
    std::string head, body;
    for (const auto& [name, values] : columns) head += "<th>" + escaped(name) + "</th>";
    for (std::size_t i = 0; i < columns.front().second.size(); ++i) {
        body += fmt::format("<tr><th scope='row'>{}</th>", i);
        for (const auto& [name, values] : columns)
            body += "<td>" + escaped(cell(values[i], name)) + "</td>";
        body += "</tr>\n";
    }
    return scrolled("<table class='columns'><thead><tr><th>#</th>" + head +
                    "</tr></thead>\n<tbody>" + body + "</tbody></table>");
}

/// The parts of a section, collected from an object and the objects in it.
struct Parts {
    std::vector<std::pair<std::string, std::string>> rows;
    std::string tables;  ///< of columns and records
    std::string title;   ///< of the section, which needs no other heading

    void add(const Json& object, const std::string& path) {
        std::vector<std::pair<std::string, Json>> columns;
        for (const auto& [key, value] : object.items()) {
            const std::string name = path + key;
            if (value.is_object() && !value.empty()) {
                add(value, name + ".");
            } else if (isColumn(value)) {
                if (!columns.empty() && columns.front().second.size() != value.size())
                    flush(columns);
                columns.emplace_back(name, value);
            } else if (isRecords(value)) {
                addRecords(name, value);
            } else {
                rows.emplace_back(name, cell(value, key));
            }
        }
        flush(columns);
    }

private:
    void flush(std::vector<std::pair<std::string, Json>>& columns) {
        if (columns.empty()) return;
        std::string names;
        for (const auto& [name, values] : columns) names += (names.empty() ? "" : ", ") + name;
        tables += fmt::format("<details><summary>{}: {} rows</summary>\n{}</details>\n",
                              escaped(names), columns.front().second.size(), columnTable(columns));
        columns.clear();
    }

    void addRecords(const std::string& name, const Json& records) {
        std::vector<std::pair<std::string, Json>> columns;
        for (const auto& [key, value] : records.front().items()) {
            Json column = Json::array();
            for (const auto& record : records) column.push_back(record.value(key, Json()));
            columns.emplace_back(key, std::move(column));
        }
        if (columns.empty()) return;
        if (name != title) tables += "<h4>" + escaped(name) + "</h4>\n";
        tables += columnTable(columns);
    }
};

struct Heading {
    const char* key;
    const char* title;
    const char* planeTitle;
    const char* words;
};
constexpr Heading kHeadings[] = {
    {"domain", "Domain", "Domain",
     "Volume in mm³ and area of the wall in mm² (2D: area in mm² and length in mm), voxels in mm."},
    {"spheres", "Spheres", "Circles",
     "ks is the Kolmogorov-Smirnov distance between the radii and the requested distribution; "
     "wall: the same for spheres near the wall."},
    {"solidFraction", "Solid fraction", "Solid fraction",
     "Of the whole domain, and of the part deeper than three largest radii."},
    {"massOffset", "Center of mass", "Center of mass",
     "Of the spheres, from the centroid of the domain, mm; share: of the domain's longest side."},
    {"contacts", "Contacts", "Contacts",
     "Pairs whose gap is at most the tolerance times the smaller radius. The fabric tensor is the "
     "mean of n nᵀ over them; modulus: the largest Young's modulus of all directions divided by "
     "the smallest, an affine estimate from the contacts of spheres deeper than three radii."},
    {"overlap", "Overlap", "Overlap",
     "As a share of the smaller radius; pairs above 1e-6 are counted."},
    {"gap", "Gap", "Gap", "Requested and smallest distance between surfaces, mm."},
    {"protrusion", "Protrusion", "Protrusion",
     "Beyond the wall, as a share of the radius; spheres above 1e-6 are counted."},
    {"voids", "Voids", "Voids", "BV/TV is the solid fraction of the region deeper than the shell."},
    {"parts", "Parts", "Parts", "Volumes in mm³, areas in mm², densities in kg/m³."},
    {"interfaces", "Interfaces", "Interfaces",
     "Walls that two parts have in common: area in mm², bonds across them, per mm² as well; bulk: "
     "per mm² of a plane through the first and through the second part."},
    {"materials", "Materials", "Materials",
     "Least, middle and largest density in kg/m³, and Young's modulus in MPa."},
    {"device", "Device", "Device", "That moved spheres, with the seconds of its kernels."},
    {"seconds", "Seconds", "Seconds", "Wall-clock time."},
    {"profile", "Solid fraction by depth", "Solid fraction by depth",
     "In bins from the wall inwards, with standard errors."},
    {"localFraction", "Local solid fraction", "Local solid fraction",
     "Over cells of four mean diameters away from the wall."},
    {"pairCorrelation", "Pair correlation", "Pair correlation",
     "g(r) in bins from r = 0, about centers at the stated depth or deeper, with errors from the "
     "number of pairs."},
    {"regions", "Regions", "Regions", "The layer along the wall, and the part that it encloses."},
    {"morphometry", "Morphometry", "Morphometry", "Bone morphometry, with the usual symbols."},
};

std::string section(const std::string& key, const Json& object, bool plane) {
    std::string title = key, words;
    for (const Heading& heading : kHeadings)
        if (key == heading.key) {
            title = plane ? heading.planeTitle : heading.title;
            words = heading.words;
        }
    Parts parts;
    parts.title = key;
    if (object.is_object())
        parts.add(object, "");
    else if (!object.is_null())
        parts.add(Json{{key, object}}, "");
    std::string out = "<section>\n<h3>" + escaped(title) + "</h3>\n";
    if (!words.empty()) out += "<p class='words'>" + escaped(words) + "</p>\n";
    if (object.is_null()) out += "<p class='none'>Not measured.</p>\n";
    return out + pairTable(parts.rows) + parts.tables + "</section>\n";
}

}  // namespace

std::string escaped(const std::string& text) {
    std::string out;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = characterLength(text, at);
        const char c = text[at];
        const bool control = static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n';
        if (length == 0 || control)
            out += "\xEF\xBF\xBD";
        else if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if (c == '"')
            out += "&quot;";
        else if (c == '\'')
            out += "&#39;";
        else
            out += text.substr(at, length);
        at += std::max<std::size_t>(length, 1);
    }
    return out;
}

std::string base64(const std::string& bytes) {
    static const char* const letters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k)
            three = three << 8 | (k < left ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += k <= left ? letters[three >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

std::string figureText(double value) {
    return std::isfinite(value) ? fmt::format("{:.6g}", value) : "–";
}

std::string pairTable(const std::vector<std::pair<std::string, std::string>>& rows) {
    if (rows.empty()) return "";
    std::string body;
    for (const auto& [name, value] : rows)
        body +=
            "<tr><th scope='row'>" + escaped(name) + "</th><td>" + escaped(value) + "</td></tr>\n";
    return "<table><tbody>" + body + "</tbody></table>\n";
}

std::string figureTables(const nlohmann::ordered_json& figures, bool plane) {
    Json run = Json::object();
    std::string out;
    for (const auto& [key, value] : figures.items()) {
        const bool known =
            std::any_of(std::begin(kHeadings), std::end(kHeadings),
                        [&, &name = key](const Heading& h) { return name == h.key; });
        if (value.is_structured() || known)
            out += section(key, value, plane);
        else
            run[key] = value;
    }
    Parts parts;
    parts.add(run, "");
    return "<section>\n<h3>Run</h3>\n" + pairTable(parts.rows) + "</section>\n" + out;
}

}  // namespace vdbpack
