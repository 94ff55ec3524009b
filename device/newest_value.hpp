#pragma once

#include <array>
#include <atomic>
#include <cstddef>

namespace touchable {

/// The newest value that one thread wrote, for one other thread to read. Neither locks, waits or retries, and
/// a value is never read half-written: of three places one is the writer's, one the reader's, and each swaps
/// its own for the one in between.
template <class T>
class NewestValue {
public:
    NewestValue() = default;
    NewestValue(const NewestValue&) = delete;
    NewestValue& operator=(const NewestValue&) = delete;

    /// Writer.
    void write(const T& value) {
        places_[writers_] = value;
        writers_ = between_.exchange(writers_ | is_new, std::memory_order_acq_rel) & ~is_new;
    }
    /// Reader. A default value before the first; what it gives stays as it is until the next call.
    const T& read() {
        if ((between_.load(std::memory_order_relaxed) & is_new) != 0)
            readers_ = between_.exchange(readers_, std::memory_order_acq_rel) & ~is_new;
        return places_[readers_];
    }

private:
    static constexpr std::size_t is_new = 4;

    std::array<T, 3> places_{};
    alignas(64) std::size_t writers_ = 0;
    alignas(64) std::size_t readers_ = 1;
    alignas(64) std::atomic<std::size_t> between_{2};
};

}  // namespace touchable
