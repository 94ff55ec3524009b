// SPDX-License-Identifier: Apache-2.0
#include "engine/clip/track_codecs.hpp"

#include <zstd.h>

#include <set>

#include "tests/clip/clip_fixture.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

using enum RankMode;
using Version = RankZstdDecoder::Version;
using Wide = std::vector<std::uint16_t>;

constexpr RankMode all_modes[] = {samples_by_gradient, ranks_by_left, ranks_by_gradient};
constexpr int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {2, 2}, {53, 37}, {300, 200}};

// The format once more, as plainly as it can be said: engine/clip/track_codecs.hpp.

Samples split(const std::vector<int>& numbers) {
    Samples bytes;
    for (const int number : numbers) bytes.push_back(static_cast<std::uint8_t>(number % 256));
    for (const int number : numbers) bytes.push_back(static_cast<std::uint8_t>(number / 256));
    return bytes;
}

std::vector<int> values_of(const PlaneView& plane) {
    std::vector<int> values;
    for (int y = 0; y < plane.height; ++y)
        for (int x = 0; x < plane.width; ++x) values.push_back(plane.sample(x, y));
    return values;
}

Samples plain_codes(const std::vector<int>& values, int width, bool by_left) {
    const auto at = [&](int x, int y) {
        return x < 0 || y < 0 ? 0 : values[static_cast<std::size_t>(y * width + x)];
    };
    std::vector<int> codes;
    for (int n = 0; n < static_cast<int>(values.size()); ++n) {
        const int x = n % width, y = n / width;
        const int gradient = at(x - 1, y) + at(x, y - 1) - at(x - 1, y - 1);
        const int left = x > 0 ? at(x - 1, y) : at(x, y - 1);
        int difference = ((at(x, y) - (by_left ? left : gradient)) % 65536 + 65536) % 65536;
        if (difference >= 32768) difference -= 65536;
        codes.push_back(difference >= 0 ? 2 * difference : -2 * difference - 1);
    }
    return split(codes);
}

Samples joined(Samples first, const Samples& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

Samples compressed(const Samples& content) {
    Samples frame(ZSTD_compressBound(content.size()));
    frame.resize(ZSTD_compress(frame.data(), frame.size(), content.data(), content.size(), 1));
    return frame;
}

/// A packet's bytes before its frame of zstd, and in it.
struct Parts {
    Samples head, content;
    Samples packet() const { return joined(head, compressed(content)); }
};

Parts plain_parts(const PlaneView& plane, RankMode mode) {
    const std::vector<int> values = values_of(plane);
    const auto number = static_cast<std::uint8_t>(mode);
    if (mode == samples_by_gradient) return {{number}, plain_codes(values, plane.width, false)};
    const std::set<int> sorted(values.begin(), values.end());
    const std::vector<int> distinct(sorted.begin(), sorted.end());
    std::vector<int> steps, ranks;
    int next = 0;
    for (const int value : distinct) {
        steps.push_back(value - next);
        next = value + 1;
    }
    for (const int value : values) {
        const auto place = std::lower_bound(distinct.begin(), distinct.end(), value);
        ranks.push_back(static_cast<int>(place - distinct.begin()));
    }
    const int last = static_cast<int>(distinct.size()) - 1;
    return {{number, static_cast<std::uint8_t>(last % 256), static_cast<std::uint8_t>(last / 256)},
            joined(split(steps), plain_codes(ranks, plane.width, mode == ranks_by_left))};
}

/// A plane's packet, by an encoder that saw no other.
Samples packet_of(const PlaneView& plane) {
    RankEncoder encoder(zstd_at(1));
    const auto packet = encoder.encode(plane, true);
    return {packet.begin(), packet.end()};
}

PlaneView view_of(const Wide& samples, int width, int height) {
    return {reinterpret_cast<const std::uint8_t*>(samples.data()),
            std::ptrdiff_t{2} * width,
            width,
            height,
            2,
            1};
}

/// Decodes into rows that are one sample apart, of which none may be written.
bool decodes(RankZstdDecoder& decoder, std::span<const std::uint8_t> packet, int width, int height,
             Wide& samples) {
    constexpr std::uint16_t mark = 0xBEEF;
    const std::size_t stride = static_cast<std::size_t>(width) + 1;
    Wide padded(stride * static_cast<std::size_t>(height), mark);
    const bool good =
        decoder.decode(packet, width, height, padded.data(), static_cast<std::ptrdiff_t>(stride));
    samples.clear();
    for (std::size_t at = 0; at < padded.size(); at += stride) {
        EXPECT_EQ(padded[at + stride - 1], mark);
        samples.insert(samples.end(), &padded[at], &padded[at + stride - 1]);
    }
    return good;
}

/// A ball before a slope, with a wall of few values at the right.
constexpr int golden_width = 20, golden_height = 14;
Wide golden_picture() {
    Wide samples;
    for (int y = 0; y < golden_height; ++y)
        for (int x = 0; x < golden_width; ++x) {
            const bool in_ball = (x - 4) * (x - 4) + (y - 6) * (y - 6) < 9;
            const int behind = x > 14 ? 65535 - 700 * y : 1000 + 131 * ((x * x + y * y) / 16);
            samples.push_back(static_cast<std::uint16_t>(in_ball ? 0 : behind));
        }
    return samples;
}

Samples from_hex(std::string_view text) {
    Samples bytes;
    for (std::size_t at = 0; at < text.size(); at += 2)
        bytes.push_back(static_cast<std::uint8_t>(std::stoi(std::string(text.substr(at, 2)), nullptr, 16)));
    return bytes;
}

/// Packets of every released version are read for ever. A later version needs another FourCC, not another
/// hex.
constexpr const char* golden_first =
    "28b52ffd603001dd0400d245101aa027690ca3ebd8faffff2faeebffffff2feef546edfc262844a6bf830c5405812a4049d2"
    "39094444f503b1d994c62ee30f9bcd17e7286e366b6858282bbb27022d200083992a1de0c07938922fd828170e2440b90640"
    "1607270673d819b024a005d90e9a7cdac27c04867b385c83d696274070e58a0d3cb631c201254417940b029d18ca617fc07a"
    "033580b1a7174c420cb887bb6e8311";
constexpr const char* golden_by_left =
    "01240028b52ffd607a01650400d2c40f1ba0458d01ffb946fdff68ffffbd4acbaaaa6c557b09645b5bc9d452c3dfa7ba1872"
    "72a8160a532516435539f3b2593adff70319ddb7ab030c149ca4a65ac0210016b9028b8581a5a67a2561e7aad1e300b2bb99"
    "18a4f0a101c017e402e3825c37c75d2a39b06833b8f1c6828038c93936fba02800e7031903496e1a005283b68083006f008e"
    "786008";
constexpr const char* golden_by_gradient =
    "02240028b52ffd607a0185030052c40b15c0258d01ffbaebffcdab8afbd25f19f18bc89d520af9b943dc0d55bb95904972df"
    "332be6b9ab0119e9304a5002051c00153905000e58d898b9e0082ccc610eae18190e8084982e007201816e460011a472b034"
    "060c062996212e778001030f03d7a02de020c01b80231e1802";

TEST(RankZstd, ReadsGoldenPackets) {
    const std::string first = golden_first;
    const std::pair<Version, std::string> packets[] = {{Version::first, first},
                                                       {Version::second, "00" + first},
                                                       {Version::second, golden_by_left},
                                                       {Version::second, golden_by_gradient}};
    for (const auto& [version, hex] : packets) {
        RankZstdDecoder decoder(version);
        Wide samples;
        ASSERT_TRUE(decodes(decoder, from_hex(hex), golden_width, golden_height, samples));
        EXPECT_EQ(samples, golden_picture());
    }
}

/// The same picture, written by a program that knew no other version.
TEST(RankZstd, ReadsClipOfFirstVersion) {
    auto reader = must(open_clip(TOUCHABLE_SOURCE_DIR "/tests/data/clip_t3dz.mkv"));
    EXPECT_EQ(reader->tracks().at(0).codec, "t3dz");
    const auto frame = must(reader->next());
    const Wide expected = golden_picture();
    EXPECT_TRUE(same_plane(frame->depth, view_of(expected, golden_width, golden_height)));
}

/// Pictures of which each mode is the smallest, and others.
struct Picture {
    const char* name;
    int (*sample)(int x, int y, Random& numbers);
    std::optional<RankMode> smallest;
};
constexpr Picture pictures[] = {
    {"slope", [](int x, int y, Random&) { return 1000 + 3 * x + 2 * y + x * y / 50; }, samples_by_gradient},
    {"millimetres",
     [](int x, int y, Random& numbers) { return (40 + x / 60 + y / 50 + numbers.below(4) / 3) * 1300; },
     ranks_by_left},
    {"stretched bowl",
     [](int x, int y, Random& numbers) { return (x * x + y * y + 60 * numbers.below(2)) / 90 * 43; },
     ranks_by_gradient},
    {"bowl with gaps, where ranks save too little",
     [](int x, int y, Random& numbers) {
         const int value = (x * x + y * y + 60 * numbers.below(2)) / 90;
         return value + (value > 400 ? 3 : 0) + (value > 700 ? 2 : 0);
     },
     samples_by_gradient},
    {"noise", [](int, int, Random& numbers) { return numbers.below(65536); }, samples_by_gradient},
    {"one value", [](int, int, Random&) { return 65535; }, std::nullopt},
};

Wide samples_of(const Picture& picture, int width, int height) {
    Wide samples;
    Random numbers(3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            samples.push_back(static_cast<std::uint16_t>(picture.sample(x, y, numbers)));
    return samples;
}

TEST(RankZstd, EncodesAsDefined) {
    for (const auto& [width, height] : sizes)
        for (const Picture& picture : pictures) {
            const Wide samples = samples_of(picture, width, height);
            const PlaneView plane = view_of(samples, width, height);
            const Samples packet = packet_of(plane);
            const auto mode = static_cast<RankMode>(packet.at(0));
            const Parts expected = plain_parts(plane, mode);
            ASSERT_EQ(Samples(packet.begin(), packet.begin() + std::ssize(expected.head)), expected.head);
            const auto frame = std::span(packet).subspan(expected.head.size());
            Samples content(expected.content.size());
            ASSERT_EQ(ZSTD_getFrameContentSize(frame.data(), frame.size()), content.size());
            ASSERT_EQ(ZSTD_decompress(content.data(), content.size(), frame.data(), frame.size()),
                      content.size());
            EXPECT_EQ(content, expected.content) << picture.name << ", " << width << "x" << height;
        }
}

TEST(RankZstd, ChoosesSmallestMode) {
    for (const Picture& picture : pictures) {
        const Wide samples = samples_of(picture, 300, 200);
        const PlaneView plane = view_of(samples, 300, 200);
        std::size_t least_ranked = SIZE_MAX;
        for (const RankMode mode : {ranks_by_left, ranks_by_gradient})
            least_ranked = std::min(least_ranked, plain_parts(plane, mode).packet().size());
        const std::size_t plain = plain_parts(plane, samples_by_gradient).packet().size();
        const Samples packet = packet_of(plane);
        EXPECT_EQ(packet.size(), least_ranked + plain / 64 < plain ? least_ranked : plain) << picture.name;
        const auto mode = static_cast<RankMode>(packet.at(0));
        EXPECT_EQ(mode, picture.smallest.value_or(mode)) << picture.name;
    }
}

TEST(RankZstd, KeepsModeUntilPacketsGrow) {
    constexpr int width = 300, height = 200;
    const Wide few = samples_of(pictures[1], width, height), slope = samples_of(pictures[0], width, height),
               noise = samples_of(pictures[4], width, height);
    RankEncoder encoder(zstd_at(1));
    const auto mode_of = [&](const Wide& samples, bool choose) {
        return static_cast<RankMode>(encoder.encode(view_of(samples, width, height), choose)[0]);
    };
    EXPECT_EQ(mode_of(few, false), ranks_by_left) << "the first is chosen for in any case";
    Wide other = few;
    other[9999] = 77;
    EXPECT_EQ(mode_of(other, false), ranks_by_left);
    EXPECT_EQ(mode_of(noise, false), samples_by_gradient) << "a larger packet asks anew";
    EXPECT_EQ(mode_of(few, false), samples_by_gradient) << "no smaller one does";
    EXPECT_EQ(mode_of(few, true), ranks_by_left);
    EXPECT_EQ(mode_of(slope, true), samples_by_gradient);
    RankZstdDecoder decoder(Version::second);
    Wide again;
    for (const Wide& samples : {few, noise, slope, other}) {
        const auto packet = encoder.encode(view_of(samples, width, height), false);
        ASSERT_TRUE(decodes(decoder, packet, width, height, again));
        EXPECT_EQ(again, samples);
    }
}

TEST(RankZstd, RoundTripsEveryMode) {
    RankZstdDecoder decoder(Version::second), first(Version::first);  // of all sizes, one after the other
    for (const auto& [width, height] : sizes)
        for (const int largest : {65535, 4095, 1, 0}) {
            Samples memory;
            const PlaneView plane = test_plane(memory, width, height, 2, 1, largest, 7, true);
            const std::vector<int> values = values_of(plane);
            const Wide expected(values.begin(), values.end());
            Wide samples;
            ASSERT_TRUE(decodes(decoder, packet_of(plane), width, height, samples));
            EXPECT_EQ(samples, expected) << width << "x" << height;
            for (const RankMode mode : all_modes) {
                ASSERT_TRUE(decodes(decoder, plain_parts(plane, mode).packet(), width, height, samples));
                EXPECT_EQ(samples, expected) << width << "x" << height;
            }
            const Samples old = compressed(plain_parts(plane, samples_by_gradient).content);
            ASSERT_TRUE(decodes(first, old, width, height, samples));
            EXPECT_EQ(samples, expected) << width << "x" << height;
        }
}

TEST(RankZstd, RoundTripsAllValues) {
    Wide all(65536);
    for (std::size_t n = 0; n < all.size(); ++n) all[n] = static_cast<std::uint16_t>(n * 40503);
    RankZstdDecoder decoder(Version::second);
    for (const RankMode mode : all_modes) {
        Wide samples;
        const Parts parts = plain_parts(view_of(all, 256, 256), mode);
        ASSERT_TRUE(decodes(decoder, parts.packet(), 256, 256, samples));
        EXPECT_EQ(samples, all);
    }
}

TEST(RankZstd, RejectsOtherSizes) {
    Samples memory;
    const PlaneView plane = test_plane(memory, 24, 16, 2, 1, 99, 1, true);
    for (const RankMode mode : all_modes) {
        const Parts parts = plain_parts(plane, mode);
        const Samples packet = parts.packet(), twice = joined(packet, compressed(parts.content));
        Samples unsized(1000);  // a frame that does not say what it holds
        ZSTD_CCtx* context = ZSTD_createCCtx();
        ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
        unsized.resize(ZSTD_compress2(context, unsized.data(), unsized.size(), parts.content.data(),
                                      parts.content.size()));
        ZSTD_freeCCtx(context);
        RankZstdDecoder decoder(Version::second), first(Version::first);
        EXPECT_TRUE(decoder.promises(packet, 24 * 16));
        EXPECT_FALSE(decoder.promises(packet, 24 * 17));
        Wide samples;
        EXPECT_FALSE(decodes(decoder, packet, 24, 17, samples));
        EXPECT_FALSE(decodes(decoder, packet, 23, 16, samples));
        EXPECT_FALSE(decodes(decoder, twice, 24, 16, samples));
        EXPECT_FALSE(decodes(decoder, twice, 24, 32, samples));
        EXPECT_FALSE(decodes(decoder, joined(parts.head, unsized), 24, 16, samples));
        EXPECT_FALSE(decodes(decoder, {}, 24, 16, samples));
        EXPECT_FALSE(decodes(first, packet, 24, 16, samples)) << "is not of the first version";
        EXPECT_TRUE(decodes(decoder, packet, 24, 16, samples));  // as good as before
    }
}

/// Packets of 2x2 samples whose frame of zstd is whole.
TEST(RankZstd, RejectsInvalidContent) {
    RankZstdDecoder decoder(Version::second);
    Wide samples;
    const auto is_taken = [&](const Samples& head, const std::vector<int>& steps,
                              const std::vector<int>& codes) {
        const Samples content = joined(split(steps), split(codes));
        return decodes(decoder, joined(head, compressed(content)), 2, 2, samples);
    };
    EXPECT_TRUE(is_taken({1, 1, 0}, {7, 3}, {0, 2, 0, 0}));
    EXPECT_EQ(samples, (Wide{7, 11, 7, 7}));
    EXPECT_TRUE(is_taken({1, 1, 0}, {7, 65527}, {0, 2, 0, 0})) << "65535 is the largest sample";
    EXPECT_FALSE(is_taken({1, 1, 0}, {7, 65528}, {0, 2, 0, 0})) << "a value beyond it";
    EXPECT_FALSE(is_taken({1, 1, 0}, {7, 3}, {0, 4, 3, 0})) << "a rank of 2 of 2 values";
    EXPECT_FALSE(is_taken({1, 1, 0}, {7, 3}, {0, 0, 0, 1})) << "a rank of -1";
    EXPECT_FALSE(is_taken({2, 1, 0}, {7, 3}, {0, 2, 2, 0})) << "a rank of 2, in the last place";
    EXPECT_TRUE(is_taken({1, 3, 0}, {0, 0, 0, 0}, {0, 2, 2, 2}));
    EXPECT_FALSE(is_taken({1, 4, 0}, {0, 0, 0, 0, 0}, {0, 2, 2, 2})) << "more values than samples";
    EXPECT_FALSE(is_taken({1, 0, 1}, {0, 0, 0, 0}, {0, 2, 2, 2})) << "257 values";
    EXPECT_FALSE(is_taken({3, 1, 0}, {7, 3}, {0, 2, 0, 0})) << "no such mode";
    EXPECT_FALSE(is_taken({0}, {7, 3}, {0, 2, 0, 0})) << "mode 0 has no dictionary";
    EXPECT_TRUE(is_taken({0}, {}, {0, 2, 0, 0}));
    for (const Samples& head : {Samples{1}, Samples{1, 0}, Samples{2, 0, 0}, Samples{0}})
        EXPECT_FALSE(decodes(decoder, head, 2, 2, samples)) << "no frame follows";
}

TEST(RankZstd, SurvivesCutAndChangedPackets) {
    const std::string by_gradient = "00" + std::string(golden_first);
    for (const std::string& hex :
         {by_gradient, std::string(golden_by_left), std::string(golden_by_gradient)}) {
        const Samples whole = from_hex(hex);
        RankZstdDecoder decoder(Version::second);
        Wide samples;
        for (std::size_t length = 0; length < whole.size(); ++length)
            EXPECT_FALSE(
                decodes(decoder, std::span(whole).first(length), golden_width, golden_height, samples))
                << length;
        std::size_t refused = 0, tried = 0;
        for (std::size_t at = 0; at < whole.size(); ++at)
            for (std::size_t change = 1; change < 256; change += sweep_step(), ++tried) {
                Samples changed = whole;
                changed[at] = static_cast<std::uint8_t>(changed[at] ^ change);
                refused += decodes(decoder, changed, golden_width, golden_height, samples) ? 0 : 1;
            }
        EXPECT_GT(refused, tried / 3);
        EXPECT_TRUE(decodes(decoder, whole, golden_width, golden_height, samples));
        EXPECT_EQ(samples, golden_picture());
    }
}

}  // namespace
}  // namespace touchable::test
