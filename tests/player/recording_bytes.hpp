#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace touchable::test {

/// A recording's bytes to look into and to change, by the layout of docs/touch.md and not by the code
/// under test. Offsets are from the file's beginning.
class RecordingBytes {
public:
    explicit RecordingBytes(std::string bytes) : bytes_(std::move(bytes)) {}
    const std::string& bytes() const { return bytes_; }

    std::size_t fingers() const { return integer(12, 4); }
    std::size_t ticks() const { return integer(bytes_.size() - 16, 8); }
    std::size_t time_at(std::size_t tick) const { return 16 + tick * (head_size() + 52 * fingers()); }
    std::size_t blend_at(std::size_t tick) const { return time_at(tick) + 24; }
    /// Not in format 1, as the commands.
    std::size_t epoch_at(std::size_t tick) const { return time_at(tick) + 32; }
    std::size_t goal_at(std::size_t tick, std::size_t finger) const {
        return time_at(tick) + head_size() + 52 * finger;
    }
    std::size_t command_at(std::size_t command) const { return time_at(ticks()) + 28 * command; }
    std::size_t force_at(std::size_t tick, std::size_t finger) const { return goal_at(tick, finger) + 24; }
    std::size_t guard_at(std::size_t tick, std::size_t finger) const { return goal_at(tick, finger) + 48; }

    std::uint64_t integer(std::size_t at, std::size_t size) const;
    double real(std::size_t at) const;
    nlohmann::ordered_json facts() const;

    // Each leaves a recording whose hash is right.
    void set_integer(std::size_t at, std::size_t size, std::uint64_t value);
    void set_real(std::size_t at, double value);
    void set_facts(const std::string& text);
    /// The first `count` ticks alone.
    void keep_ticks(std::size_t count);

private:
    /// Size of a tick's head, before its fingers.
    std::size_t head_size() const { return integer(8, 4) == 1 ? 32 : 40; }
    void put(std::size_t at, std::size_t size, std::uint64_t value);
    void seal();
    std::string bytes_;
};

}  // namespace touchable::test
