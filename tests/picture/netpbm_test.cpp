// PGM, PPM and PFM: pictures by FFmpeg's encoders, and by hand.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/jpeg_with_xmp.hpp"
#include "tests/limited_memory.hpp"
#include "tests/picture/encoded_picture.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {
namespace {

int netpbm_byte(int k, int y) {
    return (37 * k + 11 * y + 5) & 255;
}
std::string encoded_netpbm(const char* codec, AVPixelFormat format, int row_bytes) {
    return encoded(codec, format, 7, 5, [&](AVFrame& frame) {
        for (int y = 0; y < 5; ++y)
            for (int k = 0; k < row_bytes; ++k)
                frame.data[0][y * frame.linesize[0] + k] = static_cast<std::uint8_t>(netpbm_byte(k, y));
    });
}

/// One row of grey samples as they come back.
std::vector<int> row_of_samples(const std::string& bytes) {
    const auto stored = decode_stored_image(bytes, "picture");
    EXPECT_EQ(message(stored), "");
    std::vector<int> row;
    if (!stored) return row;
    for (int x = 0; x < stored->image.width; ++x) row.push_back(stored->image.view().sample(x, 0));
    return row;
}

TEST(Netpbm, WhatFfmpegWritesComesBackExactly) {
    const auto grey = decode_stored_image(encoded_netpbm("pgm", AV_PIX_FMT_GRAY8, 7), "picture");
    const auto deep = decode_stored_image(encoded_netpbm("pgm", AV_PIX_FMT_GRAY16BE, 14), "picture");
    const auto colour = decode_stored_image(encoded_netpbm("ppm", AV_PIX_FMT_RGB24, 21), "picture");
    ASSERT_EQ(message(grey) + message(deep) + message(colour), "");
    EXPECT_EQ(grey->codec + grey->pixel_format + std::to_string(grey->bits), "pgmgray8");
    EXPECT_EQ(deep->codec + deep->pixel_format + std::to_string(deep->bits), "pgmgray16be16");
    EXPECT_EQ(colour->codec + colour->pixel_format + std::to_string(colour->bits), "ppmrgb248");
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) {
            EXPECT_EQ(grey->image.view().sample(x, y), netpbm_byte(x, y));
            EXPECT_EQ(deep->image.view().sample(x, y),
                      netpbm_byte(2 * x, y) << 8 | netpbm_byte(2 * x + 1, y));
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(colour->image.view().sample(x, y, c), netpbm_byte(3 * x + c, y));
        }
}

TEST(Netpbm, SamplesAreNotScaledToTheGreatest) {
    const std::string three("\x00\x05\x03\xff\x01\x00", 6);
    EXPECT_EQ(row_of_samples("P5 3 1 1023\n" + three), (std::vector{5, 1023, 256}));
    EXPECT_EQ(row_of_samples("P5 3 1 100\n\x01\x62\x64"), (std::vector{1, 98, 100}));
    EXPECT_EQ(decode_stored_image("P5 3 1 1023\n" + three, "picture")->bits, 10);
    EXPECT_EQ(decode_stored_image("P5 3 1 15\n\x01\x02\x0f", "picture")->bits, 4);
}

TEST(Netpbm, TextAndComments) {
    EXPECT_EQ(row_of_samples("P2 # grey\n3 1\n# deep\n4000\n0 17\t4000\n"), (std::vector{0, 17, 4000}));
    EXPECT_EQ(row_of_samples("P5\n#\n2 1 #\r\n255\n#\n"), (std::vector<int>{'#', '\n'}));
    const auto colour = decode_stored_image("P3 1 2 255 1 2 3 4 5 6", "picture");
    ASSERT_EQ(message(colour), "");
    EXPECT_EQ(colour->image.samples, (Samples{1, 2, 3, 4, 5, 6}));
}

TEST(Netpbm, GreyStoredAsColour) {
    const std::string grey("\x01\x02\x01\x02\x01\x02\x03\x04\x03\x04\x03\x04", 12);
    EXPECT_EQ(row_of_samples("P6 2 1 65535\n" + grey), (std::vector{0x102, 0x304}));
    EXPECT_NE(message(decode_stored_image("P6 2 1 65535\n\x09" + grey.substr(1), "picture")).find("colour"),
              std::string::npos);
    const auto eight = as_grey(decode_stored_image("P6 2 1 255\n\x07\x07\x07\x09\x09\x09", "picture")->image);
    ASSERT_TRUE(eight.has_value());
    EXPECT_EQ(eight->channels, 1);
    EXPECT_EQ(eight->samples, (Samples{7, 9}));
    for (const char* coloured : {"\x07\x07\x07\x09\x09\x08", "\x07\x07\x07\x08\x09\x09"})
        EXPECT_FALSE(as_grey(decode_stored_image("P6 2 1 255\n" + std::string(coloured), "picture")->image));
}

TEST(Netpbm, PngOfSixteenBitGreyStoredAsColour) {
    const auto stored = decode_stored_image(
        encoded("png", AV_PIX_FMT_RGBA64BE, 7, 5,
                [](AVFrame& frame) {
                    for (int y = 0; y < 5; ++y)
                        for (int k = 0; k < 56; ++k)
                            frame.data[0][y * frame.linesize[0] + k] =
                                static_cast<std::uint8_t>(k % 8 > 5 ? 17 * k : k % 2 + k / 8 + y);
                }),
        "picture");
    ASSERT_EQ(message(stored), "");
    ASSERT_EQ(stored->image.channels, 1);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) EXPECT_EQ(stored->image.view().sample(x, y), (x + y) * 256 + x + y + 1);
}

void expect_as_plainly_parsed(const std::filesystem::path& file) {
    const auto stored = read_stored_image(file);
    ASSERT_EQ(message(stored), "");
    const std::string bytes = read_bytes(file), header = "P5 640 480 65535\n";
    ASSERT_TRUE(bytes.starts_with(header));
    ASSERT_EQ(stored->image.width, 640);
    ASSERT_EQ(stored->image.height, 480);
    for (int y = 0; y < 480; ++y)
        for (int x = 0; x < 640; ++x) {
            const std::size_t at = header.size() + 2 * static_cast<std::size_t>(640 * y + x);
            ASSERT_EQ(stored->image.view().sample(x, y),
                      static_cast<unsigned char>(bytes[at]) << 8 | static_cast<unsigned char>(bytes[at + 1]));
        }
}

TEST(Netpbm, APictureWithAHeaderOfOneLineIsWhatAPlainParseGives) {
    const TemporaryFolder folder;
    std::string bytes = "P5 640 480 65535\n";
    Numbers numbers(3);
    for (int k = 0; k < 2 * 640 * 480; ++k) bytes += static_cast<char>(numbers.below(256));
    write_bytes(folder / "kinect.pgm", bytes);
    expect_as_plainly_parsed(folder / "kinect.pgm");
}

TEST(Netpbm, ARealKinectPictureIsWhatAPlainParseGives) {
    const auto file = real_data("other_formats/NYU_depth.pgm");
    TOUCHABLE_NEEDS_DATA(file);
    expect_as_plainly_parsed(file);
}

/// By the format's definition: the lowest row first. (FFmpeg 5.1 writes the highest first.)
TEST(Pfm, BothByteOrdersFromTheLowestRowUp) {
    const auto value = [](int x, int y) { return static_cast<float>(x) / 3 - static_cast<float>(y); };
    for (const bool low_byte_first : {false, true}) {
        std::string bytes = std::string("Pf\n7 5\n") + (low_byte_first ? "-1.000000\n" : "1.0\n");
        for (int y = 4; y >= 0; --y)
            for (int x = 0; x < 7; ++x) {
                std::string number = big_endian(std::bit_cast<std::uint32_t>(value(x, y)), 4);
                if (low_byte_first) std::reverse(number.begin(), number.end());
                bytes += number;
            }
        const auto stored = decode_stored_image(bytes, "picture");
        ASSERT_EQ(message(stored), "");
        EXPECT_EQ(stored->codec, "pfm");
        EXPECT_EQ(stored->pixel_format, low_byte_first ? "grayf32le" : "grayf32be");
        EXPECT_EQ(stored->bits, 32);
        ASSERT_EQ(stored->values.size(), 35U);
        EXPECT_EQ(stored->image.width * 100 + stored->image.height, 705);
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 7; ++x)
                EXPECT_EQ(stored->values[static_cast<std::size_t>(7 * y + x)], value(x, y));
    }
}

TEST(Pfm, InfinityAndNanPass) {
    const auto stored = decode_stored_image(
        "Pf\n3 1\n1.0\n" + big_endian(0x7f800000, 4) + big_endian(0x7fc00000, 4) + big_endian(0x80000000, 4),
        "picture");
    ASSERT_EQ(message(stored), "");
    EXPECT_EQ(stored->values[0], std::numeric_limits<float>::infinity());
    EXPECT_TRUE(std::isnan(stored->values[1]));
    EXPECT_TRUE(std::signbit(stored->values[2]));
}

TEST(Pfm, ItIsNoPictureOfIntegers) {
    const TemporaryFolder folder;
    write_bytes(folder / "depth.pfm", "Pf\n1 1\n-1\n\1\2\3\4");
    EXPECT_NE(message(read_image(folder / "depth.pfm")).find("depth.pfm: is a picture of floats"),
              std::string::npos);
}

TEST(Netpbm, AFolderOfThemIsAClip) {
    const TemporaryFolder folder;
    const auto opened = [&](const std::string& depth) {
        write_bytes(
            folder / "scene.json",
            R"({"touchable_scene": 1, "width": 7, "height": 5, "camera": {"fx": 9, "fy": 9, "cx": 3, "cy": 2},
                        "depth": {"coding": "metric", "scale": 0.001, "bits": 16}, "folder": {"depth": ")" +
                depth + "\"}}");
        return open_clip(folder / "scene.json");
    };
    write_bytes(folder / "d.pgm", encoded_netpbm("pgm", AV_PIX_FMT_GRAY16BE, 14));
    write_bytes(folder / "d.pfm", "Pf\n7 5\n-1\n" + std::string(140, '\0'));
    auto reader = opened("d.pgm");
    ASSERT_EQ(message(reader), "");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    EXPECT_EQ(frames->at(0).depth.sample(6, 4), netpbm_byte(12, 4) << 8 | netpbm_byte(13, 4));
    EXPECT_NE(message(opened("d.pfm")).find("no frame has a valid depth"), std::string::npos) << "all are 0";
}

TEST(NetpbmDamage, WhatIsWrongIsNamed) {
    const LimitedMemory little(64);
    const std::pair<const char*, const char*> cases[] = {
        {"P5 16384 16384 65535\nabc", "picture: is cut short"},
        {"P2 16384 16384 65535\n1 2", "picture: is cut short"},
        {"Pf 16384 16384 1\nabc", "picture: is cut short"},
        {"P5 16385 1 255\nabc", "picture: is 16385x1 pixels: must be from 1x1 to 16384x16384"},
        {"P5 0 1 255\nabc", "picture: is 0x1 pixels"},
        {"P5 1 1 65536\nabc", "picture: has no greatest value from 1 to 65535"},
        {"P2 1 1 9\n10 ", "picture: is damaged: number 1 of its samples is none from 0 to 9"},
        {"Pf 1 1 x\nabcd", "picture: has no scale after its size"},
        {"PF 1 1 1\nabcdabcdabcd", "picture: is of Netpbm's kind PF"},
        {"P4 8 1\na", "picture: is of Netpbm's kind P4"}};
    for (const auto& [bytes, words] : cases)
        EXPECT_TRUE(message(decode_stored_image(bytes, "picture")).starts_with(words))
            << message(decode_stored_image(bytes, "picture"));
}

}  // namespace
}  // namespace touchable::test
