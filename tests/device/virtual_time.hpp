#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>

namespace touchable::test {

/// Time that passes only when somebody waits for something. Each of its milliseconds is a haptic tick, also
/// those that pass while a device's thread waits.
class VirtualTime {
public:
    static constexpr std::int64_t ms = 1'000'000;

    std::int64_t now_ns() const { return now_ns_; }
    void pass(std::int64_t ns) {
        const std::int64_t until = now_ns_ + ns;
        while (next_tick_ns_ <= until) {
            now_ns_ = next_tick_ns_;
            next_tick_ns_ += ms;
            if (on_tick) on_tick();
        }
        now_ns_ = until;
    }
    std::function<void()> on_tick;  ///< may not wait

private:
    std::int64_t now_ns_ = ms, next_tick_ns_ = 2 * ms;
};

}  // namespace touchable::test
