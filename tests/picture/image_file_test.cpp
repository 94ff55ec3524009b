#include "engine/picture/image.hpp"

#include <gtest/gtest.h>

#include <functional>

#include <cstdlib>
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/jpeg_with_xmp.hpp"
#include "tests/picture/encoded_picture.hpp"

namespace touchable::test {
namespace {

struct Kind {
    int bytes, channels;
};
constexpr Kind kinds[] = {{1, 1}, {2, 1}, {1, 3}};

void fill_rows(AVFrame& frame, int row_bytes) {
    for (int y = 0; y < frame.height; ++y)
        for (int k = 0; k < row_bytes; ++k)
            frame.data[0][y * frame.linesize[0] + k] = static_cast<std::uint8_t>(37 * k + 11 * y + 5);
}

Result<Image> read_bytes_as_image(const TemporaryFolder& folder, const std::string& bytes) {
    std::filesystem::remove(folder / "image");
    write_bytes(folder / "image", bytes);
    return read_image(folder / "image");
}

TEST(Image, PngComesBackExactly) {
    const TemporaryFolder folder;
    Samples memory;
    for (const auto& [bytes, channels] : kinds)
        for (const int width : {1, 2, 3, 16, 17, 641})
            for (const int height : {1, 2, 31}) {
                const PlaneView plane =
                    test_plane(memory, width, height, bytes, channels, bytes == 1 ? 255 : 65535, 3, true);
                ASSERT_EQ(message(write_png(folder / "a.png", plane)), "");
                const auto image = read_image(folder / "a.png");
                ASSERT_EQ(message(image), "");
                EXPECT_TRUE(same_plane(image->view(), plane))
                    << width << "x" << height << " " << bytes << " " << channels;
                EXPECT_EQ(image->samples.size(), static_cast<std::size_t>(width * height * bytes * channels));
            }
    EXPECT_EQ(folder.file_count(), 1U);
}

TEST(Image, SamePictureGivesTheSameFile) {
    const TemporaryFolder folder;
    Samples memory;
    const PlaneView plane = test_plane(memory, 100, 80, 2, 1, 65535, 3, false);
    ASSERT_EQ(message(write_png(folder / "a.png", plane)), "");
    ASSERT_EQ(message(write_png(folder / "b.png", plane)), "");
    EXPECT_EQ(read_bytes(folder / "a.png"), read_bytes(folder / "b.png"));
}

TEST(Image, AlphaIsDroppedAndTheRestIsExact) {
    const TemporaryFolder folder;
    const auto rgba = read_bytes_as_image(
        folder, encoded("png", AV_PIX_FMT_RGBA, 7, 5, [](AVFrame& frame) { fill_rows(frame, 28); }));
    ASSERT_EQ(message(rgba), "");
    const auto grey = read_bytes_as_image(
        folder, encoded("png", AV_PIX_FMT_YA8, 7, 5, [](AVFrame& frame) { fill_rows(frame, 14); }));
    ASSERT_EQ(message(grey), "");
    const auto deep = read_bytes_as_image(
        folder, encoded("png", AV_PIX_FMT_YA16BE, 7, 5, [](AVFrame& frame) { fill_rows(frame, 28); }));
    ASSERT_EQ(message(deep), "");
    const auto stored = [](int x, int y, int step, int offset) {
        return (37 * (x * step + offset) + 11 * y + 5) & 255;
    };
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) {
            for (int c = 0; c < 3; ++c) EXPECT_EQ(rgba->view().sample(x, y, c), stored(x, y, 4, c));
            EXPECT_EQ(grey->view().sample(x, y), stored(x, y, 2, 0));
            EXPECT_EQ(deep->view().sample(x, y), stored(x, y, 4, 0) << 8 | stored(x, y, 4, 1));
        }
}

TEST(Image, PaletteBecomesRgb) {
    const TemporaryFolder folder;
    const auto image = read_bytes_as_image(
        folder, encoded("png", AV_PIX_FMT_PAL8, 16, 16, [](AVFrame& frame) {
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
Image areas_of(int colours, int width = 64, int height = 48) {
    Image image{width, height, 1, 3, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int k = (x / 2 + width / 2 * (y / 3)) % colours;
            for (const int sample : {k & 255, 255 - (k >> 1 & 255), k >> 8 | 2})
                image.samples.push_back(static_cast<std::uint8_t>(sample));
        }
    return image;
}

TEST(Image, FewColoursAreStoredAsAPaletteOfThem) {
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
    Image materials{320, 240, 1, 3, {}};  // sea, land and ice, whose borders are slanted
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 320; ++x)
            for (const int sample : {90, 40 + 80 * (3 * x + y > 500), 7 + 50 * (x * x + 2 * y * y > 90000)})
                materials.samples.push_back(static_cast<std::uint8_t>(sample));
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

TEST(Image, IndicesAreReadAsTheyAreStored) {
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
TEST(Image, JpegColoursAreRight) {
    const TemporaryFolder folder;
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
        const auto image = read_bytes_as_image(folder, bytes);
        ASSERT_EQ(message(image), "");
        const int expected[] = {r, g, b};
        for (int y = 0; y < 17; ++y)
            for (int x = 0; x < 33; ++x)
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(image->view().sample(x, y, c), expected[c], 4) << x << "," << y;
    }
}

TEST(Image, JpegIsOfFullRange) {
    const TemporaryFolder folder;
    const auto bytes = encoded("mjpeg", AV_PIX_FMT_YUVJ444P, 16, 16, [](AVFrame& frame) {
        for (int plane = 0; plane < 3; ++plane)
            for (int y = 0; y < 16; ++y)
                std::memset(frame.data[plane] + y * frame.linesize[plane], plane == 0 ? 7 : 128, 16);
    });
    const auto image = read_bytes_as_image(folder, bytes);
    ASSERT_EQ(message(image), "");
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(image->view().sample(5, 5, c), 7, 1);  // not squeezed from 16..235
}

TEST(Image, SixteenBitColourIsRefusedByName) {
    const TemporaryFolder folder;
    const auto image = read_bytes_as_image(
        folder, encoded("png", AV_PIX_FMT_RGB48BE, 7, 5, [](AVFrame& frame) { fill_rows(frame, 42); }));
    EXPECT_NE(message(image).find("has pixel format rgb48be"), std::string::npos) << message(image);
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
TEST(Image, SixteenBitColourIsTheChannelThatHoldsNumbers) {
    const TemporaryFolder folder;
    for (int depth = 0; depth < 3; ++depth) {
        const auto image = read_bytes_as_image(folder, rgb48_png([&](int x, int y, int c) {
                                                   return c == depth ? 900 + 40 * y + x : x / 20 * 1000;
                                               }));
        ASSERT_EQ(message(image), "") << depth;
        EXPECT_EQ(image->channels, 1);
        for (const auto& [x, y] : {std::pair{0, 0}, {39, 29}, {25, 7}})
            EXPECT_EQ(image->view().sample(x, y), 900 + 40 * y + x) << depth;
    }
    // A frame without depth: the first channel, not the mask.
    const auto blank =
        read_bytes_as_image(folder, rgb48_png([](int x, int, int c) { return c == 2 ? x / 20 * 1000 : 0; }));
    ASSERT_EQ(message(blank), "");
    EXPECT_EQ(blank->view().sample(39, 3), 0);
}

TEST(ImageDamage, EveryChangedByteOfAPngIsAnErrorOrChangesNothing) {
    const TemporaryFolder folder;
    Samples memory;
    const PlaneView plane = test_plane(memory, 16, 12, 2, 1, 65535, 3, true);
    ASSERT_EQ(message(write_png(folder / "a.png", plane)), "");
    const std::string whole = read_bytes(folder / "a.png");
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (const int change : {0x01, 0x20, 0x80, 0xff}) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] ^ change);
            const auto image = read_bytes_as_image(folder, damaged);
            ASSERT_TRUE(!image || same_plane(image->view(), plane))
                << "byte " << at << " of " << whole.size() << " ^ " << change;
        }
}

TEST(ImageDamage, WhatIsNoImageIsNamed) {
    const TemporaryFolder folder;
    EXPECT_NE(message(read_bytes_as_image(folder, "")).find("image: is empty"), std::string::npos);
    EXPECT_NE(
        message(read_bytes_as_image(folder, "GIF89a")).find("image: is no picture that is read: PNG, JPEG"),
        std::string::npos);
    EXPECT_NE(
        message(read_image(folder / "absent.png")).find("absent.png: is not there; right would be a picture"),
        std::string::npos);
    EXPECT_NE(message(read_image(folder.path())).find("is a folder"), std::string::npos);
}

TEST(ImageWriting, PlacesThatCannotBeWrittenAreNamedAndLeftClean) {
    const TemporaryFolder folder;
    Samples memory;
    const PlaneView plane = test_plane(memory, 16, 12, 1, 1, 255, 3, true);
    EXPECT_NE(message(write_png(folder / "absent" / "a.png", plane)).find("a.png: cannot be written: "),
              std::string::npos);
    std::filesystem::create_directory(folder / "taken.png");
    EXPECT_NE(message(write_png(folder / "taken.png", plane)).find("taken.png: "), std::string::npos);
    EXPECT_EQ(folder.file_count(), 1U);
    EXPECT_FALSE(write_png(folder / "a.png", PlaneView{}));
}

/// Nothing is packed tighter, so these are close to what a file of so many bytes can hold. FFmpeg gives
/// pictures rows of whole 64 pixels.
TEST(ImageFile, OfOneValueIsReadWhateverItsWidth) {
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

}  // namespace
}  // namespace touchable::test
