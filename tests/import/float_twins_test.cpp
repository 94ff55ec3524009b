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

#include <cmath>
#include <functional>

#include "engine/content/seeded_noise.hpp"
#include "engine/scene/frames.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/encoded_picture.hpp"

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
    auto reader = open_clip(file, std::nullopt, known);
    EXPECT_EQ(message(reader), "") << file;
    if (!reader) return {};
    const auto frame = (*reader)->next();
    EXPECT_EQ(message(frame), "") << file;
    const Scene& scene = (*reader)->scene();
    EXPECT_EQ(scene.width, twin_wide);
    Opened opened{scene.depth, {}, {}, {}};
    for (int y = 0; y < twin_high; ++y)
        for (int x = 0; x < twin_wide; ++x) {
            opened.codes.push_back(stored_code((**frame).depth, scene.depth, x, y));
            const bool is_valid = scene.depth.is_valid(opened.codes.back());
            opened.depths.push_back(is_valid ? scene.depth.depth(opened.codes.back()) * scene.metres_per_unit
                                             : 0);
        }
    for (const std::string& note : clip_notes(**reader)) opened.notes += note + '\n';
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

TEST_F(FloatTwins, OfWholeUnitsHaveTheCodesAndTheCodingOfThePng) {
    for (const int units : {1000, 10'000, 8000, 5000, 4000}) {
        SCOPED_TRACE(units);
        const auto codes = camera_depth(units, 2.1);
        write_bytes(folder / "codes.u16", bytes_of(codes));
        Floats metres;
        for (const std::uint16_t code : codes)
            metres.push_back(static_cast<float>(code) / static_cast<float>(units));
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
            EXPECT_NE(found.notes.find("kept exactly"), std::string::npos) << found.notes;
        }
    }
}

/// Colour in the first part, depth in the second, which its name alone tells.
TEST_F(FloatTwins, OfAPartThatIsCalledDepthAreThoseOfThePng) {
    const auto codes = camera_depth(1000, 1.9);
    Floats metres;
    for (const std::uint16_t code : codes) metres.push_back(static_cast<float>(code) / 1000.0F);
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
    EXPECT_NE(found.notes.find("depth is channel depth.Y, colour is R, G, B"), std::string::npos)
        << found.notes;
}

/// What a person gets who says nothing.
TEST_F(FloatTwins, AreTheSameWhereTheUnitIsGuessed) {
    const auto codes = camera_depth(1000, 1.9);
    Floats metres;
    for (const std::uint16_t code : codes) metres.push_back(static_cast<float>(code) / 1000.0F);
    write_exr(folder / "a.exr", metres, false);
    png(codes, 0.001);
    const Opened wanted = opened_depth(folder / "twin.png", {}), found = opened_depth(folder / "a.exr", {});
    EXPECT_EQ(found.depths, wanted.depths);
    EXPECT_EQ(found.coding.scale, wanted.coding.scale);
    EXPECT_EQ(found.coding.far, wanted.coding.far);
}

/// Below 2 m halves are less than a millimetre apart, and rounding leaves none of them between two. Beyond,
/// a millimetre may come back as its neighbour.
TEST_F(FloatTwins, OfHalvesAreMillimetresAsFarAsHalvesCanTell) {
    const auto codes = camera_depth(1000, 2.7);
    Floats metres;
    for (const std::uint16_t code : codes) metres.push_back(static_cast<float>(code) / 1000.0F);
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
    EXPECT_NE(found.notes.find("11 bits"), std::string::npos) << found.notes;
}

/// What stereo matching leaves: baseline times focal length over eighths of a pixel. The unprojection is
/// written out here.
TEST_F(FloatTwins, OfDisparitiesKeepEachOfThem) {
    const auto eighths = camera_depth(100, 2.0);  // any whole numbers will do
    const float focal_baseline = 61.37F;
    Floats metres;
    std::vector<double> wanted;
    for (const std::uint16_t code : eighths) {
        metres.push_back(code == 0 ? 0 : focal_baseline / (static_cast<float>(code) / 8));
        wanted.push_back(code == 0 ? 0 : 61.37 / (code / 8.0));
    }
    write_exr(folder / "a.exr", metres, false);
    auto reader = open_clip(folder / "a.exr", std::nullopt, metres_a_code(1));
    ASSERT_EQ(message(reader), "");
    const auto frame = (*reader)->next();
    ASSERT_EQ(message(frame), "");
    const Scene& scene = (*reader)->scene();
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::inverse);
    EXPECT_LT(scene.depth.code_max, 600) << "as many codes as there are disparities";
    const double f = twin_wide / 2.0 / std::tan(M_PI / 6), cx = (twin_wide - 1) / 2.0,
                 cy = (twin_high - 1) / 2.0;
    int valid = 0;
    for (int y = 0; y < twin_high; ++y)
        for (int x = 0; x < twin_wide; ++x) {
            const double z = wanted[static_cast<std::size_t>(twin_wide * y + x)];
            const std::uint16_t code = stored_code((**frame).depth, scene.depth, x, y);
            if (!scene.depth.is_valid(code)) continue;
            ++valid;
            const glm::dvec3 point = unproject(scene.camera, x, y, scene.depth.depth(code));
            ASSERT_NEAR(point.x, (x - cx) / f * z, 1e-5 * z);
            ASSERT_NEAR(point.y, -(y - cy) / f * z, 1e-5 * z);
            ASSERT_NEAR(point.z, -z, 1e-5 * z);
        }
    EXPECT_GT(valid, twin_wide * twin_high * 9 / 10);
}

/// A stack of which a later frame, that nobody looked at, has what no frame before it had.
TEST_F(FloatTwins, OfAStackKeepMultiplesThatCameLater) {
    write_bytes(folder / "codes.u16", bytes_of(camera_depth(1000, 1.9)));
    if (!run_numpy("s = np.stack([c] * 60).astype('i4')\ns[17, 5, 7] = 231\ns[17, 5, 8] = 1803\n"
                   "np.save(f + 'stack', (s / 1000).astype('f4'))\n"))
        GTEST_SKIP() << "needs Python with NumPy (Debian: python3-matplotlib)";
    auto reader = open_clip(folder / "stack.npy", std::nullopt, metres_a_code(1));
    ASSERT_EQ(message(reader), "");
    ASSERT_EQ(message((*reader)->seek(17)), "");
    const auto frame = (*reader)->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_EQ((**frame).depth.sample(7, 5), 231);
    EXPECT_EQ((**frame).depth.sample(8, 5), 1803);
}

}  // namespace
}  // namespace touchable::test
