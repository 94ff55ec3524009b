// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "engine/picture/decoding.hpp"
#include "engine/picture/image.hpp"
#include "tests/limits.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

struct Kind {
    int bytes, channels;
};
constexpr Kind kinds[] = {{1, 1}, {2, 1}, {1, 3}};

int stored_byte(int k, int y) {
    return (37 * k + 11 * y + 5) & 255;
}
void fill_rows(AVFrame& frame, int row_bytes) {
    for (int y = 0; y < frame.height; ++y)
        for (int k = 0; k < row_bytes; ++k)
            frame.data[0][y * frame.linesize[0] + k] = static_cast<std::uint8_t>(stored_byte(k, y));
}
/// 7x5 pixels of these bytes.
std::string encoded_rows(const char* codec, AVPixelFormat format, int row_bytes) {
    return encoded(codec, format, 7, 5, [&](AVFrame& frame) { fill_rows(frame, row_bytes); });
}

Result<Image> read_bytes_as_image(const std::string& bytes) {
    const TemporaryFolder folder;
    write_bytes(folder / "image", bytes);
    return read_image(folder / "image");
}

TEST(Image, KeepsPng) {
    const TemporaryFolder folder;
    Samples memory;
    for (const auto& [bytes, channels] : kinds)
        for (const int width : {1, 2, 3, 16, 17, 641})
            for (const int height : {1, 2, 31}) {
                const PlaneView plane =
                    test_plane(memory, width, height, bytes, channels, bytes == 1 ? 255 : 65535, 3, true);
                ASSERT_EQ(message(write_png(folder / "a.png", plane)), "");
                const auto image = must(read_image(folder / "a.png"));
                EXPECT_TRUE(same_plane(image.view(), plane))
                    << width << "x" << height << " " << bytes << " " << channels;
                EXPECT_EQ(image.samples.size(), static_cast<std::size_t>(width * height * bytes * channels));
            }
    EXPECT_EQ(folder.file_count(), 1U);
}

TEST(Image, WritesSameFileAgain) {
    const TemporaryFolder folder;
    Samples memory;
    const PlaneView plane = test_plane(memory, 100, 80, 2, 1, 65535, 3, false);
    ASSERT_EQ(message(write_png(folder / "a.png", plane)), "");
    ASSERT_EQ(message(write_png(folder / "b.png", plane)), "");
    EXPECT_EQ(read_bytes(folder / "a.png"), read_bytes(folder / "b.png"));
}

TEST(Image, DropsAlpha) {
    const auto read = [](AVPixelFormat format, int row_bytes) {
        return must(read_bytes_as_image(encoded_rows("png", format, row_bytes)));
    };
    const Image rgba = read(AV_PIX_FMT_RGBA, 28), grey = read(AV_PIX_FMT_YA8, 14),
                deep = read(AV_PIX_FMT_YA16BE, 28);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) {
            for (int c = 0; c < 3; ++c) EXPECT_EQ(rgba.view().sample(x, y, c), stored_byte(4 * x + c, y));
            EXPECT_EQ(grey.view().sample(x, y), stored_byte(2 * x, y));
            EXPECT_EQ(deep.view().sample(x, y), stored_byte(4 * x, y) << 8 | stored_byte(4 * x + 1, y));
        }
}

TEST(Image, ReadsPaletteAsRgb) {
    const auto image = read_bytes_as_image(encoded("png", AV_PIX_FMT_PAL8, 16, 16, [](AVFrame& frame) {
        fill_rows(frame, 16);
        for (std::uint32_t k = 0; k < 256; ++k) {
            const std::uint32_t entry = 0xFF000000U | k << 16 | (255 - k) << 8 | (k ^ 0x5A);
            std::memcpy(frame.data[1] + 4 * k, &entry, 4);
        }
    }));
    ASSERT_EQ(message(image), "");
    ASSERT_EQ(image->channels, 3);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            const int k = (37 * x + 11 * y + 5) & 255;
            EXPECT_EQ(image->view().sample(x, y, 0), k);
            EXPECT_EQ(image->view().sample(x, y, 1), 255 - k);
            EXPECT_EQ(image->view().sample(x, y, 2), k ^ 0x5A);
        }
}

/// Areas of so many colours.
Image areas_of(int colours) {
    return made_image(64, 48, 1, 3, [&](int x, int y, int c) {
        const int k = (x / 2 + 32 * (y / 3)) % colours;
        return c == 0 ? k & 255 : c == 1 ? 255 - (k >> 1 & 255) : k >> 8 | 2;
    });
}

TEST(Image, WritesFewColoursAsPalette) {
    const TemporaryFolder folder;
    for (const int colours : {1, 2, 3, 17, 255, 256, 257, 512}) {
        const Image image = areas_of(colours);
        for (const PngEffort effort : {PngEffort::quick, PngEffort::thorough}) {
            const auto write = [&](const char* name, PngColours how) {
                ASSERT_EQ(message(write_png_to(folder / name, image.view(), folder / name, effort, how)), "");
            };
            write("rgb.png", PngColours::rgb);
            write("few.png", PngColours::indexed_if_few);
            const auto plain = read_stored_image(folder / "rgb.png"),
                       few = read_stored_image(folder / "few.png");
            ASSERT_EQ(message(plain) + message(few), "") << colours;
            EXPECT_EQ(plain->pixel_format, "rgb24");
            EXPECT_EQ(few->pixel_format, colours <= 256 ? "pal8" : "rgb24");
            EXPECT_EQ(few->image.samples, image.samples) << colours;
            const std::string bytes = read_bytes(folder / "few.png");
            const std::size_t palette = bytes.find("PLTE");
            if (colours > 256) {
                EXPECT_EQ(palette, std::string::npos);
                continue;
            }
            ASSERT_NE(palette, std::string::npos);
            EXPECT_EQ(bytes.substr(palette - 4, 4), big_endian(3 * static_cast<std::uint64_t>(colours), 4));
            EXPECT_EQ(bytes.find("tRNS"), std::string::npos) << "nothing of it is transparent";
        }
    }
    // Sea, land and ice, whose borders are slanted.
    const Image materials = made_image(320, 240, 1, 3, [](int x, int y, int c) {
        return c == 0 ? 90 : c == 1 ? 40 + 80 * (3 * x + y > 500) : 7 + 50 * (x * x + 2 * y * y > 90000);
    });
    for (const auto& [name, how] :
         {std::pair{"rgb.png", PngColours::rgb}, {"few.png", PngColours::indexed_if_few}})
        ASSERT_EQ(message(write_png_to(folder / name, materials.view(), name, PngEffort::quick, how)), "");
    EXPECT_LT(3 * read_bytes(folder / "few.png").size(), 2 * read_bytes(folder / "rgb.png").size());
    const Image grey{2, 1, 1, 1, {7, 9}};
    ASSERT_EQ(message(write_png_to(folder / "grey.png", grey.view(), "grey.png", PngEffort::quick,
                                   PngColours::indexed_if_few)),
              "");
    EXPECT_EQ(read_stored_image(folder / "grey.png")->pixel_format, "gray");
}

TEST(Image, ReadsStoredIndices) {
    const TemporaryFolder folder;
    // Colours whose order says nothing of that of their indices.
    Image colours{5, 3, 1, 3, {}};
    const std::uint8_t which[] = {0, 1, 2, 1, 0, 3, 3, 2, 0, 1, 2, 2, 2, 3, 0}, red[] = {200, 3, 90, 40};
    for (const std::uint8_t k : which) colours.samples.insert(colours.samples.end(), {red[k], 7, 9});
    const auto read = [&](const Image& image, PngColours how) {
        EXPECT_EQ(message(write_png_to(folder / "p.png", image.view(), "p.png", PngEffort::quick, how)), "");
        return decode_indices(read_bytes(folder / "p.png"), "p.png");
    };
    const auto indices = read(colours, PngColours::indexed_if_few);
    ASSERT_EQ(message(indices), "");
    EXPECT_EQ(indices->channels, 1);
    ASSERT_EQ(indices->samples.size(), 15U);
    for (std::size_t a = 0; a < 15; ++a)
        for (std::size_t b = 0; b < 15; ++b)
            EXPECT_EQ(indices->samples[a] == indices->samples[b], which[a] == which[b]);
    EXPECT_LT(*std::max_element(indices->samples.begin(), indices->samples.end()), 4);
    const Image grey{2, 2, 1, 1, {0, 255, 7, 9}};
    EXPECT_EQ(read(grey, PngColours::rgb)->samples, grey.samples);
    EXPECT_EQ(message(read(colours, PngColours::rgb)),
              "p.png: must be a PNG of indices, with a palette or grey of up to 8 bits");
    EXPECT_FALSE(read({1, 1, 2, 1, {1, 2}}, PngColours::rgb));
    EXPECT_FALSE(decode_indices("nothing", "p.png"));
}

/// A plain colour passes 4:2:0 unharmed, so what comes back shows whether range and matrix are JPEG's.
TEST(Image, ReadsJpegColours) {
    constexpr int colours[][3] = {{255, 0, 0},     {0, 255, 0}, {0, 0, 255},
                                  {255, 255, 255}, {0, 0, 0},   {200, 120, 40}};
    for (const auto& [r, g, b] : colours) {
        const auto bytes =
            encoded("mjpeg", AV_PIX_FMT_YUVJ420P, 33, 17, [&, red = r, green = g, blue = b](AVFrame& frame) {
                const double luma = 0.299 * red + 0.587 * green + 0.114 * blue;
                const double values[] = {luma, 128 + (blue - luma) / 1.772, 128 + (red - luma) / 1.402};
                for (int plane = 0; plane < 3; ++plane)
                    for (int y = 0; y < (plane == 0 ? 17 : 9); ++y)
                        for (int x = 0; x < (plane == 0 ? 33 : 17); ++x)
                            frame.data[plane][y * frame.linesize[plane] + x] =
                                static_cast<std::uint8_t>(std::min(255.0, values[plane] + 0.5));
            });
        const auto image = must(read_bytes_as_image(bytes));
        const int expected[] = {r, g, b};
        for (int y = 0; y < 17; ++y)
            for (int x = 0; x < 33; ++x)
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(image.view().sample(x, y, c), expected[c], 4) << x << "," << y;
    }
}

TEST(Image, RefusesSixteenBitColour) {
    EXPECT_TRUE(is_refused(read_bytes_as_image(encoded_rows("png", AV_PIX_FMT_RGB48BE, 42)),
                           "has pixel format rgb48be"));
}

/// Three numbers of 16 bits a pixel.
std::string rgb48_png(const std::function<int(int x, int y, int channel)>& value) {
    return encoded("png", AV_PIX_FMT_RGB48BE, 40, 30, [&](AVFrame& frame) {
        for (int y = 0; y < 30; ++y)
            for (int x = 0; x < 40; ++x)
                for (int c = 0; c < 3; ++c) {
                    std::uint8_t* const to = frame.data[0] + frame.linesize[0] * y + 6 * x + 2 * c;
                    to[0] = static_cast<std::uint8_t>(value(x, y, c) >> 8);
                    to[1] = static_cast<std::uint8_t>(value(x, y, c) & 255);
                }
    });
}

/// Depth in one of three channels of 16 bits, and masks of few values in the others, as EVIMO has them.
TEST(Image, FindsChannelThatHoldsNumbers) {
    for (int depth = 0; depth < 3; ++depth) {
        const auto image = read_bytes_as_image(
            rgb48_png([&](int x, int y, int c) { return c == depth ? 900 + 40 * y + x : x / 20 * 1000; }));
        ASSERT_EQ(message(image), "") << depth;
        EXPECT_EQ(image->channels, 1);
        for (const auto& [x, y] : {std::pair{0, 0}, {39, 29}, {25, 7}})
            EXPECT_EQ(image->view().sample(x, y), 900 + 40 * y + x) << depth;
    }
    // A frame without depth: the first channel, not the mask.
    const auto blank =
        read_bytes_as_image(rgb48_png([](int x, int, int c) { return c == 2 ? x / 20 * 1000 : 0; }));
    ASSERT_EQ(message(blank), "");
    EXPECT_EQ(blank->view().sample(39, 3), 0);
}

TEST(ImageDamage, IsFoundInEveryByte) {
    const TemporaryFolder folder;
    Samples memory;
    const PlaneView plane = test_plane(memory, 16, 12, 2, 1, 65535, 3, true);
    ASSERT_EQ(message(write_png(folder / "a.png", plane)), "");
    const std::string whole = read_bytes(folder / "a.png");
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (const int change : {0x01, 0x20, 0x80, 0xff}) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] ^ change);
            const auto image = read_bytes_as_image(damaged);
            ASSERT_TRUE(!image || same_plane(image->view(), plane))
                << "byte " << at << " of " << whole.size() << " ^ " << change;
        }
}

TEST(ImageDamage, NamesOtherFiles) {
    const TemporaryFolder folder;
    EXPECT_TRUE(is_refused(read_bytes_as_image(""), "image: is empty"));
    EXPECT_TRUE(is_refused(read_bytes_as_image("GIF89a"), "image: is no picture that is read: PNG, JPEG"));
    EXPECT_TRUE(
        is_refused(read_image(folder / "absent.png"), "absent.png: does not exist; expected a picture"));
    EXPECT_TRUE(is_refused(read_image(folder.path()), "is a folder"));
}

TEST(ImageWriting, NamesUnwritablePlaces) {
    const TemporaryFolder folder;
    Samples memory;
    const PlaneView plane = test_plane(memory, 16, 12, 1, 1, 255, 3, true);
    EXPECT_TRUE(is_refused(write_png(folder / "absent" / "a.png", plane), "a.png: cannot be written: "));
    std::filesystem::create_directory(folder / "taken.png");
    EXPECT_TRUE(is_refused(write_png(folder / "taken.png", plane), "taken.png: "));
    EXPECT_EQ(folder.file_count(), 1U);
    EXPECT_FALSE(write_png(folder / "a.png", PlaneView{}));
}

/// Nothing is packed tighter, so these are close to what a file of so many bytes can hold. FFmpeg gives
/// pictures rows of whole 64 pixels.
TEST(ImageFile, ReadsAnyWidth) {
    const TemporaryFolder folder;
    const struct { int width, height; } sizes[] = {{2000, 2000}, {1800, 1800}, {8, 4096}, {1, 8192}};
    for (const auto& [width, height] : sizes) {
        Image image{width, height, 2, 1, {}};
        image.samples.resize(std::size_t{2} * static_cast<std::size_t>(width) *
                             static_cast<std::size_t>(height));
        ASSERT_EQ(message(write_png(folder / "flat.png", image.view())), "");
        const auto read = read_image(folder / "flat.png");
        ASSERT_EQ(message(read), "") << width << 'x' << height << " in "
                                     << std::filesystem::file_size(folder / "flat.png") << " bytes";
        EXPECT_EQ(read->samples, image.samples);
    }
}

// PGM, PPM and PFM: pictures by FFmpeg's encoders, and by hand.

/// The first row of grey samples, decoded.
std::vector<int> row_of_samples(const std::string& bytes) {
    const auto stored = decode_stored_image(bytes, "picture");
    EXPECT_EQ(message(stored), "");
    std::vector<int> row;
    if (!stored) return row;
    for (int x = 0; x < stored->image.width; ++x) row.push_back(stored->image.view().sample(x, 0));
    return row;
}

TEST(Netpbm, ReadsFfmpegFiles) {
    const auto grey = decode_stored_image(encoded_rows("pgm", AV_PIX_FMT_GRAY8, 7), "picture");
    const auto deep = decode_stored_image(encoded_rows("pgm", AV_PIX_FMT_GRAY16BE, 14), "picture");
    const auto colour = decode_stored_image(encoded_rows("ppm", AV_PIX_FMT_RGB24, 21), "picture");
    ASSERT_EQ(message(grey) + message(deep) + message(colour), "");
    EXPECT_EQ(grey->codec + grey->pixel_format + std::to_string(grey->bits), "pgmgray8");
    EXPECT_EQ(deep->codec + deep->pixel_format + std::to_string(deep->bits), "pgmgray16be16");
    EXPECT_EQ(colour->codec + colour->pixel_format + std::to_string(colour->bits), "ppmrgb248");
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) {
            EXPECT_EQ(grey->image.view().sample(x, y), stored_byte(x, y));
            EXPECT_EQ(deep->image.view().sample(x, y),
                      stored_byte(2 * x, y) << 8 | stored_byte(2 * x + 1, y));
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(colour->image.view().sample(x, y, c), stored_byte(3 * x + c, y));
        }
}

TEST(Netpbm, KeepsSamplesUnscaled) {
    const std::string three("\x00\x05\x03\xff\x01\x00", 6);
    EXPECT_EQ(row_of_samples("P5 3 1 1023\n" + three), (std::vector{5, 1023, 256}));
    EXPECT_EQ(row_of_samples("P5 3 1 100\n\x01\x62\x64"), (std::vector{1, 98, 100}));
    EXPECT_EQ(decode_stored_image("P5 3 1 1023\n" + three, "picture")->bits, 10);
    EXPECT_EQ(decode_stored_image("P5 3 1 15\n\x01\x02\x0f", "picture")->bits, 4);
}

TEST(Netpbm, ReadsTextAndComments) {
    EXPECT_EQ(row_of_samples("P2 # grey\n3 1\n# deep\n4000\n0 17\t4000\n"), (std::vector{0, 17, 4000}));
    EXPECT_EQ(row_of_samples("P5\n#\n2 1 #\r\n255\n#\n"), (std::vector<int>{'#', '\n'}));
    const auto colour = must(decode_stored_image("P3 1 2 255 1 2 3 4 5 6", "picture"));
    EXPECT_EQ(colour.image.samples, (Samples{1, 2, 3, 4, 5, 6}));
}

TEST(Netpbm, ReadsGreyStoredAsColour) {
    const std::string grey("\x01\x02\x01\x02\x01\x02\x03\x04\x03\x04\x03\x04", 12);
    EXPECT_EQ(row_of_samples("P6 2 1 65535\n" + grey), (std::vector{0x102, 0x304}));
    EXPECT_TRUE(is_refused(decode_stored_image("P6 2 1 65535\n\x09" + grey.substr(1), "picture"), "colour"));
    const auto eight = as_grey(decode_stored_image("P6 2 1 255\n\x07\x07\x07\x09\x09\x09", "picture")->image);
    ASSERT_TRUE(eight.has_value());
    EXPECT_EQ(eight->channels, 1);
    EXPECT_EQ(eight->samples, (Samples{7, 9}));
    for (const char* coloured : {"\x07\x07\x07\x09\x09\x08", "\x07\x07\x07\x08\x09\x09"})
        EXPECT_FALSE(as_grey(decode_stored_image("P6 2 1 255\n" + std::string(coloured), "picture")->image));
}

TEST(Image, ReadsGreyStoredAsColour) {
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

/// By the format's definition: the lowest row first. (FFmpeg 5.1 writes the highest first.)
TEST(Pfm, ReadsBothByteOrdersUpward) {
    const auto value = [](int x, int y) { return static_cast<float>(x) / 3 - static_cast<float>(y); };
    for (const bool low_byte_first : {false, true}) {
        std::string bytes = std::string("Pf\n7 5\n") + (low_byte_first ? "-1.000000\n" : "1.0\n");
        for (int y = 4; y >= 0; --y)
            for (int x = 0; x < 7; ++x) {
                std::string number = big_endian(std::bit_cast<std::uint32_t>(value(x, y)), 4);
                if (low_byte_first) std::reverse(number.begin(), number.end());
                bytes += number;
            }
        const auto stored = must(decode_stored_image(bytes, "picture"));
        EXPECT_EQ(stored.codec, "pfm");
        EXPECT_EQ(stored.pixel_format, low_byte_first ? "grayf32le" : "grayf32be");
        EXPECT_EQ(stored.bits, 32);
        ASSERT_EQ(stored.values.size(), 35U);
        EXPECT_EQ(stored.image.width * 100 + stored.image.height, 705);
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 7; ++x)
                EXPECT_EQ(stored.values[static_cast<std::size_t>(7 * y + x)], value(x, y));
    }
}

TEST(Pfm, KeepsInfinityAndNan) {
    const auto stored = must(decode_stored_image(
        "Pf\n3 1\n1.0\n" + big_endian(0x7f800000, 4) + big_endian(0x7fc00000, 4) + big_endian(0x80000000, 4),
        "picture"));
    EXPECT_EQ(stored.values[0], std::numeric_limits<float>::infinity());
    EXPECT_TRUE(std::isnan(stored.values[1]));
    EXPECT_TRUE(std::signbit(stored.values[2]));
}

TEST(Pfm, IsNotReadAsIntegers) {
    const TemporaryFolder folder;
    write_bytes(folder / "depth.pfm", "Pf\n1 1\n-1\n\1\2\3\4");
    EXPECT_TRUE(is_refused(read_image(folder / "depth.pfm"), "depth.pfm: is a picture of floats"));
}

TEST(Netpbm, OpensAsClip) {
    const TemporaryFolder folder;
    const auto opened = [&](const std::string& depth) {
        write_bytes(
            folder / "scene.json",
            R"({"touchable_scene": 1, "width": 7, "height": 5, "camera": {"fx": 9, "fy": 9, "cx": 3, "cy": 2},
                        "depth": {"coding": "metric", "scale": 0.001, "bits": 16}, "folder": {"depth": ")" +
                depth + "\"}}");
        return open_clip(folder / "scene.json");
    };
    write_bytes(folder / "d.pgm", encoded_rows("pgm", AV_PIX_FMT_GRAY16BE, 14));
    write_bytes(folder / "d.pfm", "Pf\n7 5\n-1\n" + std::string(140, '\0'));
    auto reader = must(opened("d.pgm"));
    const auto frames = must(read_all(*reader));
    EXPECT_EQ(frames.at(0).depth.sample(6, 4), stored_byte(12, 4) << 8 | stored_byte(13, 4));
    EXPECT_TRUE(is_refused(opened("d.pfm"), "no frame has a valid depth")) << "all are 0";
}

TEST(NetpbmDamage, IsNamed) {
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

// Against swscale's plain C, which the conversion was before, and against pixels moved one by one.

struct Look {
    int width = 64, height = 32;
    AVPixelFormat format = AV_PIX_FMT_YUV420P;
    AVColorRange range = AVCOL_RANGE_UNSPECIFIED;
    AVColorSpace space = AVCOL_SPC_UNSPECIFIED;
};

/// Every byte by chance, as likely an end of its range as anything else.
FramePtr noise(const Look& look, unsigned seed) {
    FramePtr frame(av_frame_alloc());
    frame->width = look.width;
    frame->height = look.height;
    frame->format = look.format;
    frame->color_range = look.range;
    frame->colorspace = look.space;
    EXPECT_GE(av_frame_get_buffer(frame.get(), 0), 0);
    std::mt19937 random(seed);
    for (const AVBufferRef* buffer : frame->buf)
        if (buffer)
            for (std::size_t k = 0; k < buffer->size; ++k)
                buffer->data[k] =
                    static_cast<std::uint8_t>(random() % 2 == 0 ? random() % 256 : 255 * (random() % 2));
    return frame;
}

using Bytes = std::vector<std::uint8_t>;

Bytes pixels_of(const AVFrame& rgb) {
    Bytes bytes;
    for (int y = 0; y < rgb.height; ++y) {
        const std::uint8_t* row = rgb.data[0] + std::ptrdiff_t{rgb.linesize[0]} * y;
        bytes.insert(bytes.end(), row, row + std::ptrdiff_t{3} * rgb.width);
    }
    return bytes;
}

bool is_full(const Look& look) {
    return look.range == AVCOL_RANGE_UNSPECIFIED ? look.format == AV_PIX_FMT_YUVJ420P
                                                 : look.range == AVCOL_RANGE_JPEG;
}

Bytes by_swscale(const AVFrame& frame, const Look& look) {
    const ScalerPtr scaler(sws_getContext(
        frame.width, frame.height, look.format, frame.width, frame.height, AV_PIX_FMT_RGB24,
        SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP, nullptr,
        nullptr, nullptr));
    sws_setColorspaceDetails(scaler.get(), sws_getCoefficients(look.space), is_full(look),
                             sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, 1 << 16, 1 << 16);
    const Look rgb_look{look.width, look.height, AV_PIX_FMT_RGB24};
    const FramePtr rgb = noise(rgb_look, 1);
    EXPECT_EQ(sws_scale(scaler.get(), frame.data, frame.linesize, 0, frame.height, rgb->data, rgb->linesize),
              frame.height);
    return pixels_of(*rgb);
}

Bytes by_vectors(VectorUnit unit, const AVFrame& frame, const Look& look) {
    const std::ptrdiff_t stride = std::ptrdiff_t{3} * frame.width;
    constexpr std::uint8_t untouched = 77;
    Bytes rgb(static_cast<std::size_t>(stride) * static_cast<std::size_t>(frame.height) + 1, untouched);
    const auto factors = RgbConverter::yuv_factors(sws_getCoefficients(look.space), is_full(look));
    RgbConverter::convert_yuv420(unit, frame, factors, rgb.data(), stride);
    EXPECT_EQ(rgb.back(), untouched) << "a byte beyond the picture was written";
    rgb.pop_back();
    return rgb;
}

std::string text_of(const Look& look) {
    return std::to_string(look.width) + "x" + std::to_string(look.height) + " " +
           av_get_pix_fmt_name(look.format) + ", range " + std::to_string(look.range) + ", space " +
           std::to_string(look.space);
}

std::vector<Look> yuv_looks() {
    silence_ffmpeg();
    std::vector<Look> looks;
    for (const auto& [width, height] :
         {std::pair{10, 10}, {12, 46}, {66, 34}, {510, 10}, {514, 12}, {1034, 18}})
        for (const AVPixelFormat format : {AV_PIX_FMT_YUV420P, AV_PIX_FMT_YUVJ420P})
            for (const AVColorRange range : {AVCOL_RANGE_UNSPECIFIED, AVCOL_RANGE_MPEG, AVCOL_RANGE_JPEG})
                for (const AVColorSpace space : {AVCOL_SPC_BT709, AVCOL_SPC_UNSPECIFIED, AVCOL_SPC_FCC,
                                                 AVCOL_SPC_SMPTE240M, AVCOL_SPC_BT2020_NCL})
                    looks.push_back({width, height, format, range, space});
    return looks;
}

TEST(PackedRgb, MatchesSwscaleOfYuv420) {
    unsigned seed = 0;
    for (const Look& look : yuv_looks()) {
        const FramePtr frame = noise(look, ++seed);
        const Bytes expected = by_swscale(*frame, look);
        for (const VectorUnit unit : usable_vector_units())
            ASSERT_EQ(by_vectors(unit, *frame, look), expected)
                << text_of(look) << ", unit " << static_cast<int>(unit);
    }
}

TEST(RgbConverter, MatchesSwscaleOfEverySize) {
    RgbConverter converter;
    unsigned seed = 0;
    for (const auto& [width, height] :
         {std::pair{2, 2}, {8, 8}, {8, 64}, {64, 8}, {9, 11}, {33, 32}, {32, 33}, {10, 10}, {64, 48}})
        for (const AVColorRange range : {AVCOL_RANGE_MPEG, AVCOL_RANGE_JPEG})
            for (const AVPixelFormat format : {AV_PIX_FMT_YUV420P, AV_PIX_FMT_YUV444P, AV_PIX_FMT_NV12}) {
                const Look look{width, height, format, range, AVCOL_SPC_BT709};
                const FramePtr frame = noise(look, ++seed);
                const auto rgb = converter.converted(*frame);
                ASSERT_TRUE(rgb) << rgb.error().message;
                ASSERT_EQ(pixels_of(**rgb), by_swscale(*frame, look)) << text_of(look);
            }
}

TEST(RgbConverter, RecoversFromRefusedFrame) {
    RgbConverter converter;
    const FramePtr frame = noise({}, 1);
    const auto before = converter.converted(*frame);
    ASSERT_TRUE(before);
    // The frame stays empty: only its format matters.
    const FramePtr other(av_frame_alloc());
    other->width = frame->width;
    other->height = frame->height;
    other->format = AV_PIX_FMT_VAAPI;
    EXPECT_FALSE(converter.converted(*other));
    const auto after = converter.converted(*frame);
    ASSERT_TRUE(after);
    EXPECT_EQ(pixels_of(**after), pixels_of(**before));
}

TEST(RgbConverter, MovesEveryOrderOfChannels) {
    unsigned seed = 0;
    for (const AVPixelFormat format : {AV_PIX_FMT_GBRP, AV_PIX_FMT_GBRAP, AV_PIX_FMT_RGB24, AV_PIX_FMT_BGR24,
                                       AV_PIX_FMT_BGR0, AV_PIX_FMT_RGB0, AV_PIX_FMT_0RGB, AV_PIX_FMT_0BGR,
                                       AV_PIX_FMT_RGBA, AV_PIX_FMT_ARGB, AV_PIX_FMT_PAL8})
        for (const int width : {1, 7, 8, 9, 511, 513}) {
            const FramePtr frame = noise({width, 5, format}, ++seed);
            const bool is_palette = format == AV_PIX_FMT_PAL8;
            Bytes expected;
            for (int y = 0; y < frame->height; ++y)
                for (int x = 0; x < width; ++x)
                    for (int c = 0; c < 3; ++c) {
                        const auto& samples = av_pix_fmt_desc_get(format)->comp[is_palette ? 0 : c];
                        const std::uint8_t sample =
                            frame->data[samples.plane][frame->linesize[samples.plane] * y + samples.step * x +
                                                       samples.offset];
                        if (!is_palette) {
                            expected.push_back(sample);
                            continue;
                        }
                        std::uint32_t entry;
                        std::memcpy(&entry, frame->data[1] + std::ptrdiff_t{4} * sample, 4);
                        expected.push_back(static_cast<std::uint8_t>(entry >> (16 - 8 * c)));
                    }
            RgbConverter converter;
            const auto rgb = converter.converted(*frame);
            ASSERT_TRUE(rgb) << rgb.error().message;
            ASSERT_EQ(pixels_of(**rgb), expected) << text_of({width, 5, format});
            ASSERT_EQ(rgb_exact(*frame).samples, expected) << text_of({width, 5, format});
        }
}

TEST(PackedRgb, IsSameInEveryUnit) {
    const FramePtr frame = noise({521, 2, AV_PIX_FMT_BGR0}, 3);
    const std::uint8_t* const row = frame->data[0];
    const int width = frame->width;
    for (const VectorUnit unit : usable_vector_units()) {
        Bytes taken(static_cast<std::size_t>(3 * width)), joined = taken, expected_taken, expected_joined;
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) {
                expected_taken.push_back(row[4 * x + 2 - c]);
                expected_joined.push_back(row[c * width + x]);
            }
        take_channels(unit, row, {2, 1, 0}, width, taken.data());
        join_channels(unit, {row, row + width, row + std::ptrdiff_t{2} * width}, width, joined.data());
        EXPECT_EQ(taken, expected_taken) << "unit " << static_cast<int>(unit);
        EXPECT_EQ(joined, expected_joined) << "unit " << static_cast<int>(unit);
    }
}

}  // namespace
}  // namespace touchable::test
