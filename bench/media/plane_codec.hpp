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

/// Stores the pictures of a plane in packets, one each, and reads them again. On the caller's thread.
class PlaneCodec {
public:
    virtual ~PlaneCodec() = default;
    virtual Result<void> encode(const PlaneView& plane, Packet& packet) = 0;
    /// In the order of encoding, after the first was encoded.
    virtual Result<void> decode(const Packet& packet) = 0;
    /// What was decoded last, in the form that went in; until the next call.
    virtual Result<PlaneView> plane() = 0;
};

struct CodecChoice {
    std::string name;
    bool lossless = true;
    /// For planes in the form of this one.
    std::function<Result<std::unique_ptr<PlaneCodec>>(const PlaneView& first)> open;
};
/// What is worth measuring for planes of a role in the form of `first`. The first is FFV1 as clips had it
/// before others.
std::vector<CodecChoice> codec_choices(PlaneRole role, const PlaneView& first);

}  // namespace touchable
