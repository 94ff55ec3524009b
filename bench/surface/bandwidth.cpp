#include "bench/surface/bandwidth.hpp"

#include <algorithm>
#include <cmath>

#include "engine/gpu/gpu_commands.hpp"

namespace touchable {
namespace {

constexpr std::size_t copied_bytes = std::size_t{128} << 20;  // more than caches hold
constexpr int copies = 6;

}  // namespace

Result<double> copy_bandwidth(const std::shared_ptr<GpuDevice>& device) {
    const auto from = GpuBuffer::create(*device, "copied from", copied_bytes, GpuMemory::device);
    if (!from) return from.error();
    const auto to = GpuBuffer::create(*device, "copied to", copied_bytes, GpuMemory::device);
    if (!to) return to.error();
    auto commands = GpuCommands::begin(device, "copy bandwidth");
    if (!commands) return commands.error();
    commands->fill(*from, 1);  // memory that nobody has touched may not be there yet
    commands->fill(*to, 2);
    for (int n = 0; n < copies; ++n) {
        commands->barrier(GpuStage::transfer, GpuStage::transfer);
        commands->mark("before");
        commands->copy(*from, 0, *to, 0, copied_bytes);
        commands->mark("copy");
    }
    const auto submission = std::move(*commands).submit();
    if (!submission) return submission.error();
    if (auto done = submission->wait(); !done) return done.error();
    double least_ms = HUGE_VAL;
    for (const GpuDevice::Time& time : submission->times())
        if (time.label == "copy") least_ms = std::min(least_ms, time.ms);
    return 2 * static_cast<double>(copied_bytes) * 1e-6 / least_ms;
}

double least_bytes(const SurfaceCase& c) {
    const TileGrid grid = TileGrid::of(c.width, c.height);
    const double pixels = static_cast<double>(c.width) * c.height, stored = c.bits > 8 ? 2 : 1;
    return pixels * (stored + sizeof(std::uint16_t) + 1.0 / 8) +
           static_cast<double>(grid.tiles_x) * grid.tiles_y * sizeof(TileBounds);
}

}  // namespace touchable
