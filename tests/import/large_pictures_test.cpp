// Pictures of any kind take as much memory as their pixels need, and hear a stop.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <tiffio.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <map>
#include <stop_token>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limited_memory.hpp"

namespace touchable::test::large {
namespace {

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

std::string npy_header(const std::string& kind) {
    std::string text = "{'descr': '" + kind + "', 'fortran_order': False, 'shape': (" + std::to_string(side) +
                       ", " + std::to_string(side) + "), }";
    text.resize(117, ' ');
    text += '\n';
    return std::string("\x93NUMPY\1\0", 8) + static_cast<char>(text.size()) + '\0' + text;
}

/// Of doubles, packed.
void write_npz(const std::filesystem::path& file, const TemporaryFolder& folder) {
    write_rows(folder / "whole.npy", npy_header("<f8"), bytes_of(row_of<double>(1)));
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
    if (kind == ".npy") write_rows(file, npy_header("<f4"), bytes_of(row_of<float>(1)));
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

TEST_P(LargePicture, TakesWhatItsPixelsNeed) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / (std::string("depth") + GetParam());
    write_large(file, folder);
    const double bytes_per_pixel = GetParam() == std::string(".npz") ? 9 : 5;
    const PeakMemory peak;
    const auto clip = open_clip(file);
    ASSERT_EQ(message(clip), "");
    EXPECT_LE(peak.mebibytes(), 128 + bytes_per_pixel * side * side / (1 << 20));
    EXPECT_EQ((*clip)->scene().width, side);
}

TEST_P(LargePicture, EndsWhenStopped) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / (std::string("depth") + GetParam());
    write_large(file, folder);
    auto bytes = read_picture_bytes(file);
    ASSERT_EQ(message(bytes), "");
    std::stop_source given_up;
    const StopScope until(given_up.get_token());
    given_up.request_stop();
    // The decoders themselves, where they last: `decode_stored_image` does not begin once it is stopped.
    const std::map<std::string, Result<StoredImage> (*)(std::string_view, const std::string&)> decoders{
        {".png", decode_coded_image},
        {".tif", decode_tiff},
        {".exr", decode_exr},
        {".npy", decode_npy},
        {".npz", decode_npz}};
    const auto decoder = decoders.find(GetParam());
    const auto stored = decoder == decoders.end() ? decode_stored_image(std::move(*bytes), "picture")
                                                  : decoder->second(*bytes, "picture");
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
