#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

using Packet = std::vector<std::uint8_t>;

/// Encodes the pictures of a plane to packets, one each, and decodes them. On the caller's thread.
class PlaneCodec {
public:
    virtual ~PlaneCodec() = default;
    virtual Result<void> encode(const PlaneView& plane, Packet& packet) = 0;
    /// In the order of encoding; at least the first picture must be encoded.
    virtual Result<void> decode(const Packet& packet) = 0;
    /// The plane decoded last, in the original form; valid until the next call.
    virtual Result<PlaneView> plane() = 0;
};

struct CodecChoice {
    std::string name;
    bool lossless = true;
    /// For planes in the form of this one.
    std::function<Result<std::unique_ptr<PlaneCodec>>(const PlaneView& first)> open;
};
/// The codecs to measure for planes of a role in the form of `first`. The first one is FFV1 as in the first
/// clips.
std::vector<CodecChoice> codec_choices(PlaneRole role, const PlaneView& first);

}  // namespace touchable
