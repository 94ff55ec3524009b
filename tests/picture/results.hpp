// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <zip.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/must.hpp"

namespace touchable::test {

/// A clip and all its frames.
struct ReadClip {
    std::unique_ptr<ClipReader> clip;
    std::vector<RawFrame> frames;
};
inline ReadClip must_read(Result<std::unique_ptr<ClipReader>> opened, const char* file = __builtin_FILE(),
                          int line = __builtin_LINE()) {
    auto clip = must(std::move(opened), file, line);
    auto frames = must(read_all(*clip), file, line);
    return {std::move(clip), std::move(frames)};
}

/// Writes a clip of these frames.
template <class Writer>
void write_frames(Result<std::unique_ptr<Writer>> created, const std::vector<RawFrame>& frames) {
    const auto writer = must(std::move(created));
    for (const RawFrame& frame : frames) ASSERT_EQ(message(writer->write(frame)), "");
    ASSERT_EQ(message(writer->finish()), "");
}

/// Tests that need a folder of their own.
class FolderTest : public ::testing::Test {
protected:
    const TemporaryFolder folder;
};

/// A picture whose samples `sample(x, y, channel)` gives; those of two bytes have the low one first.
template <class Sample>
Image made_image(int width, int height, int bytes, int channels, Sample&& sample) {
    Image image{width, height, bytes, channels, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c) {
                const auto code = static_cast<unsigned>(sample(x, y, c));
                image.samples.push_back(static_cast<std::uint8_t>(code & 255U));
                if (bytes == 2) image.samples.push_back(static_cast<std::uint8_t>(code >> 8U));
            }
    return image;
}
/// The same in one colour or grey.
inline Image even_image(int width, int height, int bytes, int channels, int code) {
    return made_image(width, height, bytes, channels, [&](int, int, int) { return code; });
}

/// Makes the folder that a file is in, and writes PNG or bytes.
inline void write_in_folder(const std::filesystem::path& file, const Image& image) {
    std::filesystem::create_directories(file.parent_path());
    ASSERT_EQ(message(write_png(file, image.view())), "");
}
inline void write_in_folder(const std::filesystem::path& file, const std::string& bytes) {
    std::filesystem::create_directories(file.parent_path());
    write_bytes(file, bytes);
}

/// Whether a pixel's point, by its code and the scene, is where `camera` sees it at z metres.
inline ::testing::AssertionResult is_at(const Scene& scene, std::uint16_t code, const Camera& camera, int x,
                                        int y, double z, double tolerance) {
    const glm::dvec3 point = unproject(scene.camera, x, y, scene.depth.depth(code)) * scene.metres_per_unit;
    const glm::dvec3 off =
        point - glm::dvec3{(x - camera.cx) / camera.fx * z, -(y - camera.cy) / camera.fy * z, -z};
    if (std::abs(off.x) <= tolerance && std::abs(off.y) <= tolerance && std::abs(off.z) <= tolerance)
        return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "pixel " << x << ", " << y << " at z = " << z << " is off by "
                                         << off.x << ", " << off.y << ", " << off.z;
}

/// Whether a scene's remarks have these words.
inline bool has_remark(const Scene& scene, const std::string& words) {
    return std::ranges::any_of(scene.remarks, [&](const Remark& remark) {
        return remark_in_words(remark).find(words) != std::string::npos;
    });
}

/// A picture of an FFmpeg format, encoded; `fill` sets its samples.
template <class Fill>
std::string encoded(const char* codec_name, AVPixelFormat format, int width, int height, Fill&& fill) {
    const AVCodec* codec = avcodec_find_encoder_by_name(codec_name);
    const CodecPtr encoder(avcodec_alloc_context3(codec));
    const FramePtr frame(av_frame_alloc());
    const PacketPtr packet(av_packet_alloc());
    encoder->width = frame->width = width;
    encoder->height = frame->height = height;
    encoder->pix_fmt = format;
    frame->format = format;
    encoder->time_base = {1, 1};
    encoder->flags |= AV_CODEC_FLAG_QSCALE;
    frame->quality = encoder->global_quality = 2 * FF_QP2LAMBDA;
    EXPECT_GE(avcodec_open2(encoder.get(), codec, nullptr), 0);
    EXPECT_GE(av_frame_get_buffer(frame.get(), 0), 0);
    fill(*frame);
    EXPECT_GE(avcodec_send_frame(encoder.get(), frame.get()), 0);
    EXPECT_GE(avcodec_send_frame(encoder.get(), nullptr), 0);
    EXPECT_GE(avcodec_receive_packet(encoder.get(), packet.get()), 0);
    return {reinterpret_cast<const char*>(packet->data), static_cast<std::size_t>(packet->size)};
}

/// JPEG of full range, and PNG of three colours and alpha, by FFmpeg: `sample(x, y, k)` is the k-th of a
/// pixel's.
template <class Sample>
std::string jpeg_of(int width, int height, Sample&& sample) {
    return encoded("mjpeg", AV_PIX_FMT_YUVJ444P, width, height, [&](AVFrame& frame) {
        for (int k = 0; k < 3; ++k)
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    frame.data[k][y * frame.linesize[k] + x] = static_cast<std::uint8_t>(sample(x, y, k));
    });
}
template <class Sample>
std::string rgba_png(int width, int height, Sample&& sample) {
    return encoded("png", AV_PIX_FMT_RGBA, width, height, [&](AVFrame& frame) {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int k = 0; k < 4; ++k)
                    frame.data[0][y * frame.linesize[0] + 4 * x + k] =
                        static_cast<std::uint8_t>(sample(x, y, k));
    });
}

/// A PFM file, whose rows go from the bottom to the top.
template <class Value>
std::string pfm_of(int width, int height, Value&& value) {
    std::string bytes = "Pf\n" + std::to_string(width) + ' ' + std::to_string(height) + "\n-1.0\n";
    for (int y = height - 1; y >= 0; --y)
        for (int x = 0; x < width; ++x) {
            const auto number = static_cast<float>(value(x, y));
            bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
        }
    return bytes;
}

/// The header of a .npy file, as NumPy writes it.
inline std::string npy_header(const std::string& type, const std::string& shape) {
    std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    text.resize(117, ' ');
    return std::string("\x93NUMPY\1\0v\0", 10) + text + '\n';
}

/// A .npy file of floats of 32 bits.
inline std::string npy_bytes(const std::string& shape, const std::vector<float>& numbers) {
    return npy_header("<f4", shape).append(reinterpret_cast<const char*>(numbers.data()), 4 * numbers.size());
}

/// A .npz file of such arrays, packed.
inline void write_npz(const std::filesystem::path& file,
                      const std::vector<std::pair<std::string, std::string>>& arrays) {
    zip_t* const archive = zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
    for (const auto& [name, bytes] : arrays)
        zip_file_add(archive, (name + ".npy").c_str(),
                     zip_source_buffer(archive, bytes.data(), bytes.size(), 0), ZIP_FL_OVERWRITE);
    zip_close(archive);
}

}  // namespace touchable::test
