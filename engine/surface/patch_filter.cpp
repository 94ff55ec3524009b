#include "engine/surface/patch_filter.hpp"

#include <cstring>

namespace touchable {

void PatchFilter::filter(const RawFrame& raw, const Patch& patch, SurfaceFrame& out) {
    const PixelBox& outer = patch.outer;
    RawFrame part;
    part.number = raw.number;
    part.depth = raw.depth;
    part.depth.data = raw.depth.row(outer.top) +
                      std::ptrdiff_t{outer.left} * raw.depth.channels * raw.depth.bytes_per_sample;
    part.depth.width = outer.right - outer.left;
    part.depth.height = outer.bottom - outer.top;
    filters_->make_all(part, alone_, picture_);
    copy(patch, out);
}

void PatchFilter::copy(const Patch& patch, SurfaceFrame& out) const {
    const PixelBox& inner = patch.inner;
    const int left = inner.left - patch.outer.left, top = inner.top - patch.outer.top;
    const int words = (inner.right - inner.left + strip_pixels - 1) / strip_pixels,
              shift = left % strip_pixels;
    const int words_of_picture = picture_.validity_words_per_row();
    for (int y = inner.top; y < inner.bottom; ++y) {
        const int from = y - inner.top + top;
        std::memcpy(out.codes.data() + out.index(inner.left, y),
                    picture_.codes.data() + picture_.index(left, from),
                    static_cast<std::size_t>(inner.right - inner.left) * sizeof(std::uint16_t));
        const std::uint32_t* bits = picture_.validity_row(from);
        std::uint32_t* to = out.validity_row(y) + inner.left / strip_pixels;
        for (int word = 0; word < words; ++word) {
            const int first = left / strip_pixels + word;
            const std::uint64_t next = first + 1 < words_of_picture ? bits[first + 1] : 0;
            to[word] = static_cast<std::uint32_t>((next << strip_pixels | bits[first]) >> shift);
        }
    }
}

}  // namespace touchable
