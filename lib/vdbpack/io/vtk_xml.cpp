#include "vdbpack/io/vtk_xml.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

namespace vdbpack {

namespace {

constexpr std::string_view kAppended = "<AppendedData";
constexpr std::int64_t kMostComponents = 16;
constexpr std::ptrdiff_t kMostTags = 1'000'000;

}  // namespace

VtkXml::VtkXml(const std::string& path, const std::string& type, double memoryLimit)
    : file_(path), type_(type) {
    readTags();
    root_ = document_.child("VTKFile");
    if (attribute(root_, "type") != type_)
        fail("is not the expected file: VTKFile of type " + type_ + " is needed");
    VtkEncoding encoding;
    encoding.swap = (attribute(root_, "byte_order") == "BigEndian") != hostIsBigEndian();
    encoding.wideHeader = attribute(root_, "header_type") == "UInt64";
    encoding.compressor = attribute(root_, "compressor");
    arrays_.emplace(file_, encoding, memoryLimit);
    takeAppended();
}

void VtkXml::fail(const std::string& what) const {
    throw InputError(file_.path() + ": " + what);
}

void VtkXml::failAtByte(std::ptrdiff_t byte, const std::string& what) const {
    fail(fmt::format("byte {}: {}; the file is damaged or not XML of VTK", byte, what));
}

void VtkXml::failAt(const pugi::xml_node& node, const std::string& what) const {
    failAtByte(node.offset_debug(), what);
}

/// Parses everything up to the appended bytes, which are not XML, or else the whole file.
void VtkXml::readTags() {
    constexpr std::uint64_t kChunk = 1 << 16;
    std::size_t searched = 0;
    while (xml_.size() < file_.size() && appended_ == 0) {
        const std::size_t before = xml_.size();
        const auto more = static_cast<std::size_t>(std::min<std::uint64_t>(
            std::max<std::uint64_t>(kChunk, before), file_.size() - before));
        xml_.resize(before + more);
        file_.readAt(before, xml_.data() + before, more);
        const auto found = xml_.find(kAppended, searched);
        if (found == std::string::npos) {
            searched = xml_.size() - std::min(xml_.size(), kAppended.size());
            continue;
        }
        searched = found;
        const auto marker = xml_.find('_', found + kAppended.size());
        if (marker == std::string::npos) continue;
        appended_ = marker + 1;
        xml_.resize(marker);
        xml_ += "</AppendedData></VTKFile>";
        requireEnd();
    }
    // Each takes some 60 bytes of memory.
    if (std::count_if(xml_.begin(), xml_.end(), [](char c) { return c == '<' || c == '='; }) >
        kMostTags)
        fail(fmt::format("has more than {} tags and attributes; save the data as one piece",
                         kMostTags));
    const auto parsed = document_.load_buffer_inplace(xml_.data(), xml_.size());
    if (parsed.status == pugi::status_out_of_memory) throw std::bad_alloc();
    if (!parsed) failAtByte(parsed.offset, parsed.description());
}

/// What follows the appended bytes is not parsed, but shows that none of them are missing.
void VtkXml::requireEnd() const {
    constexpr std::uint64_t kMostEnd = 4096;
    std::string end(static_cast<std::size_t>(std::min(kMostEnd, file_.size() - appended_)), '\0');
    file_.readAt(file_.size() - end.size(), end.data(), end.size());
    std::string_view rest = end;
    for (const std::string_view tag : {"</VTKFile", "</AppendedData"}) {
        const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
        const auto trim = [&] {
            while (!rest.empty() && blank(rest.back())) rest.remove_suffix(1);
        };
        trim();
        const bool closed = endsWith(rest, ">");
        if (closed) rest.remove_suffix(1);
        trim();
        if (!closed || !endsWith(rest, tag))
            fail(fmt::format("ends at byte {} without {}>; the file is cut short", file_.size(),
                             tag));
        rest.remove_suffix(tag.size());
    }
}

void VtkXml::takeAppended() {
    const pugi::xml_node section = root_.child("AppendedData");
    if (section.empty() != (appended_ == 0)) fail("the appended section is malformed");
    if (section.empty()) return;
    if (attribute(section, "encoding") == "base64")
        arrays_->appendBase64(appended_);
    else
        arrays_->appendRaw(appended_);
}

std::string_view VtkXml::attribute(const pugi::xml_node& node, const char* name) {
    return node.attribute(name).value();
}

bool VtkXml::isArray(const pugi::xml_node& node) {
    const std::string_view name = node.name();
    return name == "DataArray" || name == "Array";
}

std::uint64_t VtkXml::countOf(const pugi::xml_node& node, const char* name) const {
    std::int64_t count = 0;
    if (!parseNumber(attribute(node, name), count) || count < 0)
        failAt(node, fmt::format("a {} has no usable {}", lowered(node.name()), name));
    return static_cast<std::uint64_t>(count);
}

VtkArray VtkXml::described(const pugi::xml_node& node) const {
    VtkArray a;
    a.name = attribute(node, "Name");
    a.tag = node.parent().name();
    a.string = attribute(node, "type") == "String";
    if (!a.string) {
        const auto type = numberTypeNamed(lowered(attribute(node, "type")));
        if (!type) failAt(node, "an array has an unknown type");
        a.type = *type;
    }
    const auto components = attribute(node, "NumberOfComponents");
    std::int64_t count = 1;
    if (!components.empty() &&
        (!parseNumber(components, count) || count < 1 || count > kMostComponents))
        failAt(node, "an array has an unusable number of components");
    a.components = static_cast<std::uint64_t>(count);
    const auto format = attribute(node, "format");
    if (format == "appended") {
        a.format = VtkArray::Format::appended;
        a.offset = countOf(node, "offset");
    } else {
        if (format != "ascii" && !format.empty()) a.format = VtkArray::Format::inlineBase64;
        a.text = node.child_value();
    }
    return a;
}

}  // namespace vdbpack
