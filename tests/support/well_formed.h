// Whether text is well-formed XML, as far as pages of HTML go.
#pragma once

#include <cctype>
#include <cstddef>
#include <regex>
#include <string>
#include <vector>

namespace vdbpack::test {

/// What is wrong with a page, with what comes there; empty if nothing is. Knows elements, quoted
/// attributes, a doctype and the five entities; no comments, no CDATA.
inline std::string flawIn(const std::string& page) {
    static const std::regex kTag(
        R"(^<(/?)([a-z][a-z0-9]*)((?:\s+[A-Za-z-]+=(?:'[^'<]*'|"[^"<]*"))*)\s*(/?)>)");
    static const std::regex kEntity(R"(^&(?:amp|lt|gt|quot|#39);)");
    const std::string doctype = "<!DOCTYPE html>";
    std::vector<std::string> open;
    std::size_t at = page.rfind(doctype, 0) == 0 ? doctype.size() : 0;
    bool rooted = false;
    while (at < page.size()) {
        const char c = page[at];
        const std::string here =
            c == '<' ? page.substr(at, page.find('>', at) - at + 1) : page.substr(at, 40);
        std::smatch match;
        if (c == '&') {
            if (!std::regex_search(here, match, kEntity)) return "no entity: " + here;
            at += static_cast<std::size_t>(match.length());
        } else if (c == '<') {
            if (!std::regex_search(here, match, kTag)) return "no tag: " + here;
            at += static_cast<std::size_t>(match.length());
            const std::string attributes = match[3];
            for (std::size_t i = 0; (i = attributes.find('&', i)) != std::string::npos; ++i)
                if (!std::regex_search(attributes.begin() + static_cast<long>(i), attributes.end(),
                                       kEntity))
                    return "no entity: " + here;
            if (match[1].length() > 0) {
                if (open.empty() || open.back() != match[2]) return "closes nothing: " + here;
                open.pop_back();
            } else if (match[4].length() == 0) {
                if (open.empty() && rooted) return "a second root: " + here;
                rooted = true;
                open.push_back(match[2]);
            }
        } else if (c == '>' && (open.empty() || open.back() != "style")) {
            return "a bare >: " + here;
        } else if (open.empty() && !std::isspace(static_cast<unsigned char>(c))) {
            return "text outside: " + here;
        } else {
            ++at;
        }
    }
    return open.empty() ? "" : "never closed: " + open.back();
}

}  // namespace vdbpack::test
