#pragma once

#include <memory>

#include "engine/gpu/block_list.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/scene/plane_view.hpp"
#include "shaders/surface_codes.h"

namespace touchable {

/// Where a kernel reads from: stored values or codes, in rows of whole texels.
struct StoredRows {
    GpuBuffer buffer;
    std::uint32_t sample_bytes = 2, pitch = 0;  ///< texels from row to row
    ValidCodes valid;

    bool may_be_invalid() const {
        return valid.valid_min > 0 || valid.valid_span < (sample_bytes == 1 ? 255U : 65535U) ||
               valid.excluded[0] != no_such_code;
    }
};

/// Depth planes of one builder's frames, as its kernels read them: in buffers of their own, which keep what
/// is not taken anew.
class StoredPlane {
public:
    /// `valid`: of its values. `copies`: kernels read from the GPU's own memory.
    StoredPlane(std::shared_ptr<GpuDevice> device, const ValidCodes& valid, bool copies)
        : device_(std::move(device)), valid_(valid), copies_(copies) {}

    /// Some rows, at least one, of a frame; all of them where the frame before had another form.
    Result<StoredRows> take(const PlaneView& depth, const RowRange& rows);
    /// Records what `take` leaves to the GPU.
    void record_reading_in(GpuCommands& commands) const;

private:
    Result<void> make_buffers(std::size_t bytes);

    std::shared_ptr<GpuDevice> device_;
    const ValidCodes valid_;
    const bool copies_;
    GpuBuffer upload_, stored_;  // as the CPU writes it; in the GPU's own memory where that is not the same
    std::size_t taken_first_ = 0, taken_bytes_ = 0;  // of theirs, by the last call
};

}  // namespace touchable
