#include "device/drive_times.hpp"

namespace touchable {

void DriveTimes::Ring::add(std::int64_t time_ns) {
    const std::size_t count = count_.load(std::memory_order_relaxed);
    times_[count % times_.size()].store(time_ns, std::memory_order_relaxed);
    count_.store(count + 1, std::memory_order_release);
}

std::vector<std::int64_t> DriveTimes::Ring::within(std::int64_t from_ns, std::int64_t to_ns) const {
    std::vector<std::int64_t> found;
    const std::size_t count = count_.load(std::memory_order_acquire);
    for (std::size_t k = count > times_.size() ? count - times_.size() : 0; k < count; ++k) {
        const std::int64_t time = times_[k % times_.size()].load(std::memory_order_relaxed);
        if (time >= from_ns && time < to_ns) found.push_back(time);
    }
    return found;
}

std::vector<std::int64_t> DriveTimes::received_within(std::int64_t from_ns, std::int64_t to_ns) const {
    return received_.within(from_ns, to_ns);
}

std::vector<std::int64_t> DriveTimes::sent_within(std::int64_t from_ns, std::int64_t to_ns) const {
    return sent_.within(from_ns, to_ns);
}

}  // namespace touchable
