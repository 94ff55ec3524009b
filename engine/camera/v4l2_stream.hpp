#pragma once

// Nodes of V4L2 (Linux's video devices), and a stream of pictures from one.
//
// VideoSystem is the system's side, which a test replaces. look_at_node tells what a node offers,
// depth_of_node and choose_mode choose of that, and a V4l2Stream gives the pictures, copied, with the times
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
    /// Nodes that there are, such as "/dev/video0", in the order of their numbers.
    virtual std::vector<std::string> nodes() = 0;
    /// For reading and writing, and so that no call waits.
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

/// A call that a signal broke off is made again.
int call(VideoSystem& system, int descriptor, unsigned long request, void* argument);

/// The processes that have a device open, such as "cheese (process 123)", as far as this user may see; empty:
/// none that is seen.
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
    bool any_size = false;          ///< sizes between the least and the greatest in `modes`, too
};

/// What a node is, as its driver tells.
struct NodeFacts {
    std::string node, driver, card, bus;
    bool captures = false;  ///< gives pictures by memory that is mapped; nodes of metadata do not
    std::vector<NodeFormat> formats{};
};

/// Opens it to look, and closes it again. Others may use it meanwhile.
Result<NodeFacts> look_at_node(VideoSystem& system, const std::string& node);

/// Whether pictures of this format can be touched: Z16, and grey of 16 bits in either byte order.
bool is_depth_format(std::uint32_t code);
/// The format by which a node is touched: Z16, which is depth for certain, before grey. An error names what
/// it gives instead.
Result<const NodeFormat*> depth_of_node(const NodeFacts& facts);
/// Whether pictures of this format can be shown as colour.
bool is_colour_format(std::uint32_t code);
/// "Z16", "YUYV"; "Y16 (big-endian)".
std::string format_text(std::uint32_t code);
/// All formats of a node: "Z16, YUYV"; "nothing".
std::string formats_text(const NodeFacts& facts);
/// "640x480".
std::string size_text(std::int64_t width, std::int64_t height);

/// "30", "29.97", of frames a second.
std::string rate_text(const FrameRate& rate);

/// What is wanted of a stream; nothing: what is usual.
struct ModeWish {
    int width = 0, height = 0;        ///< 0: the largest of usual rate, up to 1280x720
    std::optional<double> rate = {};  ///< frames a second; nothing: 30, or the nearest to that
};
/// The mode to ask for. `rates` of it has one rate, or none where the camera does not say. An error, without
/// the node's name, where the format has no such size.
Result<NodeMode> choose_mode(const NodeFormat& format, const ModeWish& wish);

/// "640x480 at 30, 15 frames/s".
std::string mode_text(const NodeMode& mode);

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

/// A camera is left at so many faults in a row that its driver says.
inline constexpr int most_faults_in_a_row = 100;

/// A stream of a camera's pictures by buffers that its driver fills and that are mapped here. It owns the
/// device while it is there. One thread.
class V4l2Stream : NonCopyable {
public:
    /// Chooses the mode, and starts. An error names the node.
    static Result<std::unique_ptr<V4l2Stream>> open(std::shared_ptr<VideoSystem> system,
                                                    const NodeFacts& facts, const NodeFormat& format,
                                                    const ModeWish& wish);
    ~V4l2Stream();

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
