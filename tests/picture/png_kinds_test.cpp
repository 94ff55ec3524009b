// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/limits.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

Result<Image> read_png(const TemporaryFolder& folder, const std::string& bytes) {
    std::filesystem::remove(folder / "image.png");
    write_bytes(folder / "image.png", bytes);
    return read_image(folder / "image.png");
}

/// Rows of bytes that are all different from one another, each after filter number 0.
std::string rows_of(int row_bytes, int rows) {
    std::string bytes;
    for (int y = 0; y < rows; ++y) {
        bytes += '\0';
        for (int k = 0; k < row_bytes; ++k) bytes += static_cast<char>(7 * k + 13 * y + 1);
    }
    return bytes;
}

using PngKinds = FolderTest;

TEST_F(PngKinds, KeepsGreyOfFewBits) {
    for (const int bits : {2, 4}) {
        const std::string rows = rows_of(6 * bits, 5);
        const auto image = read_png(folder, raw_png({48, 5, bits}, rows));
        ASSERT_EQ(message(image), "") << bits;
        ASSERT_EQ(image->channels, 1);
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 48; ++x) {
                const int byte = static_cast<unsigned char>(
                    rows[static_cast<std::size_t>(y * (6 * bits + 1) + 1 + x * bits / 8)]);
                const int stored = byte >> (8 - bits - x * bits % 8) & ((1 << bits) - 1);
                ASSERT_EQ(image->view().sample(x, y), stored) << bits << " bits, " << x << "," << y;
            }
    }
}

/// Wide enough for rows to be whole pages of memory, and more of them than are copied at once.
TEST_F(PngKinds, KeepsLargePictures) {
    constexpr int width = 3000, height = 150;
    const std::string palette = png_chunk("PLTE", rows_of(3 * 256, 1).substr(1));
    struct Case {
        int bits, type, stored, channels;
        std::string others;
    };
    for (const Case& c :
         {Case{8, 0, 1, 1, ""}, Case{16, 0, 1, 1, ""}, Case{8, 2, 3, 3, ""}, Case{8, 3, 1, 3, palette},
          Case{8, 4, 2, 1, ""}, Case{16, 4, 2, 1, ""}, Case{8, 6, 4, 3, ""}}) {
        const int step = c.bits / 8 * c.stored;
        const std::string rows = rows_of(step * width, height);
        const auto byte = [&](int y, int k) {
            return static_cast<unsigned char>(
                rows[static_cast<std::size_t>(y) * static_cast<std::size_t>(step * width + 1) + 1 +
                     static_cast<std::size_t>(k)]);
        };
        const auto image = read_png(folder, raw_png({width, height, c.bits, c.type}, rows, true, c.others));
        ASSERT_EQ(message(image), "") << c.type;
        ASSERT_EQ(image->channels, c.channels);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int channel = 0; channel < c.channels; ++channel) {
                    const int at = step * x + channel;
                    const int sample = c.type == 3    ? (7 * (3 * byte(y, x) + channel) + 1) & 255
                                       : c.bits == 16 ? byte(y, at) << 8 | byte(y, at + 1)
                                                      : byte(y, at);
                    ASSERT_EQ(image->view().sample(x, y, channel), sample) << c.type << " " << x << "," << y;
                }
    }
}

TEST_F(PngKinds, RefusesChunkBeforeHeader) {
    std::string png = raw_png({48, 5, 4}, rows_of(24, 5));
    constexpr std::size_t signature = 8;
    png.insert(signature, png_chunk("prVt", std::string(13, '\0')));
    EXPECT_TRUE(is_refused(read_png(folder, png), "must begin with its header, IHDR"));
}

/// A row of 16 indices of so many bits, and a palette.
std::string indexed_png(int bits, const std::vector<int>& indices, int colours,
                        const std::string& more = "") {
    std::string row(1, '\0');
    int byte = 0, filled = 0;
    for (const int index : indices) {
        byte = byte << bits | index;
        filled += bits;
        if (filled < 8) continue;
        row += static_cast<char>(byte);
        byte = filled = 0;
    }
    std::string palette;
    for (int k = 0; k < colours; ++k)
        for (const int sample : {200 - k, 7 * k, 3 * k + 1}) palette += static_cast<char>(sample);
    return raw_png({static_cast<int>(indices.size()), 1, bits, 3}, row, true,
                   png_chunk("PLTE", palette) + more);
}

TEST_F(PngKinds, ReadsPalettesOfAnyBits) {
    for (const int bits : {1, 2, 4, 8})
        for (const std::string& more : {std::string(), png_chunk("tRNS", std::string("\0\x80", 2))}) {
            std::vector<int> indices;
            for (int k = 0; k < 16; ++k) indices.push_back(k % std::min(1 << bits, 11));
            const auto image = read_png(folder, indexed_png(bits, indices, std::min(1 << bits, 11), more));
            ASSERT_EQ(message(image), "") << bits;
            ASSERT_EQ(image->channels, 3);
            for (int x = 0; x < 16; ++x) {
                const int k = indices[static_cast<std::size_t>(x)];
                EXPECT_EQ(image->view().sample(x, 0, 0), 200 - k) << bits << ", " << x;
                EXPECT_EQ(image->view().sample(x, 0, 1), 7 * k) << bits << ", " << x;
                EXPECT_EQ(image->view().sample(x, 0, 2), 3 * k + 1) << bits << ", " << x;
            }
        }
}

TEST_F(PngKinds, RefusesIndexBeyondPalette) {
    for (const int bits : {1, 2, 4, 8}) {
        std::vector<int> indices(16);
        indices[13] = 1;
        EXPECT_EQ(message(read_png(folder, indexed_png(bits, indices, 2))), "");
        EXPECT_EQ(message(read_png(folder, indexed_png(bits, indices, 1))),
                  (folder / "image.png").string() +
                      ": is damaged: a pixel has colour 1 of its palette, which has 1");
    }
    EXPECT_NE(message(read_png(folder, indexed_png(8, std::vector<int>(16), 0))), "");
    EXPECT_NE(message(read_png(folder, raw_png({1, 1, 8, 3}, std::string(2, '\0')))), "") << "no palette";
}

TEST_F(PngKinds, HoldsLargePicturesOnce) {
    constexpr int width = 4096, height = 3000;
    constexpr double picture = 3.0 * width * height / (1 << 20);
    write_bytes(folder / "image.png",
                raw_png({width, height, 8, 2}, std::string((3 * width + 1) * height, '\0')));
    const PeakMemory memory;
    const auto image = must(read_image(folder / "image.png"));
    // The file and the decoder's copy of it, which are as large here, beside it.
    EXPECT_LT(memory.mebibytes(), 3 * picture + picture / 3);
}

/// A folder of one depth picture of 4 bits, and a colour picture that is the same.
std::string refusal_of_four_bits(const std::string& depth, std::vector<RawFrame>* frames = nullptr) {
    const TemporaryFolder folder;
    write_bytes(folder / "d.png", raw_png({48, 5, 4}, rows_of(24, 5)));
    write_bytes(
        folder / "scene.json",
        R"({"touchable_scene": 1, "width": 48, "height": 5, "camera": {"fx": 50, "fy": 50, "cx": 24, "cy": 2},
                    "depth": )" +
            depth + R"(, "folder": {"depth": "d.png", "colour": "d.png"}})");
    auto reader = open_clip(folder / "scene.json");
    if (!reader) return reader.error().message;
    auto read = read_all(**reader);
    if (frames && read) *frames = *read;
    return message(read);
}

TEST_F(PngKinds, RefusesTooFewBits) {
    EXPECT_TRUE(has_words(refusal_of_four_bits(R"({"coding": "linear", "near": 10, "far": 20})"),
                          "is 4-bit grey, but the scene's depth.code_max is 255: must be at most 15"));
    EXPECT_EQ(refusal_of_four_bits(R"({"coding": "linear", "near": 10, "far": 20, "code_max": 15})"), "");
    std::vector<RawFrame> frames;
    EXPECT_EQ(refusal_of_four_bits(R"({"coding": "metric", "scale": 1, "far": 20, "bits": 8})", &frames), "");
    ASSERT_EQ(frames.size(), 1U);
    for (int x = 0; x < 48; ++x)  // colour is for the eye: white is white
        ASSERT_EQ(frames[0].colour.sample(x, 1, 2), 17 * frames[0].depth.sample(x, 1)) << x;
}

TEST_F(PngKinds, RefusesDataThatEndEarly) {
    const std::string palette = png_chunk("PLTE", std::string(3 * 256, '\x55'));
    const std::string transparent = png_chunk("tRNS", std::string(2, '\0'));
    struct Case {
        PngKind kind;
        int row_bytes;
        std::string others;
    };
    for (const auto& [kind, row_bytes, others] :
         {Case{{20, 9}, 20, ""}, Case{{20, 9, 16}, 40, ""}, Case{{20, 9, 8, 2}, 60, ""},
          Case{{20, 9, 4}, 10, ""}, Case{{20, 9, 2}, 5, ""}, Case{{1, 9}, 1, ""},
          Case{{20, 9, 8, 3}, 20, palette}, Case{{20, 9, 8, 0}, 20, transparent},
          Case{{20, 9, 16, 0}, 40, transparent}}) {
        const std::string rows = rows_of(row_bytes, 9);
        ASSERT_EQ(message(read_png(folder, raw_png(kind, rows, true, others))), "") << kind.bits;
        for (std::size_t length = 0; length < rows.size(); ++length)
            for (const bool ended : {true, false})
                ASSERT_NE(message(read_png(folder, raw_png(kind, rows.substr(0, length), ended, others))), "")
                    << length << " of " << rows.size() << " bytes, bits " << kind.bits << ", kind "
                    << kind.colour;
    }
}

TEST_F(PngKinds, ReadsInterlacedColourOnly) {
    // 4x1: passes 1 (pixel 0), 4 (pixel 2) and 6 (pixels 1 and 3).
    write_bytes(folder / "i.png", raw_png({4, 1, 8, 0, 1}, std::string("\0\x0a\0\x0c\0\x0b\x0d", 7)));
    const auto image = must(read_image(folder / "i.png"));
    EXPECT_EQ(image.samples, (Samples{10, 11, 12, 13}));
    write_bytes(folder / "d.png", raw_png({4, 1}, std::string("\0\x0a\x0b\x0c\x0d", 5)));
    Scene scene = small_scene(4, 1);
    scene.folder = FolderSource{.depth = "d.png", .colour = "i.png", .haptic = "", .height = ""};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    EXPECT_EQ(message(open_clip(folder / "scene.json")), "");
    scene.folder->depth = "i.png";
    write_bytes(folder / "scene.json", scene_to_json(scene));
    EXPECT_TRUE(is_refused(open_clip(folder / "scene.json"), "i.png (depth, frame 0): is an interlaced PNG"));
}

/// Deflated with fixed codes: zeros, 258 at a time.
std::string packed_zeros(std::size_t count) {
    std::string packed("\x78\x01", 2);
    unsigned byte = 0, used = 0;
    const auto put = [&](unsigned bits, int length) {  // the first one is the highest
        for (int k = length; k-- > 0;) {
            byte |= (bits >> k & 1U) << used;
            if (++used < 8) continue;
            packed += static_cast<char>(byte);
            byte = used = 0;
        }
    };
    put(0b110, 3);       // the last block, of fixed codes
    put(0b00110000, 8);  // a zero
    std::size_t there = 1;
    for (; there < count; there += 258) put(0b1100010100000, 13);  // 258 more, as the one before
    put(0, 7 + 7);  // the end of the block; of its byte the rest
    // Adler-32 of zeros: one sum stays 1, the other counts them.
    return packed + big_endian((there % 65521) << 16U | 1, 4);
}

/// FFmpeg would unpack all of it: time that no picture needs.
TEST_F(PngKinds, RefusesDataBehindPixels) {
    const std::string rows = rows_of(8, 4);
    EXPECT_EQ(message(read_png(folder, raw_png({4, 4, 16}, rows + std::string(60'000, '\0')))), "");
    const std::string refusal =
        message(read_png(folder, raw_png({4, 4, 16}, rows + std::string(70'000, '\0'))));
    EXPECT_TRUE(has_words(refusal, "is damaged: has 700"));
    EXPECT_TRUE(has_words(refusal, " bytes of data for 16 pixels"));
}

TEST_F(PngKinds, PassesOverPackedTexts) {
    const std::string rows = rows_of(8, 4), bomb = std::string("a\0\0", 3) + packed_zeros(256U << 20U);
    for (const char* name : {"zTXt", "iCCP"}) {
        const std::string png = raw_png({4, 4, 16}, rows, true, png_chunk(name, bomb));
        const LimitedMemory limit(64);
        EXPECT_EQ(message(read_png(folder, png)), "") << name;
    }
}

TEST_F(PngKinds, WritesSquarePixels) {
    const std::uint8_t grey = 7;
    ASSERT_TRUE(write_png(folder / "image.png", PlaneView{&grey, 1, 1, 1, 1, 1}));
    const std::string bytes = read_bytes(folder / "image.png");
    const auto shape = bytes.find("pHYs");
    if (shape == std::string::npos) return;  // which means that they are square, too
    EXPECT_EQ(bytes.substr(shape + 4, 8), std::string("\0\0\0\1\0\0\0\1", 8));
}

}  // namespace
}  // namespace touchable::test
