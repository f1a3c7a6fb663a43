#include "vdbpack/formats/usd_text.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

bool isOfName(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == ':' || c == '.' || static_cast<unsigned char>(c) > 0x7f;
}

bool isOfNumber(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
           c == '+' || c == '-';
}

int hexDigit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

}  // namespace

void UsdWords::fail(const std::string& what) const {
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size()));
    throw InputError(
        fmt::format("{}: line {}: {}", file_, 1 + std::count(text_.begin(), end, '\n'), what));
}

void UsdWords::failWhere(const std::string& what) const {
    const auto end = std::min(text_.find('\n', at_), text_.size());
    fail(fmt::format("{} where {}; the file is damaged or cut short",
                     at_ < text_.size() ? quotedExcerpt(text_.substr(at_, end - at_)) + " comes"
                                        : "the file ends",
                     what));
}

void UsdWords::skipBlanks() {
    while (at_ < text_.size()) {
        const char c = text_[at_];
        if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
            ++at_;
        } else if (c == '#' || comes("//")) {
            at_ = std::min(text_.find('\n', at_), text_.size());
        } else if (comes("/*")) {
            const auto end = text_.find("*/", at_ + 2);
            if (end == std::string_view::npos) fail("a comment has no end; the file is cut short");
            at_ = end + 2;
        } else {
            return;
        }
    }
}

bool UsdWords::atEnd() {
    skipBlanks();
    return at_ >= text_.size();
}

bool UsdWords::statementEnds() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    return at_ >= text_.size() ||
           std::string_view("\r\n;#}").find(text_[at_]) != std::string_view::npos;
}

char UsdWords::peek() {
    return atEnd() ? '\0' : text_[at_];
}

bool UsdWords::accept(char c) {
    if (peek() != c || at_ >= text_.size()) return false;
    ++at_;
    return true;
}

void UsdWords::expect(char c) {
    if (!accept(c)) failWhere(fmt::format("'{}' is needed", c));
}

std::string_view UsdWords::name() {
    skipBlanks();
    std::size_t end = at_;
    while (end < text_.size() && isOfName(text_[end])) ++end;
    if (end > at_ && text_.substr(end, 2) == "[]") end += 2;
    const auto word = text_.substr(at_, end - at_);
    at_ = end;
    return word;
}

void UsdWords::appendEscaped(std::string& text) {
    // As Pixar's TfEscapeString: characters by letter, by two hexadecimal or three octal digits.
    const char c = text_[at_++];
    constexpr std::string_view kLetters = "abfnrtv", kMeanings = "\a\b\f\n\r\t\v";
    const auto letter = kLetters.find(c);
    const auto digits = [this](std::size_t most, int base) {
        int value = 0;
        for (std::size_t k = 0; k < most && at_ < text_.size(); ++k, ++at_) {
            const int digit = hexDigit(text_[at_]);
            if (digit < 0 || digit >= base) break;
            value = value * base + digit;
        }
        return static_cast<char>(value & 0xff);
    };
    if (letter != std::string_view::npos) {
        text += kMeanings[letter];
    } else if (c == 'x') {
        text += digits(2, 16);
    } else if (c >= '0' && c <= '7') {
        --at_;
        text += digits(3, 8);
    } else {
        text += c;
    }
}

std::string UsdWords::quoted() {
    const char quote = peek();
    if (quote != '"' && quote != '\'') failWhere("a text in quotes is needed");
    const std::string_view three = text_.substr(at_, 3);
    const std::string end(three == std::string(3, quote) ? 3 : 1, quote);
    const std::size_t begin = at_;
    at_ += end.size();
    std::string text;
    for (;;) {
        const auto stop = text_.find_first_of(
            end.size() == 3 ? std::string{quote, '\\'} : std::string{quote, '\\', '\n'}, at_);
        if (stop == std::string_view::npos || text_[stop] == '\n' || stop + 1 > text_.size()) {
            at_ = begin;
            fail("a text has no closing quote; the file is damaged or cut short");
        }
        text += text_.substr(at_, stop - at_);
        at_ = stop;
        if (text_[at_] == '\\' && at_ + 1 < text_.size()) {
            ++at_;
            appendEscaped(text);
        } else if (text_.substr(at_, end.size()) == end) {
            at_ += end.size();
            return text;
        } else {
            text += text_[at_++];
        }
    }
}

std::string_view UsdWords::numberWord() {
    skipBlanks();
    std::size_t end = at_;
    while (end < text_.size() && isOfNumber(text_[end])) ++end;
    return text_.substr(at_, end - at_);
}

bool UsdWords::acceptNone() {
    constexpr std::string_view kNone = "None";
    skipBlanks();
    if (!comes(kNone)) return false;
    at_ += kNone.size();
    return true;
}

double UsdWords::number() {
    const auto word = numberWord();
    double value = 0;
    if (word == "true" || word == "false")
        value = word == "true" ? 1 : 0;
    else if (!parseReal(word, value))
        failWhere("a number is needed");
    at_ += word.size();
    return value;
}

void UsdWords::skipTo(char close) {
    // Brackets that are open, innermost last.
    std::string open(1, close);
    while (!open.empty()) {
        const char c = peek();
        if (c == '\0' && at_ >= text_.size())
            fail(fmt::format("the file ends where '{}' is needed; it is cut short", open.back()));
        if (c == '"' || c == '\'') {
            quoted();
            continue;
        }
        if (c == '@') {
            skipValue();
            continue;
        }
        ++at_;
        if (c == '(' || c == '[' || c == '{')
            open += c == '(' ? ')' : c == '[' ? ']' : '}';
        else if (c == open.back())
            open.pop_back();
        else if (c == ')' || c == ']' || c == '}') {
            --at_;
            fail(fmt::format("'{}' where '{}' is needed; the file is damaged", c, open.back()));
        }
    }
}

void UsdWords::skipValue() {
    const char c = peek();
    if (c == '"' || c == '\'') {
        quoted();
    } else if (c == '(' || c == '[' || c == '{') {
        ++at_;
        skipTo(c == '(' ? ')' : c == '[' ? ']' : '}');
    } else if (c == '@' || c == '<') {
        const std::string_view end = c == '<' ? ">" : comes("@@@") ? "@@@" : "@";
        const auto stop = text_.find(end, at_ + (c == '<' ? 1 : end.size()));
        if (stop == std::string_view::npos) fail("a path has no end; the file is cut short");
        at_ = stop + end.size();
        // Three to five of them close a path that three open.
        while (end.size() == 3 && at_ < text_.size() && text_[at_] == '@') ++at_;
        // A prim of the file, and how its times are shifted.
        if (c == '@' && peek() == '<') skipValue();
        if (accept('(')) skipTo(')');
    } else {
        std::size_t end = at_;
        while (end < text_.size() && (isOfName(text_[end]) || isOfNumber(text_[end]))) ++end;
        if (end == at_) failWhere("a value is needed");
        at_ = end;
    }
}

void UsdWords::appendNumber(UsdArray& array) {
    const auto word = numberWord();
    std::int64_t whole = 0;
    if (array.whole && parseInteger(word, whole)) {
        array.wholes.push_back(whole);
        at_ += word.size();
        return;
    }
    const double value = number();
    if (!array.whole) {
        array.reals.push_back(value);
    } else if (wholeNumber(value, whole)) {
        array.wholes.push_back(whole);
    } else {
        fail(fmt::format("{} where a whole number is needed; correct it", value));
    }
}

std::size_t UsdWords::appendTuple(UsdArray& array, bool ofMatrix) {
    std::size_t count = 0;
    do {
        if (peek() == ')') break;
        if (ofMatrix && accept('(')) {
            count += appendTuple(array, false);
        } else {
            appendNumber(array);
            ++count;
        }
    } while (accept(','));
    expect(')');
    return count;
}

void UsdWords::appendItem(UsdArray& array, bool first) {
    const char c = peek();
    const bool text = c == '"' || c == '\'';
    if (text != !array.texts.empty() && !first) fail("numbers and texts in one array; correct it");
    if (text) {
        array.texts.push_back(quoted());
        return;
    }
    if (!accept('(')) {
        if (array.components != 1) fail("a number among tuples; correct it");
        appendNumber(array);
        return;
    }
    const std::size_t count = appendTuple(array, true);
    if (first) array.components = std::max<std::size_t>(count, 1);
    if (count != array.components)
        fail(fmt::format("a tuple of {} numbers among those of {}; correct it", count,
                         array.components));
}

UsdArray UsdWords::array(bool whole) {
    UsdArray array;
    array.whole = whole;
    if (!accept('[')) {
        appendItem(array, true);
        return array;
    }
    bool first = true;
    while (peek() != ']') {
        appendItem(array, first);
        first = false;
        if (!accept(',')) break;
    }
    expect(']');
    return array;
}

}  // namespace vdbpack
