#include "engine/gpu/stored_plane.hpp"

#include <cstring>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::size_t texel_bytes = 16;

}  // namespace

Result<void> StoredPlane::make_buffers(std::size_t bytes) {
    if (upload_ && upload_.bytes() == bytes) return {};
    auto mapped = GpuBuffer::create(*device_, "stored values", bytes, GpuMemory::upload);
    if (!mapped.ok()) return mapped.error();
    TRY_ASSIGN(
        auto own,
        copies_ ? GpuBuffer::create(*device_, "stored values of the GPU", bytes, GpuMemory::device) : mapped);
    upload_ = *mapped;
    stored_ = own;
    return {};
}

/// Rows one after the other from texel to texel.
Result<StoredRows> StoredPlane::take(const PlaneView& depth, const RowRange& rows) {
    const std::size_t pixel_bytes =
        static_cast<std::size_t>(depth.channels) * static_cast<std::size_t>(depth.bytes_per_sample);
    const std::size_t row_bytes = static_cast<std::size_t>(depth.width) * pixel_bytes;
    // Whole texels, and whole groups of 8 pixels, which is what kernels read.
    const std::size_t groups = (static_cast<std::size_t>(depth.width) + 7) / 8;
    const std::size_t pitch = (groups * 8 * pixel_bytes + texel_bytes - 1) / texel_bytes * texel_bytes;
    TRY(make_buffers(pitch * static_cast<std::size_t>(depth.height)));
    taken_first_ = pitch * rows.first;
    taken_bytes_ = pitch * rows.count();
    std::byte* to = upload_.mapped<std::byte>().data() + taken_first_;
    const std::uint8_t* from = depth.row(static_cast<int>(rows.first));
    if (depth.stride == static_cast<std::ptrdiff_t>(pitch)) {
        std::memcpy(to, from, taken_bytes_ - (pitch - row_bytes));
    } else {
        for (std::uint32_t n = 0; n < rows.count(); ++n, to += pitch, from += depth.stride)
            std::memcpy(to, from, row_bytes);
    }
    return StoredRows{stored_, static_cast<std::uint32_t>(depth.bytes_per_sample),
                      static_cast<std::uint32_t>(pitch / texel_bytes), valid_};
}

void StoredPlane::record_reading_in(GpuCommands& commands) const {
    if (!copies_) return;
    commands.copy(upload_, taken_first_, stored_, taken_first_, taken_bytes_);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    commands.mark("read in");
}

}  // namespace touchable
