#include "engine/formats/value_evidence.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "engine/base/stop_request.hpp"

namespace touchable {
namespace {

constexpr std::size_t fewest_values = 20;
constexpr int largest_divisor = 1000;
constexpr std::int64_t may_differ = 1000;  // one pixel in so many

struct Words {
    struct Occurring {
        unsigned word;
        std::int64_t pixels;
    };
    std::vector<Occurring> each;
    std::int64_t pixels = 0;

    explicit Words(const StoredImage& picture) {
        if (!picture.values.empty() || picture.image.bytes_per_sample != 2 || picture.image.channels != 1)
            return;
        std::vector<std::int64_t> counts(65536);
        until_stopped(picture.image.samples.size() / 2, [&](std::size_t first, std::size_t last) {
            for (std::size_t k = first; k < last; ++k) {
                std::uint16_t word = 0;
                std::memcpy(&word, picture.image.samples.data() + 2 * k, 2);
                ++counts[word];
            }
        });
        for (unsigned word = 1; word < 65535; ++word)
            if (counts[word] > 0) {
                each.push_back({word, counts[word]});
                pixels += counts[word];
            }
    }
    /// Pixels whose word does so.
    template <class Does>
    std::int64_t that(Does&& does) const {
        std::int64_t found = 0;
        for (const Occurring& one : each) found += does(one.word) ? one.pixels : 0;
        return found;
    }
    template <class Does>
    bool nearly_all(Does&& does) const {
        std::int64_t others = 0;
        for (const Occurring& one : each)
            if (!does(one.word) && (others += one.pixels) > pixels / may_differ) return false;
        return true;
    }
    bool tell() const { return each.size() >= fewest_values; }
};

unsigned swapped(unsigned word) {
    return (word << 8 | word >> 8) & 0xffffU;
}

int divisor_of(const Words& words) {
    if (!words.tell()) return 1;
    for (unsigned divisor = largest_divisor; divisor > 1; --divisor)
        if (words.nearly_all([&](unsigned word) { return word % divisor == 0; }))
            return static_cast<int>(divisor);
    return 1;
}

/// Disparities of a Kinect are of 11 bits, 2047 is none, and beyond 1092 nothing is that it could see.
bool is_swapped_kinect(const Words& words) {
    const auto is_near = [](unsigned word) { return swapped(word) >= 300 && swapped(word) <= 1092; };
    const auto is_usual = [&](unsigned word) { return is_near(word) || swapped(word) == 2047; };
    return words.nearly_all([](unsigned word) { return swapped(word) <= 2047; }) &&
           words.that(is_near) > words.pixels / 4 && words.that(is_usual) > words.pixels * 9 / 10;
}

/// Millimetres times 8, with the bits above 16 below: 1 from 8.192 m on, 2 from 16.384 m on.
bool is_rotated(const Words& words) {
    constexpr unsigned nearest = 250, deepest = 24'000;
    const auto millimetres = [](unsigned word) { return word >> 3 | (word & 7U) << 13; };
    const int divisor = divisor_of(words);
    return (divisor == 1 || divisor == 8) &&
           words.nearly_all([&](unsigned word) { return millimetres(word) < deepest; }) &&
           words.that([&](unsigned word) { return millimetres(word) > nearest; }) > words.pixels / 2;
}

}  // namespace

int common_divisor(const StoredImage& picture) {
    return divisor_of(Words(picture));
}

EvidentPreset evident_preset(const StoredImage& picture) {
    const Words words(picture);
    if (!words.tell()) return {};
    if (is_swapped_kinect(words))
        return {preset_named("nyu"),
                "with their bytes swapped its values are a Kinect's disparities, from 0 to 2047"};
    if (is_rotated(words))
        return {preset_named("sun"),
                "its values are multiples of 8, with the bits of what is beyond 8.191 m below them"};
    return {};
}

}  // namespace touchable
