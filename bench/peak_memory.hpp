#pragma once

#include <cstdint>
#include <optional>

namespace touchable {

/// Peak memory of this process beyond its memory at the beginning. Linux only (/proc/self/clear_refs,
/// /proc/self/status).
class PeakMemory {
public:
    PeakMemory();  ///< starts measuring
    /// Bytes; nothing: not available from the kernel.
    std::optional<std::int64_t> extra() const;

private:
    std::optional<std::int64_t> before_;
};

/// Peak memory of a process (0: this one) so far, bytes; nothing: not available, or the process has ended.
std::optional<std::int64_t> peak_memory_of(int process);

}  // namespace touchable
