#include "vdbpack/core/error.h"

#include <new>
#include <string_view>
#include <system_error>

namespace vdbpack {

bool isShortage(const std::exception& failure) {
    if (const auto* system = dynamic_cast<const std::system_error*>(&failure))
        return system->code() == std::errc::not_enough_memory ||
               system->code() == std::errc::resource_unavailable_try_again;
    // TBB throws a std::runtime_error that only its text identifies.
    return dynamic_cast<const std::bad_alloc*>(&failure) != nullptr ||
           dynamic_cast<const ResourceError*>(&failure) != nullptr ||
           std::string_view(failure.what()).find("pthread_create") != std::string_view::npos;
}

}  // namespace vdbpack
