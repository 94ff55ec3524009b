#pragma once

#include <cstdint>
#include <optional>

namespace touchable {

/// How much memory this process holds at most, beyond what it held at the beginning. Linux alone tells
/// (/proc/self/clear_refs, /proc/self/status).
class PeakMemory {
public:
    PeakMemory();  ///< from now on
    /// Bytes; nothing where the kernel does not tell.
    std::optional<std::int64_t> extra() const;

private:
    std::optional<std::int64_t> before_;
};

/// The peak of a process (0: this one) so far; nothing where the kernel does not tell, or it has ended.
std::optional<std::int64_t> peak_memory_of(int process);

}  // namespace touchable
