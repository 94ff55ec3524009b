#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/scene/scene_description.hpp"
#include "engine/stream/frameset_assembler.hpp"
#include "engine/stream/stream_bytes.hpp"

namespace touchable {

/// What a stream says of itself, and its pictures as they come, whatever container they are in.
class StreamPictures {
public:
    virtual ~StreamPictures() = default;
    /// Its scene, and the text that said so. A rate that is left open is `rate`.
    virtual const SceneDescription& described() const = 0;
    virtual const std::string& scene_text() const = 0;
    virtual const FrameRate& rate() const = 0;
    /// Of its planes, as far as they are known.
    virtual std::vector<PlaneRole> roles() const = 0;
    /// Of those of which a picture came.
    virtual std::vector<TrackInfo> tracks() const = 0;
    virtual void leave_out_colour() = 0;

    struct Came {
        std::vector<StreamPicture> pictures{};  ///< planes as they were sent
        std::int64_t torn = 0;                  ///< pictures whose checksum is wrong
    };
    /// Those that come next, which may be none; nothing once the sender has ended.
    virtual Result<std::optional<Came>> next() = 0;
    /// Once it has ended: how, such as "closed the connection"; and whether that was not its end.
    virtual std::string how_it_ended() const = 0;
    virtual bool was_lost() const = 0;
    /// Which level was read, where there is a choice.
    virtual std::optional<LevelFigures> levels() const { return std::nullopt; }
};

/// In our clips' own form; what labels its pictures lack, their times say. `described`: in place of its own
/// scene.
Result<std::unique_ptr<StreamPictures>> open_matroska_pictures(
    std::shared_ptr<StreamBytes> bytes, const std::string& name,
    const std::optional<SceneDescription>& described);

/// MPEG-TS, of which each picture says itself what it is (picture_message.hpp).
Result<std::unique_ptr<StreamPictures>> open_transport_stream(
    std::shared_ptr<StreamBytes> bytes, const std::string& name,
    const std::optional<SceneDescription>& described);

/// HTTP Live Streaming, of such pictures. `now_ns`: as HlsInput::open has it.
Result<std::unique_ptr<StreamPictures>> open_hls_stream(const StreamUrl& url,
                                                        std::shared_ptr<StreamWait> wait,
                                                        const std::optional<SceneDescription>& described,
                                                        std::function<std::int64_t()> now_ns = {});

}  // namespace touchable
