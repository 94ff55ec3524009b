#include "engine/camera/v4l2_stream.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

// Enough for the driver to fill one while others wait, few enough that none is old.
constexpr std::uint32_t wanted_buffers = 4, most_buffers = 32;
constexpr int most_failures_in_a_row = 100;

constexpr bool is_coded(std::uint32_t code) {
    return code == V4L2_PIX_FMT_MJPEG || code == V4L2_PIX_FMT_JPEG;
}

/// Of a row of the first plane.
constexpr std::ptrdiff_t bytes_per_pixel(std::uint32_t code) {
    if (code == V4L2_PIX_FMT_RGB24 || code == V4L2_PIX_FMT_BGR24) return 3;
    return code == V4L2_PIX_FMT_NV12 ? 1 : 2;
}

/// Without what may lie behind the last row.
std::size_t picture_bytes(const StreamFormat& format) {
    if (is_coded(format.code)) return 1;
    const bool has_chroma_below = format.code == V4L2_PIX_FMT_NV12;
    const std::ptrdiff_t rows = has_chroma_below ? format.height + (format.height + 1) / 2 : format.height;
    return static_cast<std::size_t>(format.stride * (rows - 1) + bytes_per_pixel(format.code) * format.width);
}

std::int64_t now_ns() {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// When it was taken, by the driver where its clock is the machine's and what it says can be.
std::optional<std::int64_t> drivers_time(const v4l2_buffer& buffer, std::int64_t now) {
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
        return std::nullopt;
    constexpr std::int64_t oldest_ns = 10'000'000'000;
    const std::int64_t at_ns =
        std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 + std::int64_t{buffer.timestamp.tv_usec} * 1000;
    return at_ns <= now && at_ns > now - oldest_ns ? std::optional(at_ns) : std::nullopt;
}

v4l2_buffer blank_buffer(std::uint32_t index) {
    v4l2_buffer buffer = {};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    return buffer;
}

}  // namespace

Error V4l2Stream::trouble(int failure) const {
    return input_error(node_trouble(node_, failure));
}

Result<std::unique_ptr<V4l2Stream>> V4l2Stream::open(std::shared_ptr<VideoSystem> system,
                                                     const NodeFacts& facts, const NodeFormat& format,
                                                     const ModeWish& wish) {
    const auto mode = choose_mode(format, wish);
    if (!mode) return error_at(facts.node, mode.error());
    std::unique_ptr<V4l2Stream> stream(new V4l2Stream(std::move(system), facts.node));
    stream->descriptor_ = stream->system_->open(facts.node.c_str());
    if (stream->descriptor_ < 0) return stream->trouble(errno);
    TRY(stream->begin(format.code, *mode));
    return stream;
}

V4l2Stream::~V4l2Stream() {
    if (descriptor_ < 0) return;
    if (streams_) {
        int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        ask(VIDIOC_STREAMOFF, &type);
    }
    for (const Mapped& buffer : buffers_) system_->munmap(buffer.memory, buffer.length);
    system_->close(descriptor_);
}

Result<void> V4l2Stream::begin(std::uint32_t code, const NodeMode& mode) {
    if (auto set = set_format(code, mode); !set) return set;
    set_rate(mode);
    if (auto mapped = map_buffers(); !mapped) return mapped;
    for (std::uint32_t index = 0; index < buffers_.size(); ++index)
        if (auto queued = queue(index); !queued) return queued;
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ask(VIDIOC_STREAMON, &type) < 0) return trouble(errno);
    streams_ = true;
    return {};
}

/// The driver may settle for others than were wanted: another size is taken where nobody asked for one.
Result<void> V4l2Stream::set_format(std::uint32_t code, const NodeMode& mode) {
    v4l2_format wish = {};
    wish.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ask(VIDIOC_G_FMT, &wish) < 0) return trouble(errno);
    v4l2_pix_format& pixels = wish.fmt.pix;
    pixels.pixelformat = code;
    pixels.field = V4L2_FIELD_NONE;
    pixels.bytesperline = pixels.sizeimage = 0;  // as the driver has them
    if (mode.width > 0) {
        pixels.width = static_cast<std::uint32_t>(mode.width);
        pixels.height = static_cast<std::uint32_t>(mode.height);
    }
    if (ask(VIDIOC_S_FMT, &wish) < 0) return trouble(errno);
    const std::string settled = format_text(pixels.pixelformat) + " of " + std::to_string(pixels.width) +
                                "x" + std::to_string(pixels.height);
    const bool other_size = mode.width > 0 && (pixels.width != static_cast<std::uint32_t>(mode.width) ||
                                               pixels.height != static_cast<std::uint32_t>(mode.height));
    if (pixels.pixelformat != code || other_size)
        return input_error(node_ + ": its driver gives " + settled + " where " + format_text(code) +
                           (mode.width > 0
                                ? " of " + std::to_string(mode.width) + "x" + std::to_string(mode.height)
                                : std::string()) +
                           " was asked for; touchable cameras lists what it offers");
    constexpr std::uint32_t largest_side = 16384;
    if (pixels.width == 0 || pixels.height == 0 || pixels.width > largest_side ||
        pixels.height > largest_side)
        return input_error(node_ + ": its driver gives pictures of " + settled + "; sides must be 1 to " +
                           std::to_string(largest_side));
    format_ = {code, static_cast<int>(pixels.width), static_cast<int>(pixels.height),
               static_cast<std::ptrdiff_t>(pixels.bytesperline), 0};
    const std::ptrdiff_t packed = bytes_per_pixel(code) * format_.width;
    if (format_.stride == 0) format_.stride = packed;
    if (!is_coded(code) && format_.stride < packed)
        return input_error(node_ + ": its driver gives rows of " + std::to_string(format_.stride) +
                           " bytes, which " + settled + " does not fit into");
    format_.least = picture_bytes(format_);
    return {};
}

/// What cannot be set stays as it is; a driver without rates says none.
void V4l2Stream::set_rate(const NodeMode& mode) {
    v4l2_streamparm parameters = {};
    parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ask(VIDIOC_G_PARM, &parameters) < 0) return;
    v4l2_captureparm& capture = parameters.parm.capture;
    if (!mode.rates.empty() && (capture.capability & V4L2_CAP_TIMEPERFRAME) != 0) {
        const FrameRate& rate = mode.rates.front();
        capture.timeperframe = {static_cast<std::uint32_t>(rate.den), static_cast<std::uint32_t>(rate.num)};
        ask(VIDIOC_S_PARM, &parameters);
    }
    rate_ = rate_of_interval(capture.timeperframe.numerator, capture.timeperframe.denominator);
}

Result<void> V4l2Stream::map_buffers() {
    v4l2_requestbuffers request = {};
    request.count = wanted_buffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (ask(VIDIOC_REQBUFS, &request) < 0) return trouble(errno);
    if (request.count == 0 || request.count > most_buffers)
        return input_error(node_ + ": its driver gives " + std::to_string(request.count) + " buffers where " +
                           std::to_string(wanted_buffers) + " were asked for; is there memory?");
    for (std::uint32_t index = 0; index < request.count; ++index) {
        v4l2_buffer buffer = blank_buffer(index);
        if (ask(VIDIOC_QUERYBUF, &buffer) < 0) return trouble(errno);
        if (buffer.length < format_.least)
            return input_error(node_ + ": its driver gives buffers of " + std::to_string(buffer.length) +
                               " bytes; a picture has " + std::to_string(format_.least));
        void* const memory = system_->mmap(descriptor_, buffer.length, buffer.m.offset);
        if (memory == MAP_FAILED) return trouble(errno);
        buffers_.push_back({memory, buffer.length});
    }
    return {};
}

Result<void> V4l2Stream::queue(std::uint32_t index) {
    v4l2_buffer buffer = blank_buffer(index);
    return ask(VIDIOC_QBUF, &buffer) < 0 ? Result<void>(trouble(errno)) : Result<void>();
}

/// Nothing: none is there, or the driver failed to fill one.
Result<std::optional<v4l2_buffer>> V4l2Stream::dequeue() {
    v4l2_buffer buffer = blank_buffer(0);
    if (ask(VIDIOC_DQBUF, &buffer) == 0) {
        failed_in_a_row_ = 0;
        if (buffer.index < buffers_.size()) return std::optional(buffer);
        return input_error("its driver gave buffer " + std::to_string(buffer.index) + " of " +
                           std::to_string(buffers_.size()));
    }
    const int failure = errno;
    if (failure == EAGAIN) return std::optional<v4l2_buffer>();
    if (failure == EIO && ++failed_in_a_row_ < most_failures_in_a_row) {
        ++damaged_;
        return std::optional<v4l2_buffer>();
    }
    if (failure == ENODEV) return input_error("was unplugged");
    return input_error("stopped (" + std::generic_category().message(failure) + ")");
}

bool V4l2Stream::is_whole(const v4l2_buffer& buffer) const {
    return (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && buffer.bytesused >= format_.least &&
           buffer.bytesused <= buffers_[buffer.index].length;
}

TakenPicture V4l2Stream::copied(const v4l2_buffer& buffer) const {
    const auto* const from = static_cast<const std::uint8_t*>(buffers_[buffer.index].memory);
    auto bytes = std::make_shared<std::vector<std::uint8_t>>();
    if (is_coded(format_.code)) {
        bytes->assign(from, from + buffer.bytesused);
    } else {
        constexpr std::size_t room = 64;  // swscale may read whole vectors past a row's end
        bytes->reserve(format_.least + room);
        bytes->assign(from, from + format_.least);
        bytes->resize(format_.least + room);
    }
    const std::int64_t now = now_ns();
    const auto at_ns = drivers_time(buffer, now);
    return {std::move(bytes), buffer.sequence, at_ns.value_or(now), at_ns.has_value()};
}

Result<std::optional<TakenPicture>> V4l2Stream::take(Which which) {
    std::optional<v4l2_buffer> best;
    // No more than there are buffers: a camera that is faster than this loop does not hold it up.
    for (std::size_t looks = 0; looks < buffers_.size() && (which == Which::newest || !best); ++looks) {
        const auto next = dequeue();
        if (!next && best) break;  // it will say so again
        if (!next) return next.error();
        if (!*next) break;
        const bool whole = is_whole(**next);
        damaged_ += !whole;
        const std::optional<v4l2_buffer> given_back = whole ? std::exchange(best, *next) : *next;
        if (given_back) (void)queue(given_back->index);  // a device that is gone says so at the next look
    }
    if (!best) return std::optional<TakenPicture>();
    TakenPicture picture = copied(*best);
    (void)queue(best->index);
    return std::optional(std::move(picture));
}

}  // namespace touchable
