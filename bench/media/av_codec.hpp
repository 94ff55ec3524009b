#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/media/packed_picture.hpp"
#include "bench/media/plane_codec.hpp"

namespace touchable {

/// One of FFmpeg's encoders and how it is set.
struct AvSettings {
    std::string encoder;
    Packing packing;
    int slices = 1, access_every = 1;  ///< frames from one access point to the next
    std::vector<std::pair<std::string, std::string>> options{};
};

/// An encoder of FFmpeg, and the decoder that belongs to it, each on one thread: the plain loop of send and
/// receive that any program has.
Result<std::unique_ptr<PlaneCodec>> open_av_codec(const AvSettings& settings, const PlaneView& first);

}  // namespace touchable
