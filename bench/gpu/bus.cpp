#include "bench/gpu/gpu_cases.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
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

constexpr std::size_t bus_bytes = std::size_t{2} * 3840 * 2160;
constexpr int bus_rounds = 8;

double ms_since(std::int64_t begin) {
    return static_cast<double>(monotonic_ns() - begin) * 1e-6;
}

/// The least wall time of a memcpy of the frame.
double memcpy_ms(void* to, const void* from) {
    double least = HUGE_VAL;
    for (int n = 0; n < bus_rounds; ++n) {
        const std::int64_t begin = monotonic_ns();
        std::memcpy(to, from, bus_bytes);
        least = std::min(least, ms_since(begin));
    }
    return least;
}

/// The least time on the device of a copy of the frame by vkCmdCopyBuffer.
Result<double> device_copy_ms(const std::shared_ptr<GpuDevice>& device, const GpuBuffer& from,
                              const GpuBuffer& to) {
    TRY_ASSIGN(auto commands, GpuCommands::begin(device, "bus"));
    for (int n = 0; n < bus_rounds; ++n) {
        commands.barrier(GpuStage::transfer, GpuStage::transfer);
        commands.mark("before");
        commands.copy(from, 0, to, 0, bus_bytes);
        commands.mark("copy");
    }
    TRY_ASSIGN(const auto submission, std::move(commands).submit());
    TRY(submission.wait());
    double least = HUGE_VAL;
    for (const GpuDevice::Time& time : submission.times())
        if (time.label == "copy") least = std::min(least, time.ms);
    return least;
}

void add_copy(Figures& figures, const std::string& what, double ms) {
    figures.push_back({what + "_ms", ms, "ms"});
    figures.push_back({what + "_gb_s", static_cast<double>(bus_bytes) * 1e-6 / ms, "GB/s"});
}

/// Times copies from `host` to the device and back; the frame that came back must be the one that went.
Result<void> measure_upload(const std::shared_ptr<GpuDevice>& device, const std::string& what,
                            const GpuBuffer& host, const std::uint8_t* frame, const GpuBuffer& back,
                            Figures& figures) {
    TRY_ASSIGN(const auto own, GpuBuffer::create(*device, "frame", bus_bytes, GpuMemory::device));
    TRY_ASSIGN(const double there, device_copy_ms(device, host, own));
    add_copy(figures, what, there);
    std::ranges::fill(back.mapped<std::uint8_t>(), std::uint8_t{0});
    TRY(device_copy_ms(device, own, back));
    if (std::memcmp(back.mapped<std::uint8_t>().data(), frame, bus_bytes) == 0) return {};
    return Error{ErrorKind::check, "a frame that went to the device by " + what + " came back changed"};
}

}  // namespace

Result<void> measure_device_memory(const std::shared_ptr<GpuDevice>& device, Figures& figures) {
    const GpuFacts& facts = device->facts();
    std::fprintf(stderr, "device %s, %s %s, Vulkan %s\n", facts.name.c_str(), facts.driver.c_str(),
                 facts.driver_info.c_str(), facts.api.c_str());
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
    const auto plane = take_plane_memory(bus_bytes);
    if (!plane) return Error{ErrorKind::internal, "no memory for a frame"};
    std::uint64_t state = 3;
    for (std::size_t k = 0; k < bus_bytes; k += sizeof(state)) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        std::memcpy(plane.get() + k, &state, sizeof(state));
    }
    std::vector<std::uint8_t> copy(bus_bytes);
    TRY_ASSIGN(const auto upload, GpuBuffer::create(*device, "upload", bus_bytes, GpuMemory::upload));
    TRY_ASSIGN(const auto back, GpuBuffer::create(*device, "readback", bus_bytes, GpuMemory::readback));

    add_copy(figures, "memcpy", memcpy_ms(copy.data(), plane.get()));
    add_copy(figures, "memcpy_to_upload", memcpy_ms(upload.mapped<std::uint8_t>().data(), plane.get()));
    TRY(measure_upload(device, "upload", upload, plane.get(), back, figures));
    if (device->facts().import_alignment > 0) {
        const std::int64_t begin = monotonic_ns();
        TRY_ASSIGN(const auto imported,
                   GpuBuffer::import(*device, "plane", plane_block_of(plane.get(), bus_bytes)));
        figures.push_back({"import_once_ms", ms_since(begin), "ms"});
        TRY(measure_upload(device, "imported", imported, plane.get(), back, figures));
    }
    TRY_ASSIGN(const auto own, GpuBuffer::create(*device, "frame", bus_bytes, GpuMemory::device));
    TRY_ASSIGN(const double readback, device_copy_ms(device, own, back));
    add_copy(figures, "readback", readback);
    add_copy(figures, "memcpy_from_readback", memcpy_ms(copy.data(), back.mapped<std::uint8_t>().data()));
    return {};
}

}  // namespace touchable
