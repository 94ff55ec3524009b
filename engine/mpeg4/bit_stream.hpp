#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace touchable::mpeg4 {

/// The fewest bits that hold this number.
constexpr int bits_for(std::uint64_t value) {
    int bits = 0;
    while (bits < 64 && value >> bits != 0) ++bits;
    return bits;
}

/// Numbers one after the other, each in so many bits, the highest first.
class BitWriter {
public:
    void put(std::uint64_t value, int bits) {
        for (int k = bits - 1; k >= 0; --k) {
            if (used_ % 8 == 0) bytes_.push_back(0);
            bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | ((value >> k & 1) << (7 - used_ % 8)));
            ++used_;
        }
    }
    /// The bits, filled up with zeros to a whole byte.
    std::vector<std::uint8_t> take() { return std::move(bytes_); }

private:
    std::vector<std::uint8_t> bytes_;
    std::size_t used_ = 0;
};

/// Reads them again. Beyond the end there are zeros, which `is_over` tells.
class BitReader {
public:
    explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    std::uint64_t get(int bits) {
        std::uint64_t value = 0;
        for (int k = 0; k < bits; ++k, ++at_) {
            const std::size_t byte = at_ / 8;
            const bool bit = byte < bytes_.size() && (bytes_[byte] >> (7 - at_ % 8) & 1) != 0;
            value = value << 1 | (bit ? 1 : 0);
        }
        return value;
    }
    bool flag() { return get(1) != 0; }
    std::size_t position() const { return at_; }
    std::size_t left() const { return is_over() ? 0 : 8 * bytes_.size() - at_; }
    bool is_over() const { return at_ > 8 * bytes_.size(); }

private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;  // the next bit
};

}  // namespace touchable::mpeg4
