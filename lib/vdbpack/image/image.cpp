#include "vdbpack/image/image.h"

#include "vdbpack/core/error.h"

#include <algorithm>

namespace vdbpack {

Image copyOf(const Image& image) {
    Image copy;
    copy.grid = image.grid;
    copy.layers = image.layers;
    copy.type = image.type;
    copy.slope = image.slope;
    copy.intercept = image.intercept;
    copy.names = image.names;
    copy.format = image.format;
    copy.isSpaced = image.isSpaced;
    const std::size_t bytes = image.values() * bytesOf(image.type);
    copy.bytes.reset(static_cast<std::byte*>(std::malloc(std::max<std::size_t>(bytes, 1))));
    if (!copy.bytes) throw ResourceError("an image of this size does not fit into memory");
    std::copy_n(image.bytes.get(), bytes, copy.bytes.get());
    return copy;
}

}  // namespace vdbpack
