// Private: the words and values of USD's text files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbpack {

/// An array of numbers, of tuples of numbers, or of texts.
struct UsdArray {
    std::size_t components = 1;  ///< of a tuple
    bool whole = false;          ///< numbers are in `wholes`
    std::vector<double> reals;
    std::vector<std::int64_t> wholes;
    std::vector<std::string> texts;

    std::size_t size() const {
        return (whole ? wholes.size() : texts.empty() ? reals.size() : texts.size()) / components;
    }
};

/// A text of USD, word by word; blanks and comments are passed over.
/// Source: pxr/usd/sdf/textFileFormatParser.h.
class UsdWords {
public:
    /// @param text  must outlive this. @param file  for messages.
    UsdWords(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

    bool atEnd();
    /// Whether a statement ends here: with the line, with ';' or before '}'.
    bool statementEnds();
    /// The next character; 0 at the end.
    char peek();
    /// Takes `c` if it comes next.
    bool accept(char c);
    void expect(char c);
    /// Takes a name, which may have namespaces (':'), suffixes ('.') and brackets for arrays
    /// ("[]").
    /// @return an empty one if there is none.
    std::string_view name();
    /// Takes a text in quotes. @throws InputError if there is none.
    std::string quoted();
    /// Takes "None" if it comes next.
    bool acceptNone();
    /// Takes a number. @throws InputError if there is none.
    double number();
    /// Takes a value of any kind: an array, a tuple, a dictionary, a text, a path, a number.
    void skipValue();
    /// Takes what comes up to the bracket `close`, whose counterpart has been taken.
    void skipTo(char close);
    /// Takes an array, or one value as an array of one; the rows of a matrix are one tuple.
    /// @param whole  numbers are whole.
    UsdArray array(bool whole);

    /// @throws InputError "file: line N: what", N being the line of the next word.
    [[noreturn]] void fail(const std::string& what) const;
    /// The same about the word that comes: "'abc' comes where `what`; the file is damaged ...".
    [[noreturn]] void failWhere(const std::string& what) const;

private:
    void skipBlanks();
    bool comes(std::string_view word) const { return text_.substr(at_, word.size()) == word; }
    std::string_view numberWord();
    void appendItem(UsdArray& array, bool first);
    void appendNumber(UsdArray& array);
    /// The numbers of a tuple after its bracket. @return how many.
    std::size_t appendTuple(UsdArray& array, bool ofMatrix);
    /// The character that an escape stands for, or none.
    void appendEscaped(std::string& text);

    std::string_view text_;
    std::string file_;
    std::size_t at_ = 0;
};

}  // namespace vdbpack
