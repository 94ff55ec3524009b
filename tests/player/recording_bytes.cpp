#include "tests/player/recording_bytes.hpp"

#include <xxhash.h>

#include <bit>

namespace touchable::test {

std::uint64_t RecordingBytes::integer(std::size_t at, std::size_t size) const {
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < size; ++k)
        value |= std::uint64_t{static_cast<std::uint8_t>(bytes_.at(at + k))} << (8 * k);
    return value;
}

double RecordingBytes::real(std::size_t at) const {
    return std::bit_cast<double>(integer(at, 8));
}

nlohmann::ordered_json RecordingBytes::facts() const {
    const std::size_t size = integer(bytes_.size() - 24, 8);
    return nlohmann::ordered_json::parse(bytes_.substr(bytes_.size() - 24 - size, size), nullptr, false);
}

void RecordingBytes::put(std::size_t at, std::size_t size, std::uint64_t value) {
    for (std::size_t k = 0; k < size; ++k) bytes_.at(at + k) = static_cast<char>(value >> (8 * k));
}

void RecordingBytes::seal() {
    put(bytes_.size() - 8, 8, XXH64(bytes_.data(), bytes_.size() - 8, 0));
}

void RecordingBytes::set_integer(std::size_t at, std::size_t size, std::uint64_t value) {
    put(at, size, value);
    seal();
}

void RecordingBytes::set_real(std::size_t at, double value) {
    set_integer(at, 8, std::bit_cast<std::uint64_t>(value));
}

void RecordingBytes::set_facts(const std::string& text) {
    const std::size_t size = integer(bytes_.size() - 24, 8);
    bytes_.replace(bytes_.size() - 24 - size, size, text);
    put(bytes_.size() - 24, 8, text.size());
    seal();
}

void RecordingBytes::keep_ticks(std::size_t count) {
    bytes_.erase(time_at(count), time_at(ticks()) - time_at(count));
    put(bytes_.size() - 16, 8, count);
    seal();
}

}  // namespace touchable::test
