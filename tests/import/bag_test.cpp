// SPDX-License-Identifier: Apache-2.0
// Recordings of ROS 1: written by librosbag-storage 1.15.15 of Debian 12 (tests/fuzz/seeds/bag, without
// definitions of messages), and by a writer of the tests' own.

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/import/bag_bytes.hpp"
#include "tests/limits.hpp"
#include "tests/picture/results.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr const char* of_images = "sensor_msgs/Image";
constexpr const char* of_cameras = "sensor_msgs/CameraInfo";
constexpr const char* of_compressed = "sensor_msgs/CompressedImage";

std::filesystem::path kept_bag(const std::string& name) {
    return std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds/bag" / name;
}

struct OpenedBag {
    std::unique_ptr<ClipReader> reader;
    std::vector<RawFrame> frames;
};
OpenedBag opened_bag(const std::filesystem::path& file, const SourceDescription& known = {}) {
    auto [clip, frames] = must_read(open_clip(file, std::nullopt, known));
    return {std::move(clip), std::move(frames)};
}

/// Every pixel's point is where an unprojection written here has it, given its depth in metres.
void expect_geometry(const Scene& scene, const PlaneView& depth, const Camera& camera, double tolerance,
                     const std::function<double(int, int)>& metres) {
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) {
            const double z = metres(x, y);
            const std::uint16_t code = depth.sample(x, y);
            ASSERT_EQ(scene.depth.is_valid(code), z > 0) << x << ", " << y;
            if (!(z > 0)) continue;
            ASSERT_TRUE(is_at(scene, code, camera, x, y, z, tolerance));
        }
}

/// Codes of the kept bags.
int written_code(int n, int x, int y) {
    return 500 + 10 * n + 3 * x + 40 * y;
}
/// The colour camera of realsense_lz4.bag: 24 and 25 pixels, 15 mm to the left, turned by 0.002 about its
/// axis.
void expect_registered_colour(const PlaneView& colour, int n) {
    int inside = 0;
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 16; ++x) {
            const double z = 0.00025 * written_code(n, x, y), px = (x - 7.75) / 20 * z,
                         py = (y - 5.25) / 21 * z;
            const double u = 24 * (px - 0.002 * py + 0.015) / z + 7.75, v = 25 * (py + 0.002 * px) / z + 5.25;
            const bool is_inside = u > -0.49 && v > -0.49 && u < 15.49 && v < 11.49;
            const bool is_certain = std::abs(u + 0.5 - std::round(u + 0.5)) > 0.01 &&
                                    std::abs(v + 0.5 - std::round(v + 0.5)) > 0.01;
            if (!is_inside || !is_certain) continue;
            ++inside;
            ASSERT_EQ(colour.sample(x, y, 0), 10 * n + std::lround(u)) << x << ", " << y;
            ASSERT_EQ(colour.sample(x, y, 1), 2 * std::lround(v)) << x << ", " << y;
        }
    EXPECT_GT(inside, 80);
}

using Bag = FolderTest;

TEST_F(Bag, ReadsRealSense) {
    const auto [reader, frames] = opened_bag(kept_bag("realsense_lz4.bag"));
    ASSERT_EQ(frames.size(), 3U);
    const Scene& scene = reader->scene();
    EXPECT_EQ(scene.rate.num, 15);
    EXPECT_EQ(scene.depth.scale, 0.00025);
    EXPECT_EQ(scene.metres_per_unit, 1);
    for (int n = 0; n < 3; ++n) {
        const RawFrame& frame = frames[static_cast<std::size_t>(n)];
        expect_registered_colour(frame.colour, n);
        expect_geometry(scene, frame.depth, {20, 21, 7.75, 5.25}, 1e-7,
                        [&](int x, int y) { return 0.00025 * written_code(n, x, y); });
    }
    EXPECT_TRUE(is_noted(*reader, "the camera is that of /device_0/sensor_0/Depth_0/info/camera_info"));
    EXPECT_TRUE(is_noted(*reader, "a code is 0.25 mm, as the camera's Depth Units say"));
    EXPECT_TRUE(is_noted(*reader, "colour is brought onto depth's pixels"));
    EXPECT_EQ(reader->inputs(), std::vector{kept_bag("realsense_lz4.bag")});
}

TEST_F(Bag, PrefersAlignedDepth) {
    const auto [reader, frames] = opened_bag(kept_bag("depth_plain.bag"));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[1].depth.sample(3, 2), written_code(1, 3, 2));
    EXPECT_TRUE(frames[0].colour.empty());
    EXPECT_TRUE(is_noted(*reader, "depth is /camera/aligned_depth_to_color/image_raw, there is no colour"));
    EXPECT_TRUE(is_noted(*reader, "/camera/depth/image_rect_raw is depth as well, and is left out"));
    EXPECT_TRUE(is_noted(*reader, "guessed: the camera sees 60 degrees"));
}

TEST_F(Bag, KeepsStatedCameraAndUnit) {
    SourceDescription known;
    known.intrinsics = Intrinsics{.fx = 33, .fy = 34};
    known.metres_per_code = 0.002;
    const auto [reader, frames] = opened_bag(kept_bag("realsense_lz4.bag"), known);
    EXPECT_EQ(reader->scene().camera.fx, 33);
    EXPECT_EQ(reader->scene().depth.scale, 0.002);
}

/// A picture of 8 x 6, all of one pixel.
ImageMessage even_picture(const std::string& encoding, const std::string& pixel, std::int64_t stamp_ns = 0) {
    ImageMessage image{stamp_ns, 8, 6, encoding, false, static_cast<std::uint32_t>(8 * pixel.size()), {}};
    for (int k = 0; k < 48; ++k) image.data += pixel;
    return image;
}
std::string word(std::uint16_t value) {
    std::string bytes;
    put(bytes, value);
    return bytes;
}

/// The bytes of a recording of one message.
std::string bag_of(const std::string& topic, const char* type, const std::string& message,
                   const char* packing = "none") {
    BagBytes bag;
    bag.add(topic, type, 1, message);
    return bag.file(packing);
}
std::string bag_of_depth(const ImageMessage& image) {
    return bag_of("/depth", of_images, image.bytes());
}
std::string bag_of_compressed(const char* format, const std::string& data) {
    return bag_of("/depth/compressedDepth", of_compressed, compressed_message(0, format, data));
}

TEST_F(Bag, ReadsColourOfEveryEncoding) {
    const std::string rgb("\x0a\x14\x1e", 3);
    const std::pair<const char*, std::string> colours[] = {
        {"rgb8", rgb},           {"bgr8", "\x1e\x14\x0a"},      {"8UC3", "\x1e\x14\x0a"},
        {"rgba8", rgb + "\x07"}, {"bgra8", "\x1e\x14\x0a\x07"},
    };
    const auto colour_of = [&](const ImageMessage& image) {
        BagBytes bag;
        bag.add("/d/depth", of_images, 1, even_picture("16UC1", word(700)).bytes());
        bag.add("/d/rgb", of_images, 1, image.bytes());
        write_bytes(folder / "x.bag", bag.file("none"));
        const auto opened = opened_bag(folder / "x.bag");
        EXPECT_EQ(opened.frames.at(0).depth.sample(7, 5), 700);
        const PlaneView& colour = opened.frames.at(0).colour;
        return std::array{int{colour.sample(7, 5, 0)}, int{colour.sample(7, 5, 1)},
                          int{colour.sample(7, 5, 2)}};
    };
    for (const auto& [encoding, pixel] : colours)
        EXPECT_EQ(colour_of(even_picture(encoding, pixel)), (std::array{10, 20, 30})) << encoding;
    EXPECT_EQ(colour_of(even_picture("mono8", "\x0c")), (std::array{12, 12, 12}));
    // U and V of a grey pixel are 128; luma of the usual range, 16 to 235.
    const int grey = static_cast<int>(std::lround((100 - 16) * 255. / 219));
    for (const auto& [encoding, pixel] : {std::pair{"yuv422", "\x80\x64"}, {"YUYV", "\x64\x80"}})
        for (const int channel : colour_of(even_picture(encoding, pixel)))
            EXPECT_NEAR(channel, grey, 1) << encoding;
    ImageMessage padded = even_picture("rgb8", rgb);
    padded.step = 30;
    padded.data.clear();
    for (int y = 0; y < 6; ++y) padded.data += even_picture("rgb8", rgb).data.substr(0, 24) + "......";
    EXPECT_EQ(colour_of(padded), (std::array{10, 20, 30}));
}

/// RVL as its author prints it (Wilson 2017, CompressRVL, EncodeVLE), before what ROS and some cameras put
/// columns and rows.
std::string packed_by_rvl(const std::vector<int>& depths, std::uint32_t columns) {
    std::string out;
    std::uint32_t word = 0;
    int nibbles = 0;
    const auto put_vle = [&](std::uint32_t value) {
        do {
            std::uint32_t nibble = value & 7;
            if (value >>= 3) nibble |= 8;
            word = word << 4 | nibble;
            if (++nibbles == 8) {
                put(out, word);
                nibbles = 0;
                word = 0;
            }
        } while (value);
    };
    put(out, columns);
    put(out, static_cast<std::uint32_t>(depths.size()) / columns);
    int before = 0;
    for (std::size_t at = 0; at < depths.size();) {
        std::uint32_t zeros = 0, others = 0;
        for (; at < depths.size() && depths[at] == 0; ++at) ++zeros;
        put_vle(zeros);
        for (std::size_t k = at; k < depths.size() && depths[k] != 0; ++k) ++others;
        put_vle(others);
        for (std::uint32_t k = 0; k < others; ++k, ++at) {
            const int step = depths[at] - before;
            put_vle(static_cast<std::uint32_t>(step * 2) ^ static_cast<std::uint32_t>(step >> 31));
            before = depths[at];
        }
    }
    if (nibbles) put(out, word << 4 * (8 - nibbles));
    return out;
}

TEST_F(Bag, ReadsRvlWithoutHeadToo) {
    std::vector<int> depths;  // holes, long runs, steps of every size, the ends of 16 bits
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 16; ++x)
            depths.push_back(y < 2 || (x + y) % 7 == 0 ? 0
                             : y == 2                  ? (x % 2 ? 65535 : 1)
                                                       : 600 + 40 * y + x * x);
    const std::string packed = packed_by_rvl(depths, 16);
    for (const std::string& data : {std::string(12, '\0') + packed, packed}) {
        write_bytes(folder / "x.bag", bag_of_compressed("16UC1; compressedDepth rvl", data));
        const auto opened = opened_bag(folder / "x.bag");
        ASSERT_EQ(opened.frames.size(), 1U);
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 16; ++x)
                ASSERT_EQ(opened.frames[0].depth.sample(x, y), depths[static_cast<std::size_t>(16 * y + x)]);
    }
    // Damage: words that end, runs beyond the picture, sizes without pixels.
    for (const std::string& data :
         {packed.substr(0, packed.size() - 8), packed_by_rvl(std::vector<int>(96, 0), 16).substr(0, 8),
          packed.substr(0, 8) + std::string("\xff\xff\xff\x7f", 4), std::string(40, '\0')}) {
        write_bytes(folder / "x.bag",
                    bag_of_compressed("16UC1; compressedDepth rvl", std::string(12, '\0') + data));
        EXPECT_TRUE(is_refused(open_clip(folder / "x.bag"), "is damaged"));
    }
}

/// As AirSim publishes them. Where the bytes are not as many as rows without padding have, a step of 0 is
/// damage.
TEST_F(Bag, TakesZeroStepAsUnpadded) {
    const auto write = [&](std::size_t bytes) {
        ImageMessage image;
        image.width = 8;
        image.height = 6;
        image.encoding = "16UC1";
        for (int k = 0; k < 8 * 6; ++k) put(image.data, static_cast<std::uint16_t>(600 + k));
        image.data.resize(bytes);
        write_bytes(folder / "x.bag", bag_of_depth(image));
    };
    write(2 * 8 * 6);
    const auto opened = opened_bag(folder / "x.bag");
    ASSERT_EQ(opened.frames.size(), 1U);
    for (int k = 0; k < 8 * 6; ++k) ASSERT_EQ(opened.frames[0].depth.sample(k % 8, k / 8), 600 + k);
    for (const std::size_t bytes : {2 * 8 * 6 - 2, 2 * 8 * 6 + 2}) {
        write(bytes);
        EXPECT_TRUE(is_refused(open_clip(folder / "x.bag"), "is damaged: has"));
    }
}

TEST_F(Bag, ReadsDepthOfEveryEncoding) {
    const std::string png = must(png_bytes(even_image(8, 6, 2, 1, 700).view(), PngEffort::quick));
    ImageMessage big = even_picture("mono16", "\x02\xbc");
    big.is_big_endian = true;
    std::string config;  // 1 / depth: depth = a / (code - b)
    put(config, std::int32_t{1});
    put(config, 350.F);
    put(config, 0.F);
    const std::tuple<const char*, const char*, std::string, double> kinds[] = {
        {"/depth", of_images, big.bytes(), 0.7},
        {"/depth/compressed", of_compressed, compressed_message(0, "png", png), 0.7},
        {"/depth/compressedDepth", of_compressed,
         compressed_message(0, "16UC1; compressedDepth", std::string(12, '\0') + png), 0.7},
        {"/depth/compressedDepth", of_compressed, compressed_message(0, "16UC1; compressedDepth png", png),
         0.7},
        {"/depth/compressedDepth", of_compressed,
         compressed_message(0, "32FC1; compressedDepth png", config + png), 0.5},
    };
    for (const auto& [topic, type, bytes, metres] : kinds) {
        write_bytes(folder / "x.bag", bag_of(topic, type, bytes, "lz4"));
        const auto opened = opened_bag(folder / "x.bag");
        ASSERT_EQ(opened.frames.size(), 1U);
        const Scene& scene = opened.reader->scene();
        EXPECT_NEAR(scene.depth.depth(opened.frames[0].depth.sample(7, 5)), metres, 1e-6) << bytes.size();
    }
    write_bytes(folder / "x.bag", bag_of_compressed("32FC1; compressedDepth png", png));
    EXPECT_TRUE(is_refused(open_clip(folder / "x.bag"), "has no head of 12 bytes before its PNG"));
}

/// Floats are metres and integers millimetres, by ROS; some drivers write other units.
TEST_F(Bag, DoubtsUnitByValues) {
    constexpr int width = 16, height = 12;
    const auto opened = [&](const char* encoding, double times) {
        ImageMessage image;
        image.width = width;
        image.height = height;
        image.encoding = encoding;
        for (int k = 0; k < width * height; ++k) {
            const double value = times * (1.3 + 0.0047 * k);
            if (image.encoding == "32FC1")
                put(image.data, static_cast<float>(value));
            else
                put(image.data, static_cast<std::uint16_t>(value));
        }
        image.step = static_cast<std::uint32_t>(image.data.size() / height);
        write_bytes(folder / "x.bag", bag_of_depth(image));
        return must(open_clip(folder / "x.bag"));
    };
    const struct {
        const char* encoding;
        double times, metres;
        RemarkKind kind;
    } cases[] = {{"32FC1", 1, 1.3, RemarkKind::unit},
                 {"32FC1", 1000, 1.3, RemarkKind::unit},
                 {"16UC1", 1000, 1.3, RemarkKind::unclear_unit},
                 {"16UC1", 10'000, 13, RemarkKind::unclear_unit},
                 {"16UC1", 40, 0.52, RemarkKind::unclear_unit}};
    for (const auto& [encoding, times, metres, kind] : cases) {
        SCOPED_TRACE(std::string(encoding) + ", times " + std::to_string(times));
        const auto reader = opened(encoding, times);
        const RawFrame frame = *must(reader->next());
        const Scene& scene = reader->scene();
        EXPECT_NEAR(scene.metres_per_unit * scene.depth.depth(frame.depth.sample(0, 0)), metres,
                    0.02 * metres);
        const auto remark = std::ranges::find_if(scene.remarks, [](const Remark& each) {
            return std::ranges::count(each.hints, Setting::depth_unit, &Hint::setting) > 0;
        });
        ASSERT_NE(remark, scene.remarks.end());
        EXPECT_EQ(remark->kind, kind) << remark->what;
    }
}

TEST_F(Bag, OrdersFramesByStamp) {
    constexpr std::int64_t second = 1'000'000'000, ms = 1'000'000;
    const auto written = [&](std::int64_t colours_clock) {
        BagBytes bag;
        const std::int64_t start = 1600 * second;
        // Recorded in another order than taken.
        for (const int n : {1, 0, 2})
            bag.add("/d/depth", of_images, start + (3 - n) * 40 * ms,
                    even_picture("16UC1", word(static_cast<std::uint16_t>(700 + n)), start + n * 40 * ms)
                        .bytes());
        for (const int n : {0, 1, 2})
            bag.add("/d/rgb", of_images, start + (n + 1) * 40 * ms,
                    even_picture("mono8", std::string(1, static_cast<char>('a' + n)),
                                 colours_clock + start + n * 25 * ms)
                        .bytes());
        write_bytes(folder / "x.bag", bag.file("bz2", 2));
        return opened_bag(folder / "x.bag");
    };
    const auto stamped = written(0);
    EXPECT_EQ(stamped.reader->scene().rate.num, 25);
    const int colours[] = {'a', 'c', 'c'};  // at 0, 40 and 80 ms, of 0, 25 and 50
    for (std::size_t n = 0; n < 3; ++n) {
        EXPECT_EQ(stamped.frames.at(n).depth.sample(0, 0), 700 + n);
        EXPECT_EQ(stamped.frames.at(n).colour.sample(0, 0), colours[n]);
    }
    // Clocks that have nothing to do with each other: then when they were recorded.
    const auto recorded = written(5000 * second);
    const int depths[] = {702, 701, 700};
    for (std::size_t n = 0; n < 3; ++n) {
        EXPECT_EQ(recorded.frames.at(n).depth.sample(0, 0), depths[n]);
        EXPECT_EQ(recorded.frames.at(n).colour.sample(0, 0), 'a' + n);
    }
}

/// Depth and grey of 640x480, as an SR300 has them.
void expect_the_same_pictures_from_a_bag(const std::filesystem::path& castle) {
    constexpr int count = 4;
    const TemporaryFolder folder;
    const std::string sensor = "/device_0/sensor_0/", depth = sensor + "Depth_0/";
    BagBytes bag;
    std::string unit;
    put(unit, 0.000124986647F);
    bag.add(sensor + "option/Depth Units/value", "std_msgs/Float32", 1, unit);
    bag.add(depth + "info/camera_info", of_cameras, 1,
            camera_message(640, 480, {476.054, 476.053, 311.485, 246.283}));
    std::vector<Image> depths, greys;
    for (int n = 0; n < count; ++n) {
        const std::int64_t stamp = 1'600'000'000'000'000'000 + n * 33'366'667LL;
        const std::string number = "_000" + std::to_string(n) + ".png";
        depths.push_back(*read_image(castle / ("depth" + number)));
        greys.push_back(*read_image(castle / ("image" + number)));
        const auto as_text = [](const Image& image) {
            return std::string(image.samples.begin(), image.samples.end());
        };
        const ImageMessage z{stamp, 640, 480, "mono16", false, 1280, as_text(depths.back())};
        const ImageMessage grey{stamp, 640, 480, "8UC1", false, 640, as_text(greys.back())};
        bag.add(depth + "image/data", of_images, n, z.bytes());
        bag.add("/device_0/sensor_1/Color_0/image/data", of_images, n, grey.bytes());
    }
    write_bytes(folder / "castle.bag", bag.file("lz4", 3));
    const auto [reader, frames] = opened_bag(folder / "castle.bag");
    ASSERT_EQ(frames.size(), std::size_t{count});
    EXPECT_EQ(reader->scene().rate.num, 30);
    for (std::size_t n = 0; n < count; ++n) {
        EXPECT_TRUE(same_plane(frames[n].depth, depths[n].view())) << n;
        EXPECT_EQ(frames[n].colour.sample(100, 200, 1), greys[n].view().sample(100, 200)) << n;
    }
    expect_geometry(reader->scene(), frames[2].depth, {476.054, 476.053, 311.485, 246.283}, 1e-6,
                    [&](int x, int y) { return 0.000124986647 * depths[2].view().sample(x, y); });
    ASSERT_EQ(message(reader->seek(3)), "");
    const auto last = must(reader->next());
    EXPECT_TRUE(same_frame(*last, frames[3]));
}

/// The castle, which was recorded by an SR300.
TEST_F(Bag, KeepsRealPictures) {
    const auto castle = real_data("castel_sr300");
    TOUCHABLE_NEEDS_DATA(castle);
    expect_the_same_pictures_from_a_bag(castle);
}

TEST_F(Bag, KeepsStandInPictures) {
    StandIn what = stand_in("castel_sr300");
    what.width = 640;
    what.height = 480;
    write_stand_in(folder.path(), what);
    expect_the_same_pictures_from_a_bag(folder.path());
}

std::string refusal_of(const std::filesystem::path& file, const std::string& bytes) {
    write_bytes(file, bytes);
    return message(open_clip(file));
}

TEST_F(Bag, NamesFaults) {
    const auto file = folder / "x.bag";
    BagBytes bag;
    bag.add("/ir/image", of_images, 1, even_picture("mono16", word(7)).bytes());
    bag.add("/imu", "sensor_msgs/Imu", 1, "nothing");
    const std::string whole = bag.file("none");
    EXPECT_TRUE(has_words(refusal_of(file, whole), "has no topic of depth (there are /ir/image of mono16)"));
    std::string other = whole;
    other[9] = '1';
    EXPECT_TRUE(has_words(refusal_of(file, other), "must be of version 2.0"));
    other = whole;
    const auto index = other.find("index_pos=");
    std::fill_n(other.begin() + static_cast<std::ptrdiff_t>(index) + 10, 8, '\0');
    EXPECT_TRUE(has_words(refusal_of(file, other), "has no index"));
    EXPECT_TRUE(
        has_words(refusal_of(file, bag_of_depth(even_picture("bayer_rggb8", "x"))), "/depth of bayer_rggb8"));
    ImageMessage picture = even_picture("16UC1", word(7));
    other = bag_of_depth(picture);
    const std::string sum = "md5sum=060021388200f6f0f447d0fcd9c64743";
    for (std::size_t at = 0; (at = other.find(sum, at)) != std::string::npos;)
        other[at + sum.size() - 1] = '4';
    EXPECT_TRUE(has_words(refusal_of(file, other), "has no topic of depth")) << "an Image of other fields";
    picture.data.pop_back();
    EXPECT_TRUE(
        has_words(refusal_of(file, bag_of_depth(picture)), "/depth, frame 0: is damaged: has 95 bytes"));
    EXPECT_TRUE(is_refused(
        open_clip(kept_bag("tum_bz2.bag"), std::nullopt, stated(&SourceDescription::preset, "nothing")),
        "preset nothing is not known"));
}

/// Spoils the first bytes of every `step`th packed chunk.
std::string with_spoilt_chunks(std::string bytes, std::size_t step) {
    const std::string lz4 = "\x04\x22\x4d\x18";
    std::size_t number = 0;
    for (auto at = bytes.find(lz4); at != std::string::npos; at = bytes.find(lz4, at + 1))
        if (number++ % step == 0) bytes[at] = 'x';
    return bytes;
}

TEST_F(Bag, SkipsDamagedChunksWithNote) {
    const auto file = folder / "x.bag";
    BagBytes bag;
    for (int n = 0; n < 5; ++n) {
        ImageMessage picture = even_picture("16UC1", word(700 + n));
        picture.stamp_ns = (10 + n) * 100'000'000LL;
        bag.add("/depth", of_images, picture.stamp_ns, picture.bytes());
    }
    const std::string whole = bag.file("lz4", 1);
    write_bytes(file, with_spoilt_chunks(whole, 2));
    const auto [reader, frames] = opened_bag(file);
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[0].depth.sample(1, 1), 701);
    EXPECT_EQ(frames[1].depth.sample(1, 1), 703);
    EXPECT_TRUE(is_noted(*reader, "3 chunks are damaged, and what cannot be read of them is left out"));
    const std::string said = refusal_of(file, with_spoilt_chunks(whole, 1));
    EXPECT_TRUE(has_words(said, "has no topic of depth (there are no pictures)"));
    EXPECT_TRUE(has_words(said, "5 chunks are damaged"));
}

/// An error on one line, or frames.
bool survives(const std::filesystem::path& file) {
    auto reader = open_clip(file);
    const auto frames = reader ? read_all(**reader) : Result<std::vector<RawFrame>>(reader.error());
    if (frames) return true;
    EXPECT_EQ(frames.error().message.find('\n'), std::string::npos) << frames.error().message;
    EXPECT_TRUE(has_words(frames.error().message, "x.bag"));
    return false;
}

TEST_F(Bag, RefusesCutFiles) {
    const LimitedMemory limit(512);
    for (const char* name : {"realsense_lz4.bag", "depth_plain.bag", "tum_bz2.bag"}) {
        const std::string whole = read_bytes(kept_bag(name));
        write_bytes(folder / "x.bag", whole);
        ASSERT_TRUE(survives(folder / "x.bag"));
        for (std::size_t length = whole.size(); length-- > 0;) {
            std::filesystem::resize_file(folder / "x.bag", length);
            ASSERT_FALSE(survives(folder / "x.bag")) << length;
        }
    }
}

// Recordings of ROS 2 in SQLite, written by SQLite itself in the tables of rosbag2_storage_sqlite3.

/// A database that SQLite writes.
class WrittenDatabase {
public:
    explicit WrittenDatabase(const std::filesystem::path& file) {
        std::filesystem::remove(file);
        EXPECT_EQ(sqlite3_open(file.c_str(), &database_), SQLITE_OK);
    }
    ~WrittenDatabase() { EXPECT_EQ(sqlite3_close(database_), SQLITE_OK); }
    void run(const std::string& statements) {
        char* wrong = nullptr;
        EXPECT_EQ(sqlite3_exec(database_, statements.c_str(), nullptr, nullptr, &wrong), SQLITE_OK)
            << (wrong == nullptr ? "" : wrong);
    }
    /// Texts, but for the last value, which is bytes.
    void insert(const std::string& statement, const std::vector<std::string>& values) {
        sqlite3_stmt* prepared = nullptr;
        ASSERT_EQ(sqlite3_prepare_v2(database_, statement.c_str(), -1, &prepared, nullptr), SQLITE_OK);
        for (std::size_t k = 0; k < values.size(); ++k) {
            const int place = static_cast<int>(k) + 1, size = static_cast<int>(values[k].size());
            if (k + 1 == values.size())
                sqlite3_bind_blob(prepared, place, values[k].data(), size, SQLITE_TRANSIENT);
            else
                sqlite3_bind_text(prepared, place, values[k].data(), size, SQLITE_TRANSIENT);
        }
        EXPECT_EQ(sqlite3_step(prepared), SQLITE_DONE);
        sqlite3_finalize(prepared);
    }

private:
    sqlite3* database_ = nullptr;
};

/// As Humble has them, and as Foxy had.
constexpr const char* tables =
    "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);"
    "CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,metadata TEXT NOT NULL);"
    "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,serialization_format "
    "TEXT "
    "NOT NULL,offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data "
    "BLOB NOT NULL);"
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC);";
constexpr const char* older_tables =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,serialization_format "
    "TEXT "
    "NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data "
    "BLOB NOT NULL);";

struct Db3Options {
    std::string begin{};  ///< statements before the tables
    const char* made = tables;
    std::string format = "cdr";
    bool is_packed = false;    ///< each message, by zstd
    bool is_reversed = false;  ///< the last message first
};

void fill(WrittenDatabase& database, const Db3Options& options) {
    database.run(options.begin + options.made + "BEGIN");
    std::map<std::string, std::string> topics;
    auto messages = ros2_recording();
    if (options.is_reversed) std::reverse(messages.begin(), messages.end());
    for (const Ros2Message& each : messages) {
        auto& topic = topics[each.topic];
        if (topic.empty()) {
            topic = std::to_string(topics.size());
            database.insert(std::string("INSERT INTO topics VALUES (?1, ?2, ?3, CAST(?4 AS TEXT)") +
                                (options.made == tables ? ", '')" : ")"),
                            {topic, each.topic, each.type, options.format});
        }
        std::string bytes = each.bytes;
        if (options.is_packed) {
            bytes.resize(ZSTD_compressBound(each.bytes.size()));
            bytes.resize(ZSTD_compress(bytes.data(), bytes.size(), each.bytes.data(), each.bytes.size(), 1));
        }
        database.insert("INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)",
                        {topic, std::to_string(each.time_ns), bytes});
    }
    database.run("COMMIT");
}

void write_db3(const std::filesystem::path& file, const Db3Options& options = {}) {
    WrittenDatabase database(file);
    fill(database, options);
}

std::string refusal(const std::filesystem::path& file) {
    std::string said = message(open_clip(file));
    EXPECT_TRUE(has_words(said, file.filename().string() + ": "));
    EXPECT_EQ(said.find('\n'), std::string::npos);
    return said;
}

using Db3 = FolderTest;

TEST_F(Db3, ReadsEveryWayOfWriting) {
    for (const Db3Options& options :
         {Db3Options{}, Db3Options{"", older_tables}, Db3Options{"", tables, "cdr", false, true},
          Db3Options{"PRAGMA page_size=512;"}, Db3Options{"PRAGMA page_size=65536;"},
          Db3Options{"PRAGMA journal_mode=WAL;"}}) {
        SCOPED_TRACE(options.begin + (options.is_reversed ? " reversed" : ""));
        write_db3(folder / "x.db3", options);
        const auto clip = must(open_clip(folder / "x.db3"));
        expect_ros2_recording(*clip);
    }
}

TEST_F(Db3, OpensFolderAsItsFile) {
    write_bytes(folder / "metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n");
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "neither a .db3 nor an .mcap"));
    write_bytes(folder / "x_0.db3.zstd", "packed");
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "zstd -d "));
    write_db3(folder / "x_0.db3");
    const auto clip = must(open_clip(folder.path()));
    expect_ros2_recording(*clip);
    const auto guessed = must(guess_clip(folder.path(), {}));
    EXPECT_EQ(guessed.scene.video->depth, "x_0.db3");
    write_db3(folder / "x_1.db3");
    const std::string said = message(open_clip(folder.path()));
    EXPECT_TRUE(has_words(said, "in 2 files"));
    EXPECT_TRUE(has_words(said, "x_0.db3"));
}

TEST_F(Db3, SkipsLogWithNote) {
    WrittenDatabase recorder(folder / "x.db3");
    fill(recorder, {"PRAGMA journal_mode=WAL;"});
    recorder.run("PRAGMA wal_checkpoint(TRUNCATE); DELETE FROM messages");
    const auto clip = must(open_clip(folder / "x.db3"));
    expect_ros2_recording(*clip);
    EXPECT_TRUE(is_noted(*clip, "x.db3-wal are left out"));
}

TEST_F(Db3, RefusesOtherDatabases) {
    const auto file = folder / "x.db3";
    write_bytes(file, "text\n");
    EXPECT_TRUE(has_words(refusal(file), "is of no kind that is known"));
    write_bytes(file, std::string("SQLite format 3\0 and nothing more", 33));
    EXPECT_TRUE(has_words(refusal(file), "is damaged"));
    const std::string none = "must have the tables topics and messages";
    { WrittenDatabase(file).run("CREATE TABLE topics(id, name, type, serialization_format)"); }
    EXPECT_TRUE(has_words(refusal(file), none));
    { WrittenDatabase(file).run("CREATE TABLE topics(a); CREATE TABLE messages(a)"); }
    EXPECT_TRUE(has_words(refusal(file), "no such column"));
    write_db3(file, {"", tables, "something"});
    EXPECT_TRUE(has_words(refusal(file), "has no topic of depth (there are no pictures)"));
    write_db3(file, {"", tables, "cdr", true});
    EXPECT_TRUE(has_words(refusal(file), "packed by zstd (compression_mode: message)"));
}

/// Views that never end, tables that are computed or another program's, and indices that say something else.
TEST_F(Db3, RefusesHostileSchema) {
    const auto file = folder / "x.db3";
    const std::string topics =
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
        "INSERT INTO topics VALUES(1, '/depth', 'sensor_msgs/msg/Image', 'cdr');";
    const std::string none = "must have the tables topics and messages";
    const std::map<std::string, std::string> schemas{
        {"CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) SELECT "
         "id, 1 AS "
         "topic_id, 0 AS timestamp, x'00' AS data FROM n",
         none},
        {"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp AS "
         "(length(hex(zeroblob(1000000)))), data)",
         none},
        {"CREATE VIRTUAL TABLE messages USING rtree(id, topic_id, timestamp)", "no such module"},
        {"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data) WITHOUT ROWID",
         "no such column"},
        {"CREATE TABLE messages(rowid, topic_id, timestamp, data);"
         "INSERT INTO messages VALUES(2, 1, 0, x'00'), (1, 1, 0, x'00')",
         "not in order"},
        {"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);"
         "INSERT INTO messages VALUES(1, 1, 0, NULL)",
         "cannot open value of type null"},
        {"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);"
         "CREATE TABLE m(x); PRAGMA writable_schema=ON; UPDATE sqlite_schema SET sql='CREATE VIRTUAL TABLE "
         "messages "
         "USING rtree(a, b, c)' WHERE name='messages'",
         "no such module"}};
    for (const auto& [schema, words] : schemas) {
        SCOPED_TRACE(schema);
        { WrittenDatabase(file).run(topics + schema); }
        EXPECT_TRUE(has_words(refusal(file), words));
    }
}

/// Whole messages of many pages, beyond what SQLite itself may read at once here.
TEST_F(Db3, ReadsLargePictures) {
    const auto file = folder / "x.db3";
    {
        WrittenDatabase database(file);
        fill(database, {});
        database.run("UPDATE messages SET data = CAST(data || zeroblob(3000000) AS BLOB)");
    }
    const auto clip = must(open_clip(file));
    expect_ros2_recording(*clip);
}

TEST_F(Db3, NamesOrSkipsDamage) {
    const auto file = folder / "x.db3";
    write_db3(file, {"PRAGMA page_size=512;"});
    const std::string whole = read_bytes(file);
    for (std::size_t length = 16; length < whole.size(); length += 509) {
        write_bytes(file, whole.substr(0, length));
        EXPECT_TRUE(has_words(refusal(file), "is damaged")) << length;
    }
}

}  // namespace
}  // namespace touchable::test
