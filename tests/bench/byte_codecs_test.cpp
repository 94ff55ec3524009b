#include "bench/media/byte_codecs.hpp"

#include <gtest/gtest.h>

#include "engine/content/seeded_noise.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {
namespace {

/// Samples of the whole range with holes among them, rows apart by more than their length.
struct HoleyPicture {
    HoleyPicture(int width, int height, int bytes, int channels) {
        const int stride = width * bytes * channels + 6;
        samples.resize(static_cast<std::size_t>(stride * height));
        SplitMix64 random(3);
        for (std::uint8_t& sample : samples)
            sample = random.unit() < 0.5 ? 0 : static_cast<std::uint8_t>(random.next());
        view = {samples.data(), stride, width, height, bytes, channels};
    }
    std::vector<std::uint8_t> samples;
    PlaneView view;
};

void expect_back(PlaneCodec& codec, const PlaneView& view) {
    Packet packet;
    ASSERT_TRUE(codec.encode(view, packet));
    ASSERT_TRUE(codec.decode(packet));
    EXPECT_TRUE(same_samples(*codec.plane(), view));
}

TEST(ByteCodecs, GiveBackWhatWentIn) {
    for (const auto& [bytes, channels] : {std::pair{1, 1}, {2, 1}, {1, 3}}) {
        const HoleyPicture picture(37, 11, bytes, channels);
        expect_back(*make_raw_codec(picture.view), picture.view);
        if (channels == 1) expect_back(*make_rvl_codec(picture.view), picture.view);
        for (const auto make : {make_zstd_codec, make_zstd_gradient_codec})
            expect_back(*make(picture.view), picture.view);
    }
}

TEST(ByteCodecs, RvlWritesRunsAndDifferences) {
    // Two zeros, then 5, 3 and 20: differences 5, -2, 17 become 10, 3, 34, of which 10 and 34 take two
    // groups.
    const std::vector<std::uint16_t> row{0, 0, 5, 3, 20};
    const PlaneView view{reinterpret_cast<const std::uint8_t*>(row.data()), 10, 5, 1, 2, 1};
    Packet packet;
    ASSERT_TRUE(make_rvl_codec(view)->encode(view, packet));
    // From the lowest group on: 2, 3, 10 = 2 + 8 * 1, 3, 34 = 2 + 8 * 4.
    EXPECT_EQ(packet, (Packet{0x32, 0x1a, 0xa3, 0x04}));
}

TEST(ByteCodecs, RefuseWhatIsCutOff) {
    const HoleyPicture picture(37, 11, 2, 1);
    for (const auto& codec : {make_raw_codec(picture.view), make_rvl_codec(picture.view)}) {
        Packet packet;
        ASSERT_TRUE(codec->encode(picture.view, packet));
        packet.resize(packet.size() / 2);
        EXPECT_FALSE(codec->decode(packet));
    }
}

}  // namespace
}  // namespace touchable
