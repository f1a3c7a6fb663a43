// Errors: what, where, value, remedy. Parameters stand in backquotes by their fields: `voxelSize`.
#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbpack {

/// Base of everything the library throws on purpose. Messages quote what files hold: control
/// characters, which could end a message early or reach a terminal, become '?'.
class Error : public std::runtime_error {
public:
    explicit Error(std::string message) : std::runtime_error(printable(std::move(message))) {}

private:
    static std::string printable(std::string text) {
        for (char& c : text)
            if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f)
                c = '?';
        return text;
    }
};

/// An argument of the caller is unusable (exit code 2).
class ParameterError : public Error {
public:
    using Error::Error;
};

/// The content of a file, a mesh or a domain is unusable (exit code 3).
class InputError : public Error {
public:
    using Error::Error;
};

/// Reading or writing failed (exit code 4).
class IoError : public Error {
public:
    using Error::Error;
};

/// Not enough memory or space for what was asked (exit code 5).
class ResourceError : public Error {
public:
    using Error::Error;
};

/// The caller asked to stop (`Callbacks::cancelled`) before there was anything worth keeping (exit
/// code 130).
class Interrupted : public Error {
public:
    Interrupted() : Error("interrupted; nothing was complete, and nothing is written") {}
};

/// Whether an exception means that the system is out of memory or threads: `std::bad_alloc`,
/// ResourceError, `std::system_error` of that kind, and the exception of TBB when no thread starts.
bool isShortage(const std::exception& failure);

}  // namespace vdbpack
