#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/picture_label.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// A frameset on its way, as a container has it: bytes that follow those of any frameset before. A listener
/// may begin with any that is a key.
struct StreamBlock {
    std::int64_t frame = 0;  ///< its number in the stream
    bool is_key = false;     ///< decoding of all planes begins here
    std::vector<std::uint8_t> bytes;
    /// So many at the end are its colour alone. Whoever goes without them does so until the next key.
    std::size_t colour_bytes = 0;

    std::span<const std::uint8_t> given(bool with_colour) const {
        return std::span(bytes).first(bytes.size() - (with_colour ? 0 : colour_bytes));
    }
};

/// Makes the bytes of a stream, once for all listeners. One thread. Every plane that is felt is lossless,
/// each picture is labelled and can be checked; the scene goes with each beginning.
class StreamMuxer {
public:
    virtual ~StreamMuxer() = default;
    /// What every listener is given first; once the first frame was added.
    virtual std::span<const std::uint8_t> header() const = 0;
    /// A few bytes that say nothing and may follow any block.
    virtual std::span<const std::uint8_t> padding() const { return {}; }
    /// The next frame of the stream, shown `time_ns` after its beginning; planes as the first one had them.
    virtual Result<StreamBlock> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                                    bool is_key) = 0;
};

}  // namespace touchable
