// OpenEXR: by FFmpeg's encoder, and by OpenEXR's own writer, which the reader does not use.
#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/encoded_picture.hpp"

namespace touchable::test {
namespace {

float exr_value(int x, int y) {
    return static_cast<float>(x) / 8 - static_cast<float>(y);
}

struct ExrKind {
    Imf::PixelType type = Imf::FLOAT;
    Imf::Compression compression = Imf::ZIP_COMPRESSION;
    bool tiled = false;
    std::vector<std::string> channels = {"Z"};
    int width = 37, height = 41;
    int beyond = 0;        ///< pixels of the display window around the data window
    std::string odd = "";  ///< a channel of which one pixel differs
};

/// Numbers x/8 - y, of integers 100 y + x, in each channel.
std::string exr_file(const ExrKind& kind) {
    const TemporaryFolder folder;
    const Imath::Box2i data({5, 3}, {5 + kind.width - 1, 3 + kind.height - 1});
    const Imath::Box2i display({5 - kind.beyond, 3 - kind.beyond},
                               {data.max.x + kind.beyond, data.max.y + kind.beyond});
    Imf::Header header(display, data);
    header.compression() = kind.compression;
    const std::size_t bytes = kind.type == Imf::HALF ? 2 : 4,
                      row = bytes * static_cast<std::size_t>(kind.width);
    std::vector<std::vector<char>> samples;
    for (const std::string& name : kind.channels) {
        header.channels().insert(name, Imf::Channel(kind.type));
        auto& plane = samples.emplace_back(row * static_cast<std::size_t>(kind.height));
        for (int y = 0; y < kind.height; ++y)
            for (int x = 0; x < kind.width; ++x) {
                const float value = exr_value(x, y) + (name == kind.odd && x == 36 && y == 40 ? 1 : 0);
                const half small(value);
                const auto whole = static_cast<unsigned>(100 * y + x);
                const void* from = kind.type == Imf::HALF   ? static_cast<const void*>(&small)
                                   : kind.type == Imf::UINT ? static_cast<const void*>(&whole)
                                                            : static_cast<const void*>(&value);
                std::memcpy(
                    plane.data() + row * static_cast<std::size_t>(y) + bytes * static_cast<std::size_t>(x),
                    from, bytes);
            }
    }
    Imf::FrameBuffer frame;
    for (std::size_t k = 0; k < samples.size(); ++k)
        frame.insert(kind.channels[k], Imf::Slice::Make(kind.type, samples[k].data(), data, bytes, row));
    const std::string name = folder / "a.exr";
    if (kind.tiled) {
        header.setTileDescription({16, 8, Imf::MIPMAP_LEVELS});
        Imf::TiledOutputFile file(name.c_str(), header);
        file.setFrameBuffer(frame);
        for (int level = 0; level < file.numLevels(); ++level)
            file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    } else {
        Imf::OutputFile file(name.c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(kind.height);
    }
    return read_bytes(folder / "a.exr");
}

void expect_exr_values(const std::string& bytes, const std::string& format) {
    const auto stored = decode_stored_image(bytes, "picture");
    ASSERT_EQ(message(stored), "");
    EXPECT_EQ(stored->codec, "exr");
    EXPECT_EQ(stored->pixel_format, format);
    ASSERT_EQ(stored->image.width, 37);
    ASSERT_EQ(stored->image.height, 41);
    ASSERT_EQ(stored->values.size(), 37U * 41U);
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 37; ++x)
            ASSERT_EQ(stored->values[static_cast<std::size_t>(37 * y + x)], exr_value(x, y)) << x << "," << y;
}

std::string exr_refusal(const ExrKind& kind) {
    return message(decode_stored_image(exr_file(kind), "picture"));
}

TEST(Exr, WhatFfmpegWritesIsExact) {
    for (const AVPixelFormat format : {AV_PIX_FMT_GRAYF32LE, AV_PIX_FMT_GBRPF32LE})
        expect_exr_values(
            encoded("exr", format, 37, 41,
                    [&](AVFrame& frame) {
                        for (int plane = 0; plane < (format == AV_PIX_FMT_GRAYF32LE ? 1 : 3); ++plane)
                            for (int y = 0; y < 41; ++y)
                                for (int x = 0; x < 37; ++x) {
                                    const float value = exr_value(x, y);
                                    std::memcpy(frame.data[plane] + y * frame.linesize[plane] + 4 * x, &value,
                                                4);
                                }
                    }),
            "grayf32le");
}

TEST(Exr, EveryCompressionInRowsAndTiles) {
    for (const Imf::Compression compression :
         {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
          Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION})
        for (const bool tiled : {false, true}) {
            SCOPED_TRACE(std::to_string(compression) + (tiled ? " tiled" : ""));
            expect_exr_values(exr_file({.compression = compression, .tiled = tiled}), "grayf32le");
            expect_exr_values(exr_file({.type = Imf::HALF, .compression = compression, .tiled = tiled}),
                              "grayf16le");
        }
}

TEST(Exr, DwaIsRefusedByName) {
    EXPECT_EQ(exr_refusal({.compression = Imf::DWAA_COMPRESSION}),
              "picture: is compressed by DWA: must be by ZIP, PIZ or another that loses nothing");
}

TEST(Exr, IntegersAreCodesWhereTheyFit) {
    const auto stored = decode_stored_image(exr_file({.type = Imf::UINT}), "picture");
    ASSERT_EQ(message(stored), "");
    EXPECT_EQ(stored->pixel_format, "gray16le");
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 37; ++x) ASSERT_EQ(stored->image.view().sample(x, y), 100 * y + x);
}

TEST(Exr, TheChannelOfDepth) {
    // The one to read alone has the right numbers: another's last pixel is odd.
    expect_exr_values(exr_file({.channels = {"A", "B", "G", "R", "Z"}, .odd = "R"}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"Y", "left.Depth.V"}, .odd = "Y"}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"A", "R"}, .odd = "A"}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"A", "B", "G", "R"}, .odd = "A"}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"disparity"}}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"b", "g", "r"}}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"depth.B", "depth.G", "depth.R"}}), "grayf32le");
    for (const ExrKind& colour : {ExrKind{.channels = {"B", "G", "R"}, .odd = "B"},
                                  {.channels = {"b", "g", "r"}, .odd = "g"},
                                  {.channels = {"depth.B", "depth.G", "depth.R"}, .odd = "depth.B"},
                                  {.channels = {"Depth.b", "Depth.g", "Depth.r"}, .odd = "Depth.r"},
                                  {.channels = {"BY", "RY", "Y"}},
                                  {.channels = {"depth.by", "depth.ry", "depth.y"}}}) {
        SCOPED_TRACE(colour.channels.back());
        EXPECT_EQ(exr_refusal(colour),
                  "picture: is in colour: a picture of depth has a channel Z, depth, Y or R");
    }
    EXPECT_EQ(exr_refusal({.channels = {"u", "v"}}),
              "picture: has no channel Z, depth, Y or R for each pixel, but u, v");
}

TEST(Exr, BeyondTheDataWindowThereIsNothing) {
    const auto stored = decode_stored_image(exr_file({.beyond = 2}), "picture");
    ASSERT_EQ(message(stored), "");
    ASSERT_EQ(stored->image.width, 41);
    ASSERT_EQ(stored->image.height, 45);
    for (int y = 0; y < 45; ++y)
        for (int x = 0; x < 41; ++x) {
            const float value = stored->values[static_cast<std::size_t>(41 * y + x)];
            if (x < 2 || y < 2 || x >= 39 || y >= 43)
                ASSERT_TRUE(std::isnan(value)) << x << "," << y;
            else
                ASSERT_EQ(value, exr_value(x - 2, y - 2));
        }
    EXPECT_NE(exr_refusal({.beyond = -2}).find("data window beyond its display window"), std::string::npos);
}

/// A header that ends behind its first attribute, which OpenEXR calls damaged once it has read that.
std::string exr_header(int channels, int attributes) {
    const auto number = [](std::size_t value) {
        std::string bytes;
        for (int k = 0; k < 4; ++k) bytes += static_cast<char>(value >> 8 * k & 255);
        return bytes;
    };
    std::string list, others;
    for (int k = 0; k < channels; ++k)
        list += 'c' + std::to_string(k) + '\0' + number(2) + number(0) + number(1) + number(1);
    list += '\0';
    for (int k = 0; k < attributes; ++k)
        others += 'a' + std::to_string(k) + '\0' + "int" + '\0' + number(4) + number(7);
    return std::string("\x76\x2f\x31\x01\x02\0\0\0", 8) + others + "channels" + '\0' + "chlist" + '\0' +
           number(list.size()) + list;
}

/// OpenEXR would take as long as the square of their number.
TEST(Exr, RefusesLargeHeadersUnparsed) {
    EXPECT_EQ(message(decode_stored_image(exr_header(1025, 0), "picture")),
              "picture: has more than 1024 channels");
    EXPECT_EQ(message(decode_stored_image(exr_header(100'000, 0), "picture")),
              "picture: has more than 1024 channels");
    EXPECT_EQ(message(decode_stored_image(exr_header(1, 8192), "picture")),
              "picture: has more than 8192 attributes in its header");
    EXPECT_NE(message(decode_stored_image(exr_header(1024, 100), "picture")).find("is damaged"),
              std::string::npos);
}

}  // namespace
}  // namespace touchable::test
