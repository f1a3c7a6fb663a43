// Checks that a page of HTML is well-formed XML.
#pragma once

#include <cctype>
#include <cstddef>
#include <string>
#include <vector>

namespace vdbpack::test {

/// Reads a page from the front.
class PageReader {
public:
    explicit PageReader(const std::string& page) : page_(page) {}

    /// The first error of the page, with the text that follows; empty if there is none.
    std::string flaw() {
        take("<!DOCTYPE html>");
        std::vector<std::string> open;
        bool rooted = false;
        while (at_ < page_.size()) {
            const char c = page_[at_];
            const std::string here = page_.substr(at_, 40);
            if (c == '&') {
                if (!entity()) return "no entity: " + here;
            } else if (c == '<' && !open.empty() && take("<![CDATA[")) {
                at_ = page_.find("]]>", at_);
                if (at_ == std::string::npos) return "CDATA without an end";
                at_ += 3;
            } else if (c == '<') {
                Tag tag;
                if (!readTag(tag)) return "no tag: " + here;
                if (tag.closes) {
                    if (open.empty() || open.back() != tag.name) return "closes nothing: " + here;
                    open.pop_back();
                } else if (!tag.empty) {
                    if (open.empty() && rooted) return "a second root: " + here;
                    rooted = true;
                    open.push_back(tag.name);
                }
            } else if (c == '>' && (open.empty() || open.back() != "style")) {
                return "a bare >: " + here;
            } else if (open.empty() && !std::isspace(static_cast<unsigned char>(c))) {
                return "text outside: " + here;
            } else {
                ++at_;
            }
        }
        return open.empty() ? "" : "never closed: " + open.back();
    }

private:
    struct Tag {
        std::string name;
        bool closes = false, empty = false;
    };

    bool take(const std::string& text) {
        if (page_.compare(at_, text.size(), text) != 0) return false;
        at_ += text.size();
        return true;
    }
    template <class Is>
    std::string takeAll(const Is& is) {
        const std::size_t start = at_;
        while (at_ < page_.size() && is(page_[at_])) ++at_;
        return page_.substr(start, at_ - start);
    }
    bool entity() {
        return take("&amp;") || take("&lt;") || take("&gt;") || take("&quot;") || take("&#39;");
    }
    std::size_t skipSpace() {
        return takeAll([](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; })
            .size();
    }
    /// The rest of an attribute's value, after its opening quote.
    bool readValue(char quote) {
        while (at_ < page_.size() && page_[at_] != quote) {
            if (page_[at_] == '<') return false;
            if (page_[at_] != '&')
                ++at_;
            else if (!entity())
                return false;
        }
        return at_++ < page_.size();
    }
    bool readTag(Tag& tag) {
        if (!take("<")) return false;
        tag.closes = take("/");
        tag.name = takeAll([](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); });
        if (tag.name.empty() || tag.name[0] <= '9') return false;
        for (;;) {
            const bool apart = skipSpace() > 0;
            if (take("/>")) return tag.empty = true;
            if (take(">")) return true;
            const auto isName = [](char c) {
                return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '-';
            };
            if (!apart || takeAll(isName).empty() || !take("=")) return false;
            if (!(take("'") ? readValue('\'') : take("\"") && readValue('"'))) return false;
        }
    }

    const std::string& page_;
    std::size_t at_ = 0;
};

/// The first error of a page, with the text that follows; empty if there is none. Accepts elements,
/// quoted attributes, a doctype and the five entities, but no comments and no CDATA.
inline std::string flawIn(const std::string& page) {
    return PageReader(page).flaw();
}

}  // namespace vdbpack::test
