// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nodes of V4L2 (Linux's video devices), and a stream of pictures from one.
//
// VideoSystem is the system's side, which a test replaces. look_at_node tells what a node offers,
// depth_of_node and choose_mode choose from that, and a V4l2Stream gives the pictures, copied, with the times
// at which they were taken.
//
// Different threads may use different devices at once; a stream is one thread's.

#include <linux/videodev2.h>
#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The calls of the system's video devices that this module makes, so that a test can stand in for them. Each
/// returns what the system's returns: -1, or MAP_FAILED, with errno.
class VideoSystem {
public:
    virtual ~VideoSystem() = default;
    /// Existing nodes, such as "/dev/video0", in the order of their numbers.
    virtual std::vector<std::string> nodes() = 0;
    /// Opens for reading and writing, so that no call waits.
    virtual int open(const char* node) = 0;
    virtual int close(int descriptor) = 0;
    virtual int ioctl(int descriptor, unsigned long request, void* argument) = 0;
    /// Shared, for reading and writing.
    virtual void* mmap(int descriptor, std::size_t length, std::int64_t offset) = 0;
    virtual int munmap(void* memory, std::size_t length) = 0;
    virtual int poll(std::span<pollfd> descriptors, int timeout_ms) = 0;
};

/// This machine's.
std::shared_ptr<VideoSystem> system_video();

/// Repeats an ioctl that a signal interrupted.
int call(VideoSystem& system, int descriptor, unsigned long request, void* argument);

/// The processes that have a device open, such as "cheese (process 123)", as far as this user may see them;
/// empty: none seen.
std::string users_of_node(const std::string& node);

/// A size of pictures that a camera offers, and at which rates.
struct NodeMode {
    int width = 0, height = 0;
    std::vector<FrameRate> rates{};  ///< the fastest first; empty: the camera does not say
};

/// A kind of pictures that a camera offers.
struct NodeFormat {
    std::uint32_t code = 0;         ///< V4L2_PIX_FMT_...
    std::vector<NodeMode> modes{};  ///< empty: the camera does not say
    bool any_size = false;          ///< any size between the least and the greatest of `modes`, too
};

/// Facts of a node, as its driver states them.
struct NodeFacts {
    std::string node, driver, card, bus;
    bool captures = false;  ///< gives pictures in mapped memory, unlike nodes of metadata
    std::vector<NodeFormat> formats{};

    bool is_realsense() const { return card.find("RealSense") != std::string::npos; }
};

/// Opens a node, reads its facts and closes it. Other programs may use it meanwhile.
Result<NodeFacts> look_at_node(VideoSystem& system, const std::string& node);

/// Whether pictures of this format can be touched: Z16, and grey of 16 bits in either byte order.
bool is_depth_format(std::uint32_t code);
/// The format by which a node is touched: Z16, which is depth for certain, before grey. An error lists what
/// it offers instead.
Result<const NodeFormat*> depth_of_node(const NodeFacts& facts);
/// Whether pictures of this format can be shown as colour.
bool is_colour_format(std::uint32_t code);
/// "Z16", "YUYV"; "Y16 (big-endian)".
std::string format_text(std::uint32_t code);
/// All formats of a node: "Z16, YUYV"; "nothing".
std::string formats_text(const NodeFacts& facts);

/// "30", "29.97", of frames a second.
std::string rate_text(const FrameRate& rate);

/// The mode that is wanted; unset: the usual one.
struct ModeWish {
    int width = 0, height = 0;        ///< 0: the largest of usual rate, up to 1280x720
    std::optional<double> rate = {};  ///< frames a second; nothing: 30, or the nearest to that
};
/// The mode to ask for; its `rates` has one rate, or none if the camera states none. An error, without the
/// node's name, if the format has no such size.
Result<NodeMode> choose_mode(const NodeFormat& format, const ModeWish& wish);

/// "640x480 at 30, 15 frames/s".
std::string mode_text(const NodeMode& mode);

/// How a stream's pictures lie in memory, as the driver settled it.
struct StreamFormat {
    std::uint32_t code = 0;
    int width = 0, height = 0;
    std::ptrdiff_t stride = 0;  ///< bytes from row to row of the first plane
    std::size_t least = 0;      ///< bytes of a whole picture; 1 if coded
};

/// A picture as the camera gave it, copied.
struct TakenPicture {
    std::shared_ptr<std::vector<std::uint8_t>> bytes;
    std::uint32_t sequence = 0;  ///< the driver's count; lost pictures leave gaps
    std::int64_t at_ns = 0;      ///< of std::chrono::steady_clock
    bool timed_by_driver = false;
};

/// A camera is given up after this many faults of its driver in a row.
inline constexpr int most_faults_in_a_row = 100;

/// A stream of a camera's pictures, in mapped buffers that its driver fills. It owns the device for its
/// lifetime. Used by one thread.
class V4l2Stream : NonCopyable {
public:
    /// Chooses the mode, and starts. An error names the node.
    static Result<std::unique_ptr<V4l2Stream>> open(std::shared_ptr<VideoSystem> system,
                                                    const NodeFacts& facts, const NodeFormat& format,
                                                    const ModeWish& wish);
    ~V4l2Stream();

    const StreamFormat& format() const { return format_; }
    /// As the driver settled it; nullopt: not stated.
    const std::optional<FrameRate>& rate() const { return rate_; }
    /// For poll: readable once a picture is there.
    int descriptor() const { return descriptor_; }

    enum class Which { oldest, newest };
    /// Takes the oldest available picture, or the newest, giving those before it back unread. Nullopt if
    /// there is none, or only damaged ones, which are counted. An error, without the node's name, if no more
    /// will come.
    Result<std::optional<TakenPicture>> take(Which which);
    /// Pictures that the driver marked as damaged, or that were too short.
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
    bool is_whole(const v4l2_buffer& buffer) const {
        return (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && buffer.bytesused >= format_.least &&
               buffer.bytesused <= buffers_[buffer.index].length;
    }
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
