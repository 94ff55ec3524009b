// SPDX-License-Identifier: Apache-2.0
// The same depth as a PNG of 16 bits and as floats, which other programs wrote: NumPy, OpenEXR and
// libtiff (FFmpeg wrote the PNG). What is touched is the same.

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <gtest/gtest.h>
#include <half.h>
#include <tiffio.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <stop_token>
#include <thread>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip_notes.hpp"
#include "tests/limits.hpp"
#include "tests/picture/results.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {
namespace {

constexpr int twin_wide = 160, twin_high = 120;
using Floats = std::vector<float>;

/// A wall that leans and a box before it, as a camera has them that measures disparities: in levels, with
/// noise, holes, and one pixel that strays far off. In whole units, of which a metre has so many.
std::vector<std::uint16_t> camera_depth(int units, double farthest) {
    SplitMix64 random(17);
    std::vector<std::uint16_t> codes;
    for (int k = 0; k < twin_wide * twin_high; ++k) {
        const int x = k % twin_wide, y = k / twin_wide;
        const bool is_box = x > 50 && x < 100 && y > 40 && y < 90;
        const double metres = is_box ? 0.5 + 0.002 * (x - 50)
                                     : farthest - 0.4 * x / twin_wide - 0.2 * y / twin_high,
                     disparity = std::floor(8 * 43.5 / metres + random.unit()) / 8;
        codes.push_back(random.unit() < 0.03 ? std::uint16_t{0}
                                             : static_cast<std::uint16_t>(units * 43.5 / disparity));
    }
    codes[777] = static_cast<std::uint16_t>(std::min(65000.0, 3 * units * farthest));
    return codes;
}

Floats metres_of(const std::vector<std::uint16_t>& codes, int units = 1000) {
    Floats metres;
    for (const std::uint16_t code : codes)
        metres.push_back(static_cast<float>(code) / static_cast<float>(units));
    return metres;
}

template <class Number>
std::string bytes_of(const std::vector<Number>& numbers) {
    return {reinterpret_cast<const char*>(numbers.data()), sizeof(Number) * numbers.size()};
}

template <class Number>
void fill_plane(AVFrame& frame, const std::vector<Number>& numbers) {
    for (int y = 0; y < twin_high; ++y)
        std::memcpy(frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0],
                    numbers.data() + static_cast<std::ptrdiff_t>(y) * twin_wide, sizeof(Number) * twin_wide);
}

void write_exr(const std::filesystem::path& file, const Floats& values, bool as_halves) {
    Imf::Header header(twin_wide, twin_high);
    header.channels().insert("Z", Imf::Channel(as_halves ? Imf::HALF : Imf::FLOAT));
    std::vector<half> halves(values.begin(), values.end());
    Floats copy = values;
    Imf::FrameBuffer frame;
    frame.insert("Z", as_halves
                          ? Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.data()), 2, 2 * twin_wide)
                          : Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(copy.data()), 4, 4 * twin_wide));
    Imf::OutputFile out(file.c_str(), header);
    out.setFrameBuffer(frame);
    out.writePixels(twin_high);
}

void write_tiff(const std::filesystem::path& file, Floats values) {
    TIFF* const out = TIFFOpen(file.c_str(), "w");
    ASSERT_NE(out, nullptr);
    TIFFSetField(out, TIFFTAG_IMAGEWIDTH, twin_wide);
    TIFFSetField(out, TIFFTAG_IMAGELENGTH, twin_high);
    TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, 32);
    TIFFSetField(out, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
    TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(out, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    for (int y = 0; y < twin_high; ++y)
        EXPECT_EQ(TIFFWriteScanline(out, values.data() + static_cast<std::ptrdiff_t>(y) * twin_wide,
                                    static_cast<unsigned>(y)),
                  1);
    TIFFClose(out);
}

struct Opened {
    DepthCoding coding;
    std::vector<double> depths;  ///< metres; 0: none
    std::vector<std::uint16_t> codes;
    std::string notes;
};
Opened opened_depth(const std::filesystem::path& file, const SourceDescription& known) {
    const auto reader = must(open_clip(file, std::nullopt, known));
    const auto frame = must(reader->next());
    const Scene& scene = reader->scene();
    EXPECT_EQ(scene.width, twin_wide);
    Opened opened{scene.depth, {}, {}, {}};
    for (int y = 0; y < twin_high; ++y)
        for (int x = 0; x < twin_wide; ++x) {
            opened.codes.push_back(stored_code(frame->depth, scene.depth, x, y));
            const bool is_valid = scene.depth.is_valid(opened.codes.back());
            opened.depths.push_back(is_valid ? scene.depth.depth(opened.codes.back()) * scene.metres_per_unit
                                             : 0);
        }
    for (const std::string& note : clip_notes(*reader)) opened.notes += note + '\n';
    return opened;
}

SourceDescription metres_a_code(double metres) {
    SourceDescription known;
    known.fov = 60;
    known.metres_per_code = metres;
    return known;
}

class FloatTwins : public ::testing::Test {
protected:
    Opened png(const std::vector<std::uint16_t>& codes, double metres) const {
        std::vector<std::uint16_t> swapped;
        for (const unsigned code : codes)
            swapped.push_back(static_cast<std::uint16_t>(code << 8 | code >> 8));
        write_bytes(folder / "twin.png", encoded("png", AV_PIX_FMT_GRAY16BE, twin_wide, twin_high,
                                                 [&](AVFrame& frame) { fill_plane(frame, swapped); }));
        return opened_depth(folder / "twin.png", metres_a_code(metres));
    }
    /// By NumPy, of codes.u16 in the folder; whether it is there.
    bool run_numpy(const std::string& lines) const {
        write_bytes(folder / "write.py", "import numpy as np\nf = '" + folder.path().string() +
                                             "/'\nc = np.fromfile(f + 'codes.u16', '<u2').reshape(" +
                                             std::to_string(twin_high) + ", " + std::to_string(twin_wide) +
                                             ")\n" + lines);
        return std::system(
                   ("/usr/bin/python3 '" + (folder / "write.py").string() + "' 2>/dev/null").c_str()) == 0;
    }
    TemporaryFolder folder;
};

TEST_F(FloatTwins, MatchPngOfWholeUnits) {
    for (const int units : {1000, 10'000, 8000, 5000, 4000}) {
        SCOPED_TRACE(units);
        const auto codes = camera_depth(units, 2.1);
        write_bytes(folder / "codes.u16", bytes_of(codes));
        const Floats metres = metres_of(codes, units);
        write_exr(folder / "a.exr", metres, false);
        write_tiff(folder / "a.tif", metres);
        std::vector<std::pair<std::string, double>> files{{"a.exr", 1}, {"a.tif", 1}};
        const std::string per_metre = std::to_string(units);
        const std::string script =
            "u = " + std::to_string(units) +
            "\n"
            "m = c.astype('f4') / np.float32(u)\n"
            "np.save(f + 'divided', m)\n"
            "np.save(f + 'times', c.astype('f4') * np.float32(1.0 / u))\n"
            "np.save(f + 'doubles', c / float(u))\n"
            "np.savez_compressed(f + 'mm', depth=(c * (1000.0 / u)).astype('f4'))\n"
            "open(f + 'a.pfm', 'wb').write(b'Pf\\n%d %d\\n-1.0\\n' % m.shape[::-1] + m[::-1].tobytes())\n";
        if (run_numpy(script))
            for (const char* name : {"divided.npy", "times.npy", "doubles.npy", "mm.npz", "a.pfm"})
                files.emplace_back(name, std::string(name) == "mm.npz" ? 0.001 : 1);
        const Opened wanted = png(codes, 1.0 / units);
        EXPECT_EQ(wanted.coding.kind, DepthCodingKind::metric);
        for (const auto& [name, metres_per_one] : files) {
            SCOPED_TRACE(name);
            const Opened found = opened_depth(folder / name, metres_a_code(metres_per_one));
            EXPECT_EQ(found.coding, wanted.coding) << found.notes;
            EXPECT_EQ(found.codes, wanted.codes);
            EXPECT_EQ(found.depths, wanted.depths);
            EXPECT_TRUE(has_words(found.notes, "kept exactly"));
        }
    }
}

/// Colour in the first part, depth in the second, which its name alone tells.
TEST_F(FloatTwins, MatchPngOfNamedPart) {
    const auto codes = camera_depth(1000, 1.9);
    Floats metres = metres_of(codes);
    std::vector<Imf::Header> headers(2, Imf::Header(twin_wide, twin_high));
    headers[0].setName("rgba");
    for (const char* channel : {"R", "G", "B"})
        headers[0].channels().insert(channel, Imf::Channel(Imf::FLOAT));
    headers[1].setName("depth");
    headers[1].channels().insert("Y", Imf::Channel(Imf::FLOAT));
    for (Imf::Header& header : headers) header.setType(Imf::SCANLINEIMAGE);
    {
        Imf::MultiPartOutputFile file((folder / "parts.exr").c_str(), headers.data(), 2);
        Floats grey(metres.size(), 0.5F);
        for (const int part : {0, 1}) {
            Imf::FrameBuffer frame;
            const auto slice =
                Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(part == 0 ? grey.data() : metres.data()), 4,
                           4 * twin_wide);
            for (auto one = headers[static_cast<std::size_t>(part)].channels().begin();
                 one != headers[static_cast<std::size_t>(part)].channels().end(); ++one)
                frame.insert(one.name(), slice);
            Imf::OutputPart out(file, part);
            out.setFrameBuffer(frame);
            out.writePixels(twin_high);
        }
    }
    const Opened wanted = png(codes, 0.001), found = opened_depth(folder / "parts.exr", metres_a_code(1));
    EXPECT_EQ(found.coding, wanted.coding) << found.notes;
    EXPECT_EQ(found.depths, wanted.depths);
    EXPECT_TRUE(has_words(found.notes, "depth is channel depth.Y, colour is R, G, B"));
}

/// Opens a picture without any description.
TEST_F(FloatTwins, MatchWithGuessedUnit) {
    const auto codes = camera_depth(1000, 1.9);
    Floats metres = metres_of(codes);
    write_exr(folder / "a.exr", metres, false);
    png(codes, 0.001);
    const Opened wanted = opened_depth(folder / "twin.png", {}), found = opened_depth(folder / "a.exr", {});
    EXPECT_EQ(found.depths, wanted.depths);
    EXPECT_EQ(found.coding.scale, wanted.coding.scale);
    EXPECT_EQ(found.coding.far, wanted.coding.far);
}

/// Below 2 m halves are less than a millimetre apart, and rounding leaves none of them between two. Beyond,
/// a millimetre may come back as its neighbour.
TEST_F(FloatTwins, KeepMillimetresOfHalves) {
    const auto codes = camera_depth(1000, 2.7);
    Floats metres = metres_of(codes);
    write_exr(folder / "halves.exr", metres, true);
    const Opened wanted = png(codes, 0.001), found = opened_depth(folder / "halves.exr", metres_a_code(1));
    EXPECT_EQ(found.coding.scale, wanted.coding.scale) << found.notes;
    int beyond = 0;
    for (std::size_t k = 0; k < codes.size(); ++k) {
        if (codes[k] < 2000) {
            ASSERT_EQ(found.codes[k], wanted.codes[k]) << k;
        } else if (wanted.depths[k] > 0) {
            ASSERT_LE(std::abs(found.codes[k] - wanted.codes[k]), 1) << k;
        }
        beyond += codes[k] > 2000;
    }
    EXPECT_GT(beyond, twin_wide * twin_high / 4);
    EXPECT_TRUE(has_words(found.notes, "11 bits"));
}

/// Depth by stereo matching: baseline times focal length over eighths of a pixel. The unprojection is
/// written out here.
TEST_F(FloatTwins, KeepEachDisparity) {
    const auto eighths = camera_depth(100, 2.0);  // any whole numbers will do
    const float focal_baseline = 61.37F;
    Floats metres;
    std::vector<double> wanted;
    for (const std::uint16_t code : eighths) {
        metres.push_back(code == 0 ? 0 : focal_baseline / (static_cast<float>(code) / 8));
        wanted.push_back(code == 0 ? 0 : 61.37 / (code / 8.0));
    }
    write_exr(folder / "a.exr", metres, false);
    auto reader = must(open_clip(folder / "a.exr", std::nullopt, metres_a_code(1)));
    const auto frame = must(reader->next());
    const Scene& scene = reader->scene();
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::inverse);
    EXPECT_LT(scene.depth.code_max, 600) << "as many codes as there are disparities";
    const double f = twin_wide / 2.0 / std::tan(M_PI / 6), cx = (twin_wide - 1) / 2.0,
                 cy = (twin_high - 1) / 2.0;
    int valid = 0;
    for (int y = 0; y < twin_high; ++y)
        for (int x = 0; x < twin_wide; ++x) {
            const double z = wanted[static_cast<std::size_t>(twin_wide * y + x)];
            const std::uint16_t code = stored_code((*frame).depth, scene.depth, x, y);
            if (!scene.depth.is_valid(code)) continue;
            ++valid;
            ASSERT_TRUE(is_at(scene, code, {f, f, cx, cy}, x, y, z, 1e-5 * z));
        }
    EXPECT_GT(valid, twin_wide * twin_high * 9 / 10);
}

/// A later frame of the stack, not among those searched, has values that no frame before it had.
TEST_F(FloatTwins, KeepLaterMultiplesOfStack) {
    write_bytes(folder / "codes.u16", bytes_of(camera_depth(1000, 1.9)));
    if (!run_numpy("s = np.stack([c] * 60).astype('i4')\ns[17, 5, 7] = 231\ns[17, 5, 8] = 1803\n"
                   "np.save(f + 'stack', (s / 1000).astype('f4'))\n"))
        GTEST_SKIP() << "needs Python with NumPy (Debian: python3-matplotlib)";
    auto reader = must(open_clip(folder / "stack.npy", std::nullopt, metres_a_code(1)));
    ASSERT_EQ(message(reader->seek(17)), "");
    const auto frame = must(reader->next());
    EXPECT_EQ((*frame).depth.sample(7, 5), 231);
    EXPECT_EQ((*frame).depth.sample(8, 5), 1803);
}

}  // namespace
}  // namespace touchable::test

namespace touchable::test::large {
namespace {

// Pictures of any kind take as much memory as their pixels need, and hear a stop.

constexpr int side = 6000;
constexpr auto width = static_cast<std::size_t>(side);

/// A row of depth in any kind of numbers: 1.5 to 2.5.
template <class Number>
std::vector<Number> row_of(double per_metre) {
    std::vector<Number> row(width);
    for (std::size_t x = 0; x < width; ++x)
        row[x] = static_cast<Number>(per_metre * (1.5 + static_cast<double>(x) / side));
    return row;
}
template <class Number>
std::string bytes_of(std::vector<Number> row, bool swapped = false) {
    if (swapped)
        for (Number& number : row) {
            auto bytes = std::bit_cast<std::array<char, sizeof(Number)>>(number);
            std::reverse(bytes.begin(), bytes.end());
            number = std::bit_cast<Number>(bytes);
        }
    return {reinterpret_cast<const char*>(row.data()), row.size() * sizeof(Number)};
}

/// A header and so many times a row.
void write_rows(const std::filesystem::path& file, const std::string& header, const std::string& row) {
    std::ofstream out(file, std::ios::binary);
    out << header;
    for (int y = 0; y < side; ++y) out << row;
}

void write_tiff(const std::filesystem::path& file) {
    TIFF* const tiff = TIFFOpen(file.c_str(), "w");
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, side);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, side);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
    std::vector<float> row = row_of<float>(1);
    for (std::uint32_t y = 0; y < side; ++y) TIFFWriteScanline(tiff, row.data(), y, 0);
    TIFFClose(tiff);
}

void write_exr(const std::filesystem::path& file) {
    Imf::Header header(side, side);
    header.compression() = Imf::ZIP_COMPRESSION;
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    std::vector<float> row = row_of<float>(1);
    Imf::FrameBuffer frame;  // of which every row is the same one
    frame.insert("Z", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(row.data()), sizeof(float), 0));
    Imf::OutputFile out(file.c_str(), header);
    out.setFrameBuffer(frame);
    out.writePixels(side);
}

/// A packed array of doubles.
void write_npz(const std::filesystem::path& file, const TemporaryFolder& folder) {
    write_rows(folder / "whole.npy", npy_header("<f8", "6000, 6000"), bytes_of(row_of<double>(1)));
    zip_t* const archive = zip_open(file.c_str(), ZIP_CREATE, nullptr);
    zip_source_t* const source = zip_source_file(archive, (folder / "whole.npy").c_str(), 0, -1);
    const auto index = static_cast<zip_uint64_t>(zip_file_add(archive, "depth.npy", source, 0));
    zip_set_file_compression(archive, index, ZIP_CM_DEFLATE, 1);
    EXPECT_EQ(zip_close(archive), 0);
    std::filesystem::remove(folder / "whole.npy");
}

void write_large_png(const std::filesystem::path& file) {
    Image image{side, side, 2, 1, {}};
    const std::string row = bytes_of(row_of<std::uint16_t>(1000));
    for (int y = 0; y < side; ++y) image.samples.insert(image.samples.end(), row.begin(), row.end());
    EXPECT_EQ(message(write_png_to(file, image.view(), file, PngEffort::quick)), "");
}

void write_large(const std::filesystem::path& file, const TemporaryFolder& folder) {
    const std::string size = std::to_string(side) + ' ' + std::to_string(side), kind = file.extension();
    if (kind == ".png") write_large_png(file);
    if (kind == ".tif") write_tiff(file);
    if (kind == ".exr") write_exr(file);
    if (kind == ".npz") write_npz(file, folder);
    if (kind == ".npy") write_rows(file, npy_header("<f4", "6000, 6000"), bytes_of(row_of<float>(1)));
    if (kind == ".pfm") write_rows(file, "Pf " + size + " -1\n", bytes_of(row_of<float>(1)));
    if (kind == ".pgm")
        write_rows(file, "P5 " + size + " 65535\n", bytes_of(row_of<std::uint16_t>(1000), true));
    if (kind == ".ppm") {
        std::string row;
        for (const std::uint8_t grey : row_of<std::uint8_t>(100)) row.append(3, static_cast<char>(grey));
        write_rows(file, "P6 " + size + " 255\n", row);
    }
}

class LargePicture : public ::testing::TestWithParam<const char*> {};

TEST_P(LargePicture, TakesMemoryOfItsPixels) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / (std::string("depth") + GetParam());
    write_large(file, folder);
    const double bytes_per_pixel = GetParam() == std::string(".npz") ? 9 : 5;
    const PeakMemory peak;
    const auto clip = must(open_clip(file));
    EXPECT_LE(peak.mebibytes(), 128 + bytes_per_pixel * side * side / (1 << 20));
    EXPECT_EQ(clip->scene().width, side);
}

TEST_P(LargePicture, EndsWhenStopped) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / (std::string("depth") + GetParam());
    write_large(file, folder);
    auto bytes = must(read_picture_bytes(file));
    std::stop_source given_up;
    const StopScope until(given_up.get_token());
    given_up.request_stop();
    // The decoders themselves, where they last: `decode_stored_image` does not begin once it is stopped.
    const std::map<std::string, Result<StoredImage> (*)(std::string_view, const std::string&)> decoders{
        {".png", decode_coded_image},
        {".tif", decode_tiff},
        {".exr", [](std::string_view coded, const std::string& where) { return decode_exr(coded, where); }},
        {".npy", decode_npy},
        {".npz", decode_npz}};
    const auto decoder = decoders.find(GetParam());
    const auto stored = decoder == decoders.end() ? decode_stored_image(std::move(bytes), "picture")
                                                  : decoder->second(bytes, "picture");
    ASSERT_FALSE(stored);
    EXPECT_EQ(stored.error().kind, ErrorKind::interrupted) << stored.error().message;
    for (int k = 0; k < 60'000 && abandoned_threads > 0; ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(abandoned_threads, 0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, LargePicture,
                         ::testing::Values(".png", ".tif", ".exr", ".npy", ".npz", ".pfm", ".pgm", ".ppm"),
                         [](const auto& kind) { return std::string(kind.param + 1); });

}  // namespace
}  // namespace touchable::test::large

namespace touchable::test {
namespace {

/// Real pictures, against an unprojection of the stored values written out here.
struct Wanted {
    Camera camera;
    std::function<double(int x, int y)> depth;  ///< metres; 0: none
    double relative = 1e-6;                     ///< of integers; of floats half a code
};

void expect_points(const std::filesystem::path& file, const SourceDescription& known, const Wanted& wanted) {
    auto reader = must(open_clip(file, std::nullopt, known));
    const auto frame = must(reader->next());
    const Scene& scene = reader->scene();
    std::int64_t valid = 0;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            const std::uint16_t code = stored_code(frame->depth, scene.depth, x, y);
            const double depth = wanted.depth(x, y);
            ASSERT_EQ(scene.depth.is_valid(code), depth > 0) << x << ", " << y << " stored " << code;
            if (depth == 0) continue;
            ++valid;
            ASSERT_TRUE(is_at(scene, code, wanted.camera, x, y, depth, wanted.relative * depth));
        }
    EXPECT_GT(valid, scene.width * scene.height / 2);
}

SourceDescription preset(const char* name) {
    return stated(&SourceDescription::preset, name);
}

void expect_disparities_of_swapped_bytes(const std::filesystem::path& file) {
    const std::string bytes = read_bytes(file);
    const std::size_t begin = bytes.size() - 2 * 640 * 480;
    const auto depth = [&](int x, int y) {
        const std::size_t at = begin + 2 * static_cast<std::size_t>(640 * y + x);
        // The file has the low byte first, where PGM has the high one.
        const int d = static_cast<unsigned char>(bytes[at]) | static_cast<unsigned char>(bytes[at + 1]) << 8;
        return d == 0 || d == 2047 || d > 1092 ? 0 : 351.3 / (1092.5 - d);
    };
    // Without a description it is the same: the values show how they are stored.
    for (const SourceDescription& known : {preset("nyu"), SourceDescription()})
        expect_points(file, known, {{582.62, 582.69, 313.04, 238.44}, depth});
}

TEST(RealPictures, ReadNyuDisparities) {
    const auto file = real_data("other_formats/NYU_depth.pgm");
    TOUCHABLE_NEEDS_DATA(file);
    expect_disparities_of_swapped_bytes(file);
}

TEST(PictureStandIns, ReadNyuDisparities) {
    const TemporaryFolder folder;
    std::string bytes = "P5 640 480 65535\n";
    for (int y = 0; y < 480; ++y)
        for (int x = 0; x < 640; ++x) {
            // A slope, what saw nothing, and what is too far to be told.
            const int d = x % 40 == 0 ? 2047 : x % 40 == 1 ? 0 : x % 40 == 2 ? 1093 + y : 500 + x / 2 + y / 2;
            bytes += static_cast<char>(d & 0xff);
            bytes += static_cast<char>(d >> 8);
        }
    write_bytes(folder / "depth.pgm", bytes);
    expect_disparities_of_swapped_bytes(folder / "depth.pgm");
}

void expect_inverse_depth_without_a_scale(const std::filesystem::path& file) {
    const std::string bytes = read_bytes(file);
    std::vector<float> values(640 * 640);
    std::memcpy(values.data(), bytes.data() + bytes.size() - 4 * values.size(), 4 * values.size());
    const double least = *std::min_element(values.begin(), values.end()),
                 range = *std::max_element(values.begin(), values.end()) - least,
                 f = 320 / std::tan(M_PI / 6);
    const auto depth = [&](int x, int y) {
        const double share = (values[static_cast<std::size_t>(640 * y + x)] - least) / range;
        return 1 / (1 / 1.5 + share * (1 / 0.5 - 1 / 1.5));
    };
    // Half of one of 65534 steps of 1/depth, 1.33 in all, at 1.5 m.
    expect_points(file, preset("relative-inverse"),
                  {{f, f, 319.5, 319.5}, depth, 0.5 * 1.5 * 1.334 / 65534 * 1.01});
}

TEST(RealPictures, ReadMidasInverseDepth) {
    const auto file = real_data("stills/midas_moon/moon.npy");
    TOUCHABLE_NEEDS_DATA(file);
    expect_inverse_depth_without_a_scale(file);
}

TEST(RealPictures, OpenRedwoodWithCamera) {
    const auto folder = real_data("stills/redwood5");
    TOUCHABLE_NEEDS_DATA(folder);
    auto reader = must(open_clip(folder));
    EXPECT_EQ(reader->frame_count(), 5);
    EXPECT_EQ(reader->scene().camera.fx, 525);
    EXPECT_EQ(reader->scene().camera.cx, 319.5);
    EXPECT_EQ(reader->tracks().size(), 2U);
    EXPECT_EQ(reader->scene().depth.depth(1861), 1.861);
}

}  // namespace
}  // namespace touchable::test
