#include "vdbpack/field/read_vdb.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/vdb_check.h"

#include <fmt/format.h>
#include <openvdb/Exceptions.h>

#include <exception>

namespace vdbpack {

void readVdb(const std::string& path, const std::function<void()>& read) {
    checkVdbFile(path);
    try {
        read();
    } catch (const openvdb::IoError& e) {
        throw IoError(fmt::format("{}: {}; give a complete .vdb file", path, e.what()));
    } catch (const openvdb::Exception& e) {
        throw InputError(fmt::format("{}: {}; write the file again", path, e.what()));
    } catch (const Error&) {
        throw;
    } catch (const std::exception& e) {
        if (isShortage(e))
            throw ResourceError(fmt::format("{}: not enough memory to read it", path));
        throw IoError(
            fmt::format("{}: cannot be read: {}; give a complete .vdb file", path, e.what()));
    }
}

}  // namespace vdbpack
