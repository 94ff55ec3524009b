// SPDX-License-Identifier: Apache-2.0
#pragma once

// Videos as other programs write them.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::test {

/// A video as other programs write it.
struct ForeignVideo {
    const char* codec = "ffv1";  ///< FFmpeg's encoder
    AVPixelFormat format = AV_PIX_FMT_GRAY8;
    int width = 32, height = 16, frames = 3;
    AVRational rate{30, 1};
    AVColorRange range = AVCOL_RANGE_UNSPECIFIED;
    int interval = 1;                            ///< of pictures that decoding can begin with
    std::function<std::int64_t(int)> time_of{};  ///< of a frame, in units of 1 / rate
    bool lossless = true;                        ///< of H.264, HEVC and VP9
    std::uint32_t tag = 0;                       ///< how the container calls the codec; 0: as usual
};

inline bool can_encode(const char* codec) {
    return avcodec_find_encoder_by_name(codec) != nullptr;
}

/// `fill` sets the samples of a frame. The container is that of the file's name.
void write_video(const std::filesystem::path& file, const ForeignVideo& video,
                 const std::function<void(AVFrame& frame, int number)>& fill);

/// Sets a sample of a plane, of one byte or two.
void set_sample(AVFrame& frame, int plane, int x, int y, int value);
/// All samples of a plane.
void fill_plane(AVFrame& frame, int plane, const std::function<int(int x, int y)>& sample);
/// All pixels of packed RGB.
void fill_rgb(AVFrame& frame, const std::function<std::array<int, 3>(int x, int y)>& pixel);

using TitledFile = std::pair<std::filesystem::path, std::string>;
/// The first track of each file, with its title if any, in one file; `tag`: the codec's, 0: as usual.
void join_tracks(const std::vector<TitledFile>& sources, const std::filesystem::path& file,
                 std::uint32_t tag = 0);
/// QuickTime films of HEVC as iPhone's Cinematic video, which marks disparity by handler `auxv` and sample
/// entry `dish`.
void join_cinematic(const std::filesystem::path& colour, const std::filesystem::path& disparity,
                    const std::filesystem::path& file);

enum class QuicktimeCodec {
    png,  ///< without loss
    hap   ///< four by four pixels of two colours and what is between them, as Depthkit writes
};

/// Writes 8-bit RGB pictures as a QuickTime file. `time_of` gives each frame's time in units of 1/rate.num
/// seconds; its number times rate.den where evenly spaced.
void write_quicktime(const std::filesystem::path& file, const std::vector<Image>& pictures,
                     const FrameRate& rate, const std::function<std::int64_t(int)>& time_of = {},
                     QuicktimeCodec codec = QuicktimeCodec::png);

}  // namespace touchable::test
