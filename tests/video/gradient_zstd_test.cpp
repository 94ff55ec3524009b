#include "engine/video/gradient_zstd.hpp"

#include <gtest/gtest.h>
#include <zstd.h>

#include <algorithm>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

using Wide = std::vector<std::uint16_t>;

Samples packet_of(const PlaneView& plane) {
    GradientZstdEncoder encoder;
    const auto packet = encoder.encode(plane);
    return {packet.begin(), packet.end()};
}

/// What is compressed, as the format is defined, sample by sample.
Samples plain_bytes(const PlaneView& plane) {
    const auto at = [&](int x, int y) { return x < 0 || y < 0 ? 0 : int{plane.sample(x, y)}; };
    Samples low, high;
    for (int y = 0; y < plane.height; ++y)
        for (int x = 0; x < plane.width; ++x) {
            const int predicted = at(x - 1, y) + at(x, y - 1) - at(x - 1, y - 1);
            int difference = ((at(x, y) - predicted) % 65536 + 65536) % 65536;
            if (difference >= 32768) difference -= 65536;
            const int code = difference >= 0 ? 2 * difference : -2 * difference - 1;
            low.push_back(static_cast<std::uint8_t>(code % 256));
            high.push_back(static_cast<std::uint8_t>(code / 256));
        }
    low.insert(low.end(), high.begin(), high.end());
    return low;
}

constexpr int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {2, 2}, {53, 37}, {300, 200}};

TEST(GradientZstd, CompressesWhatItsDefinitionSays) {
    for (const auto& [width, height] : sizes)
        for (const bool noisy : {true, false}) {
            Samples memory;
            const PlaneView plane = test_plane(memory, width, height, 2, 1, 65535, 5, noisy);
            const Samples packet = packet_of(plane), expected = plain_bytes(plane);
            Samples bytes(expected.size());
            ASSERT_EQ(ZSTD_getFrameContentSize(packet.data(), packet.size()), bytes.size());
            ASSERT_EQ(ZSTD_decompress(bytes.data(), bytes.size(), packet.data(), packet.size()),
                      bytes.size());
            EXPECT_EQ(bytes, expected) << width << "x" << height;
        }
}

/// Decodes into rows that are one sample apart, of which none may be written.
bool decodes(GradientZstdDecoder& decoder, std::span<const std::uint8_t> packet, int width, int height,
             Wide& samples) {
    constexpr std::uint16_t mark = 0xBEEF;
    const std::size_t stride = static_cast<std::size_t>(width) + 1;
    samples.assign(stride * static_cast<std::size_t>(height), mark);
    const bool good =
        decoder.decode(packet, width, height, samples.data(), static_cast<std::ptrdiff_t>(stride));
    for (std::size_t at = stride - 1; at < samples.size(); at += stride) EXPECT_EQ(samples[at], mark);
    return good;
}

TEST(GradientZstd, EverySampleComesBack) {
    GradientZstdDecoder decoder;  // of all sizes, one after the other
    for (const auto& [width, height] : sizes)
        for (const int largest : {65535, 4095, 1, 0}) {
            Samples memory;
            const PlaneView plane = test_plane(memory, width, height, 2, 1, largest, 7, true);
            Wide samples;
            ASSERT_TRUE(decodes(decoder, packet_of(plane), width, height, samples));
            const PlaneView decoded{reinterpret_cast<const std::uint8_t*>(samples.data()),
                                    2 * (std::ptrdiff_t{width} + 1),
                                    width,
                                    height,
                                    2,
                                    1};
            EXPECT_TRUE(same_plane(decoded, plane)) << width << "x" << height;
        }
}

TEST(GradientZstd, APacketOfAnotherSizeIsRefusedUnread) {
    Samples memory;
    const PlaneView plane = test_plane(memory, 24, 16, 2, 1, 65535, 1, true);
    const Samples packet = packet_of(plane);
    EXPECT_TRUE(GradientZstdDecoder::promises(packet, 24 * 16));
    Samples twice = packet;
    twice.insert(twice.end(), packet.begin(), packet.end());
    Samples unsized(1000);  // a frame that does not say what it holds
    ZSTD_CCtx* context = ZSTD_createCCtx();
    ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
    const Samples bytes = plain_bytes(plane);
    unsized.resize(ZSTD_compress2(context, unsized.data(), unsized.size(), bytes.data(), bytes.size()));
    ZSTD_freeCCtx(context);
    GradientZstdDecoder decoder;
    Wide samples;
    EXPECT_FALSE(decodes(decoder, packet, 24, 17, samples));
    EXPECT_FALSE(decodes(decoder, packet, 23, 16, samples));
    EXPECT_FALSE(decodes(decoder, twice, 24, 16, samples));
    EXPECT_FALSE(decodes(decoder, twice, 24, 32, samples));
    EXPECT_FALSE(decodes(decoder, unsized, 24, 16, samples));
    EXPECT_FALSE(decodes(decoder, {}, 24, 16, samples));
    EXPECT_TRUE(decodes(decoder, packet, 24, 16, samples));  // as good as before
}

}  // namespace
}  // namespace touchable::test
