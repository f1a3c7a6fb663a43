// The message of an expected error.
#pragma once

#include <string>

namespace vdbpack::test {

/// The message of the `Failure` that `work` throws; empty if it throws nothing. Other exceptions
/// are not caught.
template <class Failure, class Work>
std::string messageOf(const Work& work) {
    try {
        work();
    } catch (const Failure& e) {
        return e.what();
    }
    return "";
}

}  // namespace vdbpack::test
