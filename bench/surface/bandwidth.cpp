// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/bandwidth.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/try.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "shaders/copy_texels.spv.h"

namespace touchable {
namespace {

constexpr std::size_t large_copy = std::size_t{128} << 20;  // more than caches hold
constexpr std::uint32_t copy_lanes = 256, copy_rounds = 6;

/// The least time to copy `copied_bytes`, by a kernel or, without one, by vkCmdCopyBuffer. Each copy has
/// different bytes; the last word is checked.
Result<double> copy_ms(const std::shared_ptr<GpuDevice>& device, const GpuProgram& kernel,
                       std::size_t copied_bytes) {
    TRY_ASSIGN(const auto from, GpuBuffer::create(*device, "copied from", copied_bytes, GpuMemory::device));
    TRY_ASSIGN(const auto to, GpuBuffer::create(*device, "copied to", copied_bytes, GpuMemory::device));
    TRY_ASSIGN(const auto last,
               GpuBuffer::create(*device, "copied", sizeof(std::uint32_t), GpuMemory::readback));
    TRY_ASSIGN(auto commands, GpuCommands::begin(device, "copy bandwidth"));
    const GpuStage stage = kernel ? GpuStage::compute : GpuStage::transfer;
    commands.fill(to, 0);  // memory that was never written may have no pages yet
    for (std::uint32_t n = 1; n <= copy_rounds; ++n) {
        commands.barrier(stage, GpuStage::transfer);
        commands.fill(from, n);
        commands.barrier(GpuStage::transfer, stage);
        commands.mark("before");
        if (kernel)
            commands.dispatch(kernel, {from, to},
                              {groups_for(static_cast<std::uint32_t>(copied_bytes / 16), copy_lanes)});
        else
            commands.copy(from, 0, to, 0, copied_bytes);
        commands.mark("copy");
    }
    commands.barrier(stage, GpuStage::transfer);
    commands.copy(to, copied_bytes - sizeof(std::uint32_t), last, 0, sizeof(std::uint32_t));
    TRY_ASSIGN(const auto submission, std::move(commands).submit());
    TRY(submission.wait());
    if (last.mapped<std::uint32_t>()[0] != copy_rounds)
        return Error{ErrorKind::check, "a copy on the device does not have the bytes of its source"};
    double least_ms = HUGE_VAL;
    for (const GpuDevice::Time& time : submission.times())
        if (time.label == "copy") least_ms = std::min(least_ms, time.ms);
    return least_ms;
}

Result<GpuProgram> copying_kernel(const GpuDevice& device) {
    return GpuProgram::create(
        device, "copy_texels", copy_texels_spv,
        {0, {GpuBindingKind::storage_buffer, GpuBindingKind::storage_buffer}, {copy_lanes, 1, 1}});
}

}  // namespace

Result<CopyBandwidth> copy_bandwidth(const std::shared_ptr<GpuDevice>& device) {
    TRY_ASSIGN(const auto kernel, copying_kernel(*device));
    TRY_ASSIGN(const double kernel_ms, copy_ms(device, kernel, large_copy));
    TRY_ASSIGN(const double command_ms, copy_ms(device, {}, large_copy));
    constexpr double moved = 2 * large_copy * 1e-6;
    return CopyBandwidth{moved / kernel_ms, moved / command_ms};
}

Result<double> kernel_copy_ms(const std::shared_ptr<GpuDevice>& device, double moved_bytes) {
    TRY_ASSIGN(const auto kernel, copying_kernel(*device));
    return copy_ms(device, kernel, aligned_bytes(static_cast<std::size_t>(moved_bytes / 2), 16));
}

double least_bytes(const SurfaceCase& c) {
    const TileGrid grid = TileGrid::of(c.width, c.height);
    const double pixels = static_cast<double>(c.width) * c.height, stored = c.bits > 8 ? 2 : 1;
    return pixels * (stored + sizeof(std::uint16_t) + 1.0 / 8) +
           static_cast<double>(grid.tiles_x) * grid.tiles_y * sizeof(TileBounds);
}

}  // namespace touchable
