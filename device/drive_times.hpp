#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace touchable {

/// When positions came and forces went out: written by a device's thread (DrivenSettings), which it never
/// keeps waiting, read by another.
class DriveTimes {
public:
    explicit DriveTimes(std::size_t room) : received_(room), sent_(room) {}

    void received(std::int64_t time_ns) { received_.add(time_ns); }
    void sent(std::int64_t time_ns) { sent_.add(time_ns); }

    /// Those from one moment to before another, in order, as far as there was room.
    std::vector<std::int64_t> received_within(std::int64_t from_ns, std::int64_t to_ns) const;
    std::vector<std::int64_t> sent_within(std::int64_t from_ns, std::int64_t to_ns) const;

private:
    /// The newest of them; a reader takes what was there when it began, and leaves out what was overwritten.
    class Ring {
    public:
        explicit Ring(std::size_t room) : times_(room) {}
        void add(std::int64_t time_ns);
        std::vector<std::int64_t> within(std::int64_t from_ns, std::int64_t to_ns) const;

    private:
        std::vector<std::atomic<std::int64_t>> times_;
        std::atomic<std::size_t> count_{0};
    };
    Ring received_, sent_;
};

}  // namespace touchable
