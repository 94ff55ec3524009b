#pragma once

// One rendition of HlsWriter, for this room's .cpp files only.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/stream/hls_text.hpp"
#include "engine/stream/labelled_encoder.hpp"
#include "engine/stream/memory_muxer.hpp"

namespace touchable {

/// Which of a stream's renditions: colour or the planes that are felt, of the full or of the low level.
struct HlsRenditionForm {
    bool is_colour = false, is_low = false;

    std::string name() const { return std::string(is_colour ? "colour" : "touch") + (is_low ? "-low" : ""); }
    std::string playlist() const { return name() + ".m3u8"; }
    /// Its frames are so far apart.
    int step() const { return is_low && !is_colour ? hls_low_step : 1; }
};

/// Encodes a rendition into fragmented MP4.
class HlsRenditionOutput {
public:
    /// `sound`: goes along; null: none does.
    static Result<HlsRenditionOutput> open(const HlsRenditionForm& form, const RawFrame& first,
                                           const SceneDescription& described, const AVCodecParameters* sound);

    const HlsRenditionForm& form() const { return form_; }
    /// `duration_ns`: until the rendition's next frame. Where `is_key`, decoding can begin with it.
    Result<void> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                     std::int64_t duration_ns, bool is_key);
    bool has_sound() const { return sound_stream_.has_value(); }
    /// Its times are in milliseconds.
    Result<void> add_sound(const AVPacket& packet);
    /// The bytes of all that was added since the last time; at first of the initialisation.
    Result<std::vector<std::uint8_t>> take();
    /// "avc1.64001f,mp4a.40.2".
    Result<std::string> codecs() const;

private:
    HlsRenditionOutput(const HlsRenditionForm& form, LabelledEncoder encoder,
                       std::unique_ptr<MemoryMuxer> muxer)
        : form_(form), encoder_(std::move(encoder)), muxer_(std::move(muxer)) {}
    Result<void> begin(const AVCodecParameters* sound);
    Result<void> begin_sound(const AVCodecParameters& sound);

    HlsRenditionForm form_;
    LabelledEncoder encoder_;  // its track k is stream k
    std::unique_ptr<MemoryMuxer> muxer_;
    std::optional<int> sound_stream_;
};

}  // namespace touchable
