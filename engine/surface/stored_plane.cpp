#include "engine/surface/stored_plane.hpp"

#include <cstring>
#include <utility>

namespace touchable {
namespace {

constexpr std::size_t texel_bytes = 16;

}  // namespace

void StoredPlane::keep(const BlockList& list, BuildNumber held) {
    if (uploaded_ >= held) uploaded_ = list.newest();
}

Result<void> StoredPlane::make_buffers(std::size_t bytes) {
    auto mapped = GpuBuffer::create(*device_, "stored values", bytes, GpuMemory::upload);
    if (!mapped.ok()) return mapped.error();
    auto own =
        copies_ ? GpuBuffer::create(*device_, "stored values of the GPU", bytes, GpuMemory::device) : mapped;
    if (!own.ok()) return own.error();
    upload_ = *mapped;
    stored_ = *own;
    return {};
}

/// Rows one after the other from texel to texel; of a frame that has changed in part, and if what was there
/// before is as new as the slot, those that have.
Result<StoredRows> StoredPlane::take(const PlaneView& depth, const BlockList& list, BuildNumber held) {
    const std::size_t pixel_bytes =
        static_cast<std::size_t>(depth.channels) * static_cast<std::size_t>(depth.bytes_per_sample);
    const std::size_t row_bytes = static_cast<std::size_t>(depth.width) * pixel_bytes;
    // Whole texels, and whole groups of 8 pixels, which is what kernels read.
    const std::size_t groups = (static_cast<std::size_t>(depth.width) + 7) / 8;
    const std::size_t pitch = (groups * 8 * pixel_bytes + texel_bytes - 1) / texel_bytes * texel_bytes;
    const std::size_t bytes = pitch * static_cast<std::size_t>(depth.height);
    BuildNumber there = std::exchange(uploaded_, 0);
    if (!upload_ || upload_.bytes() != bytes) {
        if (auto made = make_buffers(bytes); !made.ok()) return made.error();
        there = 0;
    }
    const bool in_part = !list.all() && there >= held;
    row_bytes_ = pitch;
    upload_rows_ = in_part ? list.rows() : RowRange{0, static_cast<std::uint32_t>(depth.height)};
    std::byte* to = upload_.mapped<std::byte>().data() + pitch * upload_rows_.first;
    const std::uint8_t* from = depth.row(static_cast<int>(upload_rows_.first));
    if (depth.stride == static_cast<std::ptrdiff_t>(pitch)) {
        std::memcpy(to, from, pitch * upload_rows_.count() - (pitch - row_bytes));
    } else {
        for (std::uint32_t n = 0; n < upload_rows_.count(); ++n, to += pitch, from += depth.stride)
            std::memcpy(to, from, row_bytes);
    }
    uploaded_ = list.newest();
    return StoredRows{stored_, static_cast<std::uint32_t>(depth.bytes_per_sample),
                      static_cast<std::uint32_t>(pitch / texel_bytes), valid_};
}

void StoredPlane::record_reading_in(GpuCommands& commands) const {
    if (!copies_) return;
    const std::size_t first = upload_rows_.first * row_bytes_;
    commands.copy(upload_, first, stored_, first, upload_rows_.count() * row_bytes_);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    commands.mark("read in");
}

}  // namespace touchable
