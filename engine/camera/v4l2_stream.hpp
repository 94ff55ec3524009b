#pragma once

#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/camera/node_facts.hpp"
#include "engine/camera/video_system.hpp"

namespace touchable {

/// How a stream's pictures lie in memory, as the driver settled it.
struct StreamFormat {
    std::uint32_t code = 0;
    int width = 0, height = 0;
    std::ptrdiff_t stride = 0;  ///< bytes from row to row of the first plane
    std::size_t least = 0;      ///< bytes that a whole picture has; of coded pictures 1
};

/// A picture as the camera gave it, copied.
struct TakenPicture {
    std::shared_ptr<std::vector<std::uint8_t>> bytes;
    std::uint32_t sequence = 0;  ///< the driver's count, in which pictures that were lost are missing
    std::int64_t at_ns = 0;      ///< of std::chrono::steady_clock
    bool timed_by_driver = false;
};

/// A stream of a camera's pictures by buffers that its driver fills and that are mapped here. It owns the
/// device while it is there. One thread.
class V4l2Stream {
public:
    /// Chooses the mode, and starts. An error names the node.
    static Result<std::unique_ptr<V4l2Stream>> open(std::shared_ptr<VideoSystem> system,
                                                    const NodeFacts& facts, const NodeFormat& format,
                                                    const ModeWish& wish);
    ~V4l2Stream();
    V4l2Stream(const V4l2Stream&) = delete;
    V4l2Stream& operator=(const V4l2Stream&) = delete;

    const StreamFormat& format() const { return format_; }
    /// As the driver settled it; nothing: it does not say.
    const std::optional<FrameRate>& rate() const { return rate_; }
    /// For poll: readable once a picture is there.
    int descriptor() const { return descriptor_; }

    enum class Which { oldest, newest };
    /// A picture that is there: the oldest, or the newest, those before it given back unread. Nothing where
    /// none is there, or only damaged ones, which are counted. An error once no more will come: what
    /// happened, without the node's name.
    Result<std::optional<TakenPicture>> take(Which which);
    /// That the driver said were damaged, or that were shorter than a picture.
    std::int64_t damaged() const { return damaged_; }

private:
    struct Mapped {
        void* memory = nullptr;
        std::size_t length = 0;
    };
    V4l2Stream(std::shared_ptr<VideoSystem> system, std::string node)
        : system_(std::move(system)), node_(std::move(node)) {}
    int ask(unsigned long request, void* argument) const {
        return call(*system_, descriptor_, request, argument);
    }
    Error trouble(int failure) const;
    Result<void> begin(std::uint32_t code, const NodeMode& mode);
    Result<void> set_format(std::uint32_t code, const NodeMode& mode);
    void set_rate(const NodeMode& mode);
    Result<void> map_buffers();
    Result<void> queue(std::uint32_t index);
    Result<std::optional<v4l2_buffer>> dequeue();
    bool is_whole(const v4l2_buffer& buffer) const;
    TakenPicture copied(const v4l2_buffer& buffer) const;

    std::shared_ptr<VideoSystem> system_;
    std::string node_;
    int descriptor_ = -1;
    StreamFormat format_;
    std::optional<FrameRate> rate_;
    std::vector<Mapped> buffers_;
    bool streams_ = false;
    std::int64_t damaged_ = 0;
    int failed_in_a_row_ = 0;
};

}  // namespace touchable
