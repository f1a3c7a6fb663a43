// Requests for labels: an input is a line with the request, then a line "VALUE LAYER NAME" for each
// label of the image.
#include "fuzz_file.h"

#include "vdbpack/image/image_surface.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <algorithm>

using namespace vdbpack;

namespace {

std::vector<LabelCount> labelsOf(const std::vector<std::string>& lines) {
    std::vector<LabelCount> labels;
    for (std::size_t i = 1; i < lines.size(); ++i) {
        Words words(lines[i]);
        std::int64_t value = 0, layer = 0;
        if (!parseInteger(words.next(), value) || !parseInteger(words.next(), layer)) continue;
        LabelCount label;
        label.value = value;
        label.layer = static_cast<std::size_t>(layer & 7);
        label.name = std::string(trimmed(words.rest()));
        labels.push_back(label);
    }
    return labels;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto lines = splitAt(std::string_view(reinterpret_cast<const char*>(data), size), '\n');
    const auto labels = labelsOf(lines);
    const std::string request = lines.empty() ? "" : lines.front();
    try {
        const auto parts = parseLabels(request, labels, "i.nii");
        if (parts.empty()) fuzz::report("no part");
        if (request == "all" && parts.size() != labels.size())
            fuzz::report("not one part for each label");
        std::size_t used = 0;
        for (const LabelPart& part : parts) {
            if (part.labels.empty()) fuzz::report("a part without a label");
            used += part.labels.size();
            for (const LabelCount& label : part.labels)
                if (std::none_of(labels.begin(), labels.end(), [&](const LabelCount& known) {
                        return known.value == label.value && known.layer == label.layer;
                    }))
                    fuzz::report("a label that the image does not have");
        }
        if (used > labels.size()) fuzz::report("a label twice");
    } catch (const InputError& e) {
        if (!labels.empty()) fuzz::report(e.what());
    } catch (const ParameterError& e) {
        if (std::strstr(e.what(), "`label`") == nullptr)
            fuzz::report("the message does not name the parameter");
    }
    return 0;
}
