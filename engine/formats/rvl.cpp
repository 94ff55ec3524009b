#include "engine/formats/rvl.hpp"

#include <cstring>

namespace touchable {
namespace {

/// Groups of four bits in words of 32, low byte first, the highest group of a word first.
class Nibbles {
public:
    explicit Nibbles(std::string_view words) : words_(words) {}
    /// Three bits a group, the lowest first; the fourth says that another one follows.
    std::uint32_t number() {
        std::uint32_t value = 0;
        for (int bits = 0; bits < 32; bits += 3) {
            const std::uint32_t group = next();
            value |= (group & 7) << bits;
            if ((group & 8) == 0) return value;
        }
        is_over_ = true;
        return 0;
    }
    bool is_over() const { return is_over_; }

private:
    std::uint32_t next() {
        if (left_ == 0) {
            is_over_ = is_over_ || words_.size() < sizeof word_;
            if (is_over_) return 0;
            std::memcpy(&word_, words_.data(), sizeof word_);
            words_.remove_prefix(sizeof word_);
            left_ = 8;
        }
        const std::uint32_t group = word_ >> 28;
        word_ <<= 4;
        --left_;
        return group;
    }

    std::string_view words_;
    std::uint32_t word_ = 0;
    int left_ = 0;  // groups of the word
    bool is_over_ = false;
};

}  // namespace

std::optional<std::vector<std::uint16_t>> unpack_rvl(std::string_view words, std::size_t pixels) {
    Nibbles nibbles(words);
    std::vector<std::uint16_t> depths;
    depths.reserve(pixels);
    std::uint32_t newest = 0;
    while (depths.size() < pixels) {
        const std::size_t zeros = nibbles.number();
        if (nibbles.is_over() || zeros > pixels - depths.size()) return {};
        depths.resize(depths.size() + zeros, 0);
        const std::size_t others = nibbles.number();
        if (nibbles.is_over() || others > pixels - depths.size()) return {};
        // Both runs empty is nothing: whoever writes that never ends.
        if (zeros == 0 && others == 0) return {};
        for (std::size_t k = 0; k < others; ++k) {
            const std::uint32_t step = nibbles.number();
            if (nibbles.is_over()) return {};
            newest += (step >> 1) ^ (0 - (step & 1));  // 0, -1, 1, -2 ...
            depths.push_back(static_cast<std::uint16_t>(newest));
        }
    }
    return depths;
}

}  // namespace touchable
