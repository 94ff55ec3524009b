// SPDX-License-Identifier: Apache-2.0
// TIFF: by FFmpeg's encoder, which packs, and by hand for what it lacks: floats, tiles, the other byte order.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "engine/picture/image.hpp"
#include "tests/limits.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

struct TiffTag {
    int number;
    std::vector<std::size_t> values;
};
constexpr int strip_offsets = 273, strip_sizes = 279, tile_offsets = 324, tile_sizes = 325;

/// A file of these tags and blocks of a picture, whose places and sizes become the tags `offsets` and
/// `sizes`.
std::string tiff_of(bool big, std::vector<TiffTag> tags, int offsets, int sizes,
                    const std::vector<std::string>& blocks) {
    tags.push_back({offsets, std::vector<std::size_t>(blocks.size())});
    tags.push_back({sizes, {}});
    for (const std::string& block : blocks) tags.back().values.push_back(block.size());
    std::sort(tags.begin(), tags.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
    std::size_t at = 8 + 2 + 12 * tags.size() + 4;
    for (const TiffTag& tag : tags)
        if (tag.values.size() > 1) at += 4 * tag.values.size();
    for (TiffTag& tag : tags)
        if (tag.number == offsets)
            for (std::size_t k = 0; k < blocks.size(); at += blocks[k++].size()) tag.values[k] = at;
    const std::string magic = big ? std::string("MM\0*", 4) : std::string("II*\0", 4);
    std::string file = magic + tiff_number(8, 4, big) + tiff_number(tags.size(), 2, big), lists;
    const std::size_t lists_at = 8 + 2 + 12 * tags.size() + 4;
    for (const TiffTag& tag : tags) {
        file += tiff_number(static_cast<std::uint64_t>(tag.number), 2, big) + tiff_number(4, 2, big) +
                tiff_number(tag.values.size(), 4, big);
        file += tiff_number(tag.values.size() > 1 ? lists_at + lists.size() : tag.values[0], 4, big);
        if (tag.values.size() > 1)
            for (const std::size_t value : tag.values) lists += tiff_number(value, 4, big);
    }
    file += tiff_number(0, 4, big) + lists;
    for (const std::string& block : blocks) file += block;
    return file;
}

std::vector<TiffTag> tiff_tags(std::size_t width, std::size_t height, std::size_t bits, std::size_t format) {
    return {{256, {width}}, {257, {height}}, {258, {bits}},  {259, {1}},
            {262, {1}},     {277, {1}},      {339, {format}}};
}

/// A sample of so many bits that holds the number 100 y + x.
std::string tiff_sample(int number, int bits, bool floating, bool big) {
    if (!floating) return tiff_number(static_cast<std::uint64_t>(number), bits / 8, big);
    const float value = static_cast<float>(number) / 3;
    if (bits == 32) return tiff_number(std::bit_cast<std::uint32_t>(value), 4, big);
    return tiff_number(std::bit_cast<std::uint64_t>(double{value}), 8, big);
}

void expect_hundreds(const Result<StoredImage>& stored, int width, int height) {
    ASSERT_EQ(message(stored), "");
    ASSERT_EQ(stored->image.width, width);
    ASSERT_EQ(stored->image.height, height);
    EXPECT_EQ(stored->codec, "tiff");
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int number = 100 * y + x;
            if (stored->values.empty())
                ASSERT_EQ(stored->image.view().sample(x, y), number);
            else
                ASSERT_EQ(stored->values[static_cast<std::size_t>(y * width + x)],
                          static_cast<float>(number) / 3);
        }
}

/// 7x5 in strips of two rows.
std::string striped_tiff(int bits, bool floating, bool big, std::size_t format) {
    std::vector<std::string> strips;
    for (int y = 0; y < 5; ++y) {
        if (y % 2 == 0) strips.emplace_back();
        for (int x = 0; x < 7; ++x) strips.back() += tiff_sample(100 * y + x, bits, floating, big);
    }
    auto tags = tiff_tags(7, 5, static_cast<std::size_t>(bits), format);
    tags.push_back({278, {2}});
    return tiff_of(big, tags, strip_offsets, strip_sizes, strips);
}

/// 20x18 in tiles of 16x16.
std::string tiled_tiff(bool big) {
    std::vector<std::string> tiles(4);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x)
            tiles[static_cast<std::size_t>(y / 16 * 2 + x / 16)] += tiff_sample(100 * y + x, 32, true, big);
    auto tags = tiff_tags(20, 18, 32, 3);
    tags.push_back({322, {16}});
    tags.push_back({323, {16}});
    return tiff_of(big, tags, tile_offsets, tile_sizes, tiles);
}

TEST(Tiff, ReadsStripsOfBothOrders) {
    for (const bool big : {false, true}) {
        const auto floats = decode_stored_image(striped_tiff(32, true, big, 3), "picture"),
                   doubles = decode_stored_image(striped_tiff(64, true, big, 3), "picture"),
                   codes = decode_stored_image(striped_tiff(16, false, big, 1), "picture"),
                   wide = decode_stored_image(striped_tiff(32, false, big, 1), "picture"),
                   with_sign = decode_stored_image(striped_tiff(32, false, big, 2), "picture");
        for (const auto* stored : {&floats, &doubles, &codes, &wide, &with_sign})
            expect_hundreds(*stored, 7, 5);
        EXPECT_EQ(floats->pixel_format + doubles->pixel_format, "grayf32legrayf64le");
        for (const auto* stored : {&codes, &wide, &with_sign})
            EXPECT_EQ((*stored)->pixel_format + std::to_string((*stored)->bits), "gray16le16");
        EXPECT_EQ(floats->bits, 32);
    }
}

TEST(Tiff, ReadsTiles) {
    for (const bool big : {false, true})
        expect_hundreds(decode_stored_image(tiled_tiff(big), "picture"), 20, 18);
}

std::string packed_tiff(AVPixelFormat format, int row_bytes) {
    return encoded("tiff", format, 31, 40, [&](AVFrame& frame) {  // FFmpeg's default packs bits
        for (int y = 0; y < 40; ++y)
            for (int k = 0; k < row_bytes; ++k)
                frame.data[0][y * frame.linesize[0] + k] = static_cast<std::uint8_t>(k / 9 * 37 + y);
    });
}

TEST(Tiff, ReadsFfmpegFiles) {
    const auto byte = [](int k, int y) { return (k / 9 * 37 + y) & 255; };
    const auto grey = must(decode_stored_image(packed_tiff(AV_PIX_FMT_GRAY8, 31), "picture")),
               deep = must(decode_stored_image(packed_tiff(AV_PIX_FMT_GRAY16LE, 62), "picture")),
               colour = must(decode_stored_image(packed_tiff(AV_PIX_FMT_RGB24, 93), "picture"));
    EXPECT_EQ(grey.pixel_format + deep.pixel_format + colour.pixel_format, "graygray16lergb24");
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 31; ++x) {
            ASSERT_EQ(grey.image.view().sample(x, y), byte(x, y));
            ASSERT_EQ(deep.image.view().sample(x, y), byte(2 * x + 1, y) << 8 | byte(2 * x, y));
            for (int c = 0; c < 3; ++c) ASSERT_EQ(colour.image.view().sample(x, y, c), byte(3 * x + c, y));
        }
}

TEST(Tiff, ReadsGreyStoredAsColour) {
    const auto sixteen = [](bool coloured) {
        return encoded("tiff", AV_PIX_FMT_RGB48LE, 7, 5, [&](AVFrame& frame) {
            for (int y = 0; y < 5; ++y)
                for (int k = 0; k < 42; ++k)
                    frame.data[0][y * frame.linesize[0] + k] =
                        static_cast<std::uint8_t>(coloured     ? k
                                                  : k % 2 == 0 ? 100 * y + k / 6
                                                               : (100 * y + k / 6) >> 8);
        });
    };
    expect_hundreds(decode_stored_image(sixteen(false), "picture"), 7, 5);
    EXPECT_EQ(message(decode_stored_image(sixteen(true), "picture")),
              "picture: is in colour of 16 bits: must be grey, or RGB of 8 bits");
}

TEST(TiffDamage, IsNamed) {
    const LimitedMemory little(64);
    const auto refusal = [](std::size_t width, std::size_t bits, std::size_t format, TiffTag other) {
        auto tags = tiff_tags(width, 16384, bits, format);
        std::erase_if(tags, [&](const TiffTag& tag) { return tag.number == other.number; });
        tags.push_back(std::move(other));
        return message(
            decode_stored_image(tiff_of(false, tags, strip_offsets, strip_sizes, {"abcd"}), "picture"));
    };
    const TiffTag rows{278, {16384}};
    EXPECT_EQ(refusal(16384, 32, 3, rows).find("picture: is damaged: has "), 0U);
    EXPECT_EQ(refusal(16385, 32, 3, rows), "picture: is 16385x16384 pixels: must be from 1x1 to 16384x16384");
    EXPECT_EQ(refusal(1, 12, 1, rows), "picture: has bits a sample 12: must be 8, 16, 32 or 64");
    EXPECT_EQ(refusal(1, 64, 6, rows), "picture: has sample format 6: must be 1 to 4");
    EXPECT_EQ(refusal(1, 8, 1, {277, {5}}), "picture: has samples a pixel 5: must be 1 to 4");
    EXPECT_EQ(refusal(1, 8, 1, {262, {0}}),
              "picture: has photometric interpretation 0: must be 1 (grey, black is 0) or 2 (RGB)");
    EXPECT_EQ(refusal(1, 8, 1, {259, {7}}), "picture: is compressed as JPEG: must be without loss");
    EXPECT_EQ(refusal(1, 8, 1, {274, {6}}),
              "picture: is to be turned, orientation 6: must be 1, the upper left first");
    EXPECT_EQ(refusal(8, 8, 1, rows).find("picture: is damaged: "), 0U);
}

using TiffPages = FolderTest;

TEST_F(TiffPages, AreReadInAnyOrder) {
    for (const bool big : {false, true}) {
        write_bytes(folder / "pages.tif",
                    tiff_pages({even_page(1000), even_page(2000), even_page(3000)}, big));
        const auto stack = must(open_tiff_stack(SourceFile(folder / "pages.tif")));
        ASSERT_TRUE(stack);
        EXPECT_EQ(stack->count(), 3);
        EXPECT_EQ(stack->width() * 100 + stack->height(), 705);
        EXPECT_EQ(stack->left_out(), "");
        for (const int page : {2, 0, 1, 2, 2, 0}) {
            const auto picture = stack->image(page);
            ASSERT_EQ(message(picture), "") << page;
            EXPECT_EQ(picture->image.view().sample(6, 4), 1000 * (page + 1));
        }
        EXPECT_TRUE(is_refused(stack->image(3), "has no page 3: must be from 0 to 2"));
    }
}

TEST_F(TiffPages, AreNullForSinglePage) {
    write_bytes(folder / "page.tif", tiff_pages({even_page(1000)}));
    const auto stack = must(open_tiff_stack(SourceFile(folder / "page.tif")));
    EXPECT_FALSE(stack);
}

TEST_F(TiffPages, LeaveOutOtherSizes) {
    TiffPageOf copy = even_page(9, 3, 2), mask = even_page(1);
    copy.subfile = 1;
    mask.subfile = 4;
    write_bytes(folder / "pages.tif",
                tiff_pages({even_page(1000), copy, mask, even_page(5, 6, 5), even_page(2000)}));
    const auto stack = must(open_tiff_stack(SourceFile(folder / "pages.tif")));
    ASSERT_TRUE(stack);
    EXPECT_EQ(stack->count(), 2);
    EXPECT_EQ(stack->left_out(), "1 page is of another size or kind than the first, and left out");
    const auto last = must(stack->image(1));
    EXPECT_EQ(last.image.view().sample(0, 0), 2000);
}

TEST_F(TiffPages, BecomeFloatsIfOneIs) {
    write_bytes(folder / "pages.tif", tiff_pages({even_page(7, 7, 5, 32), even_page(70'000, 7, 5, 32)}));
    const auto stack = must(open_tiff_stack(SourceFile(folder / "pages.tif")));
    const auto first = must(stack->image(0)), second = must(stack->image(1));
    ASSERT_EQ(first.values.size(), 35U);
    EXPECT_EQ(first.values[0], 7);
    EXPECT_EQ(second.values.at(0), 70'000);
}

TEST_F(TiffPages, RefuseDamagedList) {
    const auto refusal = [&](std::uint32_t behind_last) {
        write_bytes(folder / "pages.tif", tiff_pages({even_page(1), even_page(2)}, false, behind_last));
        return message(open_tiff_stack(SourceFile(folder / "pages.tif")));
    };
    EXPECT_TRUE(has_words(refusal(8), "pages.tif: is damaged: its list of pages is cut")) << "a circle";
    EXPECT_TRUE(has_words(refusal(100'000), "is damaged: its list of pages is cut"));
}

}  // namespace
}  // namespace touchable::test
