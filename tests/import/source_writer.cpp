// SPDX-License-Identifier: Apache-2.0
#include "tests/import/source_writer.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>

#include "tests/import/foreign_video.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {

namespace fs = std::filesystem;

double room(int n, int x, int y) {
    if (x < 4 && y < 4) return none;
    const double u = (x + 0.5) / wide * 2 - 1, v = (y + 0.5) / high * 2 - 1, wall = 1.8 + 0.2 * u;
    if (u > -0.35 + 0.03 * n && u < 0.2 + 0.03 * n && v > -0.3 && v < 0.45) return 1.1 + 0.05 * u;
    return v > 0 ? std::min(wall, 0.9 / v) : wall;
}

std::uint16_t room_code(double codes_per_metre, int n, int x, int y) {
    const double z = room(n, x, y);
    return std::isnan(z) ? std::uint16_t{0} : static_cast<std::uint16_t>(std::lround(codes_per_metre * z));
}
Depth room_in(double codes_per_metre) {
    return [=](int n, int x, int y) {
        const int code = room_code(codes_per_metre, n, x, y);
        return code == 0 ? none : code / codes_per_metre;
    };
}

std::vector<float> floats_of(const Depth& depth, double of_none, int n) {
    std::vector<float> values;
    for (int y = 0; y < high; ++y)
        for (int x = 0; x < wide; ++x) {
            const double z = depth(n, x, y);
            values.push_back(static_cast<float>(std::isnan(z) ? of_none : z));
        }
    return values;
}
std::string shape_of_room(const std::string& before, const std::string& after) {
    return before + std::to_string(high) + ", " + std::to_string(wide) + after;
}
Depth millimetres(const Depth& metres) {
    return [=](int n, int x, int y) { return 1000 * metres(n, x, y); };
}
void write_exr(const fs::path& file, const std::map<std::string, std::vector<float>>& channels) {
    Imf::Header header(wide, high);
    Imf::FrameBuffer frame;
    auto copies = channels;
    for (auto& [name, values] : copies) {
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 4 * wide));
    }
    Imf::OutputFile out(file.c_str(), header);
    out.setFrameBuffer(frame);
    out.writePixels(high);
}

void write_tiff(const fs::path& file, std::vector<float> values) {
    TIFF* const out = TIFFOpen(file.c_str(), "w");
    ASSERT_NE(out, nullptr);
    TIFFSetField(out, TIFFTAG_IMAGEWIDTH, wide);
    TIFFSetField(out, TIFFTAG_IMAGELENGTH, high);
    TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, 32);
    TIFFSetField(out, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
    TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    for (int y = 0; y < high; ++y)
        EXPECT_EQ(TIFFWriteScanline(out, values.data() + std::ptrdiff_t{y} * wide, static_cast<unsigned>(y)),
                  1);
    TIFFClose(out);
}

void write_pfm(const fs::path& file, const std::vector<float>& values) {
    write_bytes(file, pfm_of(wide, high,
                             [&](int x, int y) { return values[static_cast<std::size_t>(y * wide + x)]; }));
}

/// PGM of 16 bits, high byte first, or as libfreenect's `record` has it, low byte first.
void write_pgm(const fs::path& file, bool low_first, const std::function<std::uint16_t(int, int)>& code) {
    std::string bytes = "P5 " + std::to_string(wide) + ' ' + std::to_string(high) + " 65535\n";
    for (int y = 0; y < high; ++y)
        for (int x = 0; x < wide; ++x) {
            const char low = static_cast<char>(code(x, y) & 255), up = static_cast<char>(code(x, y) >> 8);
            bytes += low_first ? low : up;
            bytes += low_first ? up : low;
        }
    write_bytes(file, bytes);
}

void write_film(const fs::path& file, int frames, AVRational rate) {
    fs::create_directories(file.parent_path());
    ForeignVideo video{"libx264", AV_PIX_FMT_YUV420P, wide, high, frames, rate};
    write_video(file, video, [](AVFrame& frame, int n) {
        for (int plane = 0; plane < 3; ++plane)
            fill_plane(frame, plane, [&](int x, int) { return plane ? 70 + x : 40 + x + n; });
    });
}

std::string six_digits(int n) {
    const std::string digits = std::to_string(n);
    return std::string(6 - digits.size(), '0') + digits;
}

fs::path Writer::operator/(const std::string& name) const {
    fs::path file = folder_ / name;
    fs::create_directories(file.parent_path());
    return file;
}

void Writer::text(const std::string& name, const std::string& words) const {
    write_in_folder(folder_ / name, words);
}

void Writer::png16(const std::string& name, const std::function<int(int, int)>& code, int width,
                   int height) const {
    write_in_folder(folder_ / name,
                    made_image(width, height, 2, 1, [&](int x, int y, int) { return code(x, y); }));
}

void Writer::room16(const std::string& name, double codes_per_metre, int n) const {
    png16(name, [=](int x, int y) { return room_code(codes_per_metre, n, x, y); });
}

void Writer::grey(const std::string& name, const std::function<int(int, int)>& code) const {
    write_in_folder(folder_ / name,
                    made_image(wide, high, 1, 1, [&](int x, int y, int) { return code(x, y); }));
}

void Writer::colour(const std::string& name, int width, int height) const {
    const auto sample = [](int x, int y, int k) { return k == 0 ? 200 - x / 4 : k == 1 ? 40 + y : 90; };
    if (name.ends_with(".jpg")) return write_bytes(*this / name, jpeg_of(width, height, sample));
    write_in_folder(folder_ / name, made_image(width, height, 1, 3, sample));
}

}  // namespace touchable::test
