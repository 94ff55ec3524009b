#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/media/packed_picture.hpp"
#include "bench/media/plane_codec.hpp"

namespace touchable {

/// One of FFmpeg's encoders and its settings.
struct AvSettings {
    std::string encoder;
    PicturePacking packing;
    int slices = 1, access_every = 1;  ///< frames between access points
    std::vector<std::pair<std::string, std::string>> options{};
};

/// An encoder of FFmpeg and its decoder, each on one thread, in the usual loop of send and receive.
Result<std::unique_ptr<PlaneCodec>> open_av_codec(const AvSettings& settings, const PlaneView& first);

}  // namespace touchable
