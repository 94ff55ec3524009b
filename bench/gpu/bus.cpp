// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/gpu_cases.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "bench/clocks.hpp"
#include "bench/surface/bandwidth.hpp"
#include "engine/base/try.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/scene/plane_memory.hpp"

namespace touchable {
namespace {

// Consecutive frames of 3840x2160 and 16 bits. Together they are larger than any cache, also the GPU's, so
// that copies of all in turn run at the bus's speed.
constexpr std::size_t bus_frame_bytes = std::size_t{2} * 3840 * 2160, bus_frames = 16,
                      bus_bytes = bus_frames * bus_frame_bytes;
constexpr int bus_rounds = 3;

double ms_since(std::int64_t begin) {
    return static_cast<double>(monotonic_ns() - begin) * 1e-6;
}

/// Wall time of a memcpy per frame, in the fastest round over all frames.
double memcpy_ms(std::uint8_t* to, const std::uint8_t* from) {
    double least = HUGE_VAL;
    for (int n = 0; n < bus_rounds; ++n) {
        const std::int64_t begin = monotonic_ns();
        for (std::size_t at = 0; at < bus_bytes; at += bus_frame_bytes)
            std::memcpy(to + at, from + at, bus_frame_bytes);
        least = std::min(least, ms_since(begin));
    }
    return least / bus_frames;
}

/// Device time of vkCmdCopyBuffer per frame, in the fastest round over all frames.
Result<double> device_copy_ms(const std::shared_ptr<GpuDevice>& device, const GpuBuffer& from,
                              const GpuBuffer& to) {
    TRY_ASSIGN(auto commands, GpuCommands::begin(device, "bus"));
    commands.fill(to, 0);  // so that the final content was copied
    commands.barrier(GpuStage::transfer, GpuStage::transfer);
    for (int n = 0; n < bus_rounds; ++n) {
        commands.mark("before");
        for (std::size_t at = 0; at < bus_bytes; at += bus_frame_bytes) {
            commands.copy(from, at, to, at, bus_frame_bytes);
            commands.barrier(GpuStage::transfer, GpuStage::transfer);
        }
        commands.mark("copy");
    }
    TRY_ASSIGN(const auto submission, std::move(commands).submit());
    TRY(submission.wait());
    double least = HUGE_VAL;
    for (const GpuDevice::Time& time : submission.times())
        if (time.label == "copy") least = std::min(least, time.ms);
    return least / bus_frames;
}

void add_copy(Figures& figures, const std::string& what, double ms) {
    figures.push_back({what + "_ms", ms, "ms"});
    figures.push_back({what + "_gb_s", static_cast<double>(bus_frame_bytes) * 1e-6 / ms, "GB/s"});
}

/// Times copies from `host` to `own` on the device, and returns the time of copies from `own` to `back`. The
/// frames must come back unchanged.
Result<double> measure_upload(const std::shared_ptr<GpuDevice>& device, const std::string& what,
                              const GpuBuffer& host, const GpuBuffer& own, const GpuBuffer& back,
                              const std::uint8_t* frames, Figures& figures) {
    TRY_ASSIGN(const double there, device_copy_ms(device, host, own));
    add_copy(figures, what, there);
    TRY_ASSIGN(const double readback, device_copy_ms(device, own, back));
    if (std::memcmp(back.mapped<std::uint8_t>().data(), frames, bus_bytes) == 0) return readback;
    return Error{ErrorKind::check, "frames that went to the device by " + what + " came back changed"};
}

}  // namespace

Result<void> measure_device_memory(const std::shared_ptr<GpuDevice>& device, Figures& figures) {
    const GpuFacts& facts = device->facts();
    TRY_ASSIGN(const auto bandwidth, copy_bandwidth(device));
    figures.push_back({"kernel_copy_gb_s", bandwidth.by_kernel, "GB/s"});
    figures.push_back({"copy_gb_s", bandwidth.by_command, "GB/s"});
    double least = HUGE_VAL;
    for (int n = 0; n < 100; ++n) {
        const std::int64_t begin = monotonic_ns();
        TRY_ASSIGN(auto commands, GpuCommands::begin(device, "nothing", GpuTiming::none));
        TRY(std::move(commands).run());
        least = std::min(least, ms_since(begin));
    }
    figures.push_back({"empty_submission_us", 1000 * least, "us"});
    figures.push_back({"on_gpu", facts.kind != GpuKind::software ? 1.0 : 0.0, ""});
    figures.push_back({"unified_memory", facts.unified_memory ? 1.0 : 0.0, ""});
    figures.push_back({"imports_memory", facts.import_alignment > 0 ? 1.0 : 0.0, ""});
    return {};
}

Result<void> measure_bus(const std::shared_ptr<GpuDevice>& device, Figures& figures) {
    const auto frames = take_plane_memory(bus_bytes);
    if (!frames) return Error{ErrorKind::internal, "no memory for the frames"};
    std::uint64_t state = 3;
    for (std::size_t k = 0; k < bus_bytes; k += sizeof(state)) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        std::memcpy(frames.get() + k, &state, sizeof(state));
    }
    std::vector<std::uint8_t> copy(bus_bytes);
    TRY_ASSIGN(auto host, GpuBuffer::create(*device, "upload", bus_bytes, GpuMemory::upload));
    TRY_ASSIGN(const auto own, GpuBuffer::create(*device, "frames", bus_bytes, GpuMemory::device));
    TRY_ASSIGN(const auto back, GpuBuffer::create(*device, "readback", bus_bytes, GpuMemory::readback));

    add_copy(figures, "memcpy", memcpy_ms(copy.data(), frames.get()));
    add_copy(figures, "memcpy_to_upload", memcpy_ms(host.mapped<std::uint8_t>().data(), frames.get()));
    TRY_ASSIGN(double readback, measure_upload(device, "upload", host, own, back, frames.get(), figures));
    if (device->facts().import_alignment > 0) {
        host = {};  // freeing must not count as importing
        const std::int64_t begin = monotonic_ns();
        TRY_ASSIGN(host, GpuBuffer::import(*device, "planes", plane_block_of(frames.get(), bus_bytes)));
        figures.push_back({"import_once_ms", ms_since(begin) / bus_frames, "ms"});
        TRY_ASSIGN(readback, measure_upload(device, "imported", host, own, back, frames.get(), figures));
    }
    add_copy(figures, "readback", readback);
    add_copy(figures, "memcpy_from_readback", memcpy_ms(copy.data(), back.mapped<std::uint8_t>().data()));
    return {};
}

}  // namespace touchable
