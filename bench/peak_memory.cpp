#include "bench/peak_memory.hpp"

#include <malloc.h>

#include <fstream>
#include <string>

namespace touchable {
namespace {

/// "VmHWM:   12345 kB" of /proc/<process>/status.
std::optional<std::int64_t> status_bytes(const std::string& process, const std::string& name) {
    std::ifstream status("/proc/" + process + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with(name + ":")) return 1024 * std::stoll(line.substr(name.size() + 1));
    return std::nullopt;
}

}  // namespace

PeakMemory::PeakMemory() {
    malloc_trim(0);  // returns freed memory to the system
    std::ofstream reset("/proc/self/clear_refs");
    reset << 5 << std::flush;
    if (reset) before_ = status_bytes("self", "VmRSS");
}

std::optional<std::int64_t> PeakMemory::extra() const {
    const auto peak = status_bytes("self", "VmHWM");
    if (!before_ || !peak) return std::nullopt;
    return *peak - *before_;
}

std::optional<std::int64_t> peak_memory_of(int process) {
    return status_bytes(process == 0 ? "self" : std::to_string(process), "VmHWM");
}

}  // namespace touchable
