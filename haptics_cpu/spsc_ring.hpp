#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace touchable {

/// A ring between one thread that writes and one that reads (single producer, single consumer). Neither
/// waits; all memory is there from the start.
template <class Slot>
class SpscRing {
public:
    explicit SpscRing(std::vector<Slot> slots) : slots_(std::move(slots)) {}

    /// The writer's: `fill` writes the next slot; false, and nothing written, while the ring is full.
    /// Wait-free.
    template <class Fill>
    bool push(const Fill& fill) {
        const std::uint64_t at = pushed_.load(std::memory_order_relaxed);
        if (at - popped_.load(std::memory_order_acquire) == slots_.size()) return false;
        fill(slots_[at % slots_.size()]);
        pushed_.store(at + 1, std::memory_order_release);
        return true;
    }
    /// The reader's: hands the oldest slot to `take`; false where there is none.
    template <class Take>
    bool pop(const Take& take) {
        const std::uint64_t at = popped_.load(std::memory_order_relaxed);
        if (at == pushed_.load(std::memory_order_acquire)) return false;
        take(slots_[at % slots_.size()]);
        popped_.store(at + 1, std::memory_order_release);
        return true;
    }

private:
    std::vector<Slot> slots_;
    alignas(64) std::atomic<std::uint64_t> pushed_{0};
    alignas(64) std::atomic<std::uint64_t> popped_{0};
};

}  // namespace touchable
