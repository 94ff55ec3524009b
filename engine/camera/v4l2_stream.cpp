// SPDX-License-Identifier: Apache-2.0
// Nodes of V4L2: which there are, what they offer, and a stream of pictures from one.
#include "engine/camera/v4l2_stream.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <numeric>
#include <system_error>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

class LinuxVideo final : public VideoSystem {
public:
    std::vector<std::string> nodes() override {
        constexpr std::string_view begin = "video";
        std::vector<std::pair<int, std::string>> found;
        std::error_code ignored;
        for (const auto& entry : fs::directory_iterator("/dev", ignored)) {
            const std::string name = entry.path().filename().string();
            const std::string digits = name.substr(std::min(name.size(), begin.size()));
            if (!name.starts_with(begin) || digits.size() > 4 || !is_digits(digits)) continue;
            found.emplace_back(std::stoi(digits), entry.path().string());
        }
        std::sort(found.begin(), found.end());
        std::vector<std::string> nodes;
        for (auto& [number, node] : found) nodes.push_back(std::move(node));
        return nodes;
    }
    int open(const char* node) override { return ::open(node, O_RDWR | O_NONBLOCK | O_CLOEXEC); }
    int close(int descriptor) override { return ::close(descriptor); }
    int ioctl(int descriptor, unsigned long request, void* argument) override {
        return ::ioctl(descriptor, request, argument);
    }
    void* mmap(int descriptor, std::size_t length, std::int64_t offset) override {
        return ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, offset);
    }
    int munmap(void* memory, std::size_t length) override { return ::munmap(memory, length); }
    int poll(std::span<pollfd> descriptors, int timeout_ms) override {
        return ::poll(descriptors.data(), descriptors.size(), timeout_ms);
    }
};

/// The command that lets this user open a node.
std::string permission_words(const std::string& node) {
    struct stat file = {};
    std::string group = "video";
    constexpr unsigned group_may = S_IRGRP | S_IWGRP;
    if (::stat(node.c_str(), &file) == 0) {
        const struct group* entry = file.st_gid == 0 ? nullptr : getgrgid(file.st_gid);
        group = entry != nullptr && (file.st_mode & group_may) == group_may ? entry->gr_name : "";
    }
    if (!group.empty()) return "sudo usermod -aG " + group + " $USER, then log in again";
    return "a udev rule that gives it to who sits at the machine: echo 'SUBSYSTEM==\"video4linux\", "
           "GROUP=\"video\", MODE=\"0660\", TAG+=\"uaccess\"' | sudo tee /etc/udev/rules.d/70-cameras.rules "
           "&& sudo udevadm control --reload && sudo udevadm trigger";
}

/// Why a node cannot be used, with what would help: "/dev/video0: may not be opened: ...". `failure` is the
/// errno.
std::string node_trouble(const std::string& node, int failure) {
    const std::string name = printable(node);
    switch (failure) {
        case ENOENT:
            return name + ": does not exist; touchable cameras lists the cameras that are there";
        case EACCES:
        case EPERM:
            return name + ": may not be opened by this user; use " + permission_words(node);
        case EBUSY: {
            const std::string users = users_of_node(node);
            return name + ": another program has the camera" + (users.empty() ? "" : ": " + users) +
                   "; end that first";
        }
        case ENODEV:
        case ENXIO:
            return name + ": the camera behind it is gone; is it plugged in?";
        case ENOSPC:
            return name +
                   ": the USB bus has no room for a stream of this size and rate; smaller ones (size=WxH, "
                   "fps=N), another port or another cable would do";
        case EINVAL:
        case ENOTTY:
            return name + ": is no camera's node; touchable cameras lists those that are";
        default:
            return name + ": cannot be used: " + failure_words(failure);
    }
}

// Limit for drivers whose lists never end.
constexpr std::uint32_t most_entries = 256;
constexpr std::uint32_t largest_side = 16384;
constexpr double usual_rate = 30;
constexpr std::int64_t usual_pixels = 1280 * 720;

constexpr std::array depth_formats{V4L2_PIX_FMT_Z16, V4L2_PIX_FMT_Y16, V4L2_PIX_FMT_Y16_BE};
constexpr std::array colour_formats{V4L2_PIX_FMT_RGB24, V4L2_PIX_FMT_BGR24, V4L2_PIX_FMT_YUYV,
                                    V4L2_PIX_FMT_UYVY,  V4L2_PIX_FMT_NV12,  V4L2_PIX_FMT_MJPEG,
                                    V4L2_PIX_FMT_JPEG};

/// Drivers end their texts with a 0, as a rule.
template <std::size_t n>
std::string text_of(const std::uint8_t (&bytes)[n]) {
    const auto* const text = reinterpret_cast<const char*>(bytes);
    return {text, ::strnlen(text, n)};
}

/// The rate of an interval in seconds; nullopt if that is invalid, or no camera has it.
std::optional<FrameRate> rate_of_interval(std::uint32_t numerator, std::uint32_t denominator) {
    if (numerator == 0 || denominator == 0) return std::nullopt;
    const std::int64_t common = std::gcd(std::int64_t{numerator}, std::int64_t{denominator});
    const FrameRate rate{denominator / common, numerator / common};
    constexpr std::int64_t most_term = 1'000'000'000;
    const bool can_be = rate.per_second() >= 0.01 && rate.per_second() <= 1000 && rate.num <= most_term &&
                        rate.den <= most_term;
    return can_be ? std::optional(rate) : std::nullopt;
}

std::vector<FrameRate> rates_of(VideoSystem& system, int descriptor, std::uint32_t code, int width,
                                int height) {
    std::vector<FrameRate> rates;
    for (std::uint32_t index = 0; index < most_entries; ++index) {
        v4l2_frmivalenum entry = {};
        entry.index = index;
        entry.pixel_format = code;
        entry.width = static_cast<std::uint32_t>(width);
        entry.height = static_cast<std::uint32_t>(height);
        if (call(system, descriptor, VIDIOC_ENUM_FRAMEINTERVALS, &entry) < 0) break;
        const bool one = entry.type == V4L2_FRMIVAL_TYPE_DISCRETE;
        const v4l2_fract& interval = one ? entry.discrete : entry.stepwise.min;
        if (const auto rate = rate_of_interval(interval.numerator, interval.denominator))
            rates.push_back(*rate);
        if (one) continue;
        const v4l2_fract& slowest = entry.stepwise.max;
        // All rates between: take the usual ones.
        for (const std::int64_t usual : {60, 30, 15})
            if (const auto least = rate_of_interval(slowest.numerator, slowest.denominator);
                least && !rates.empty() && static_cast<double>(usual) < rates.front().per_second() &&
                static_cast<double>(usual) > least->per_second())
                rates.push_back({usual, 1});
        break;
    }
    std::ranges::stable_sort(rates, std::greater<>{}, &FrameRate::per_second);
    return rates;
}

void add_mode(VideoSystem& system, int descriptor, NodeFormat& format, std::uint32_t width,
              std::uint32_t height) {
    if (width == 0 || height == 0 || width > largest_side || height > largest_side) return;
    const int w = static_cast<int>(width), h = static_cast<int>(height);
    const auto is_same = [&](const NodeMode& mode) { return mode.width == w && mode.height == h; };
    if (std::ranges::any_of(format.modes, is_same)) return;
    format.modes.push_back({w, h, rates_of(system, descriptor, format.code, w, h)});
}

void find_modes(VideoSystem& system, int descriptor, NodeFormat& format) {
    for (std::uint32_t index = 0; index < most_entries; ++index) {
        v4l2_frmsizeenum entry = {};
        entry.index = index;
        entry.pixel_format = format.code;
        if (call(system, descriptor, VIDIOC_ENUM_FRAMESIZES, &entry) < 0) break;
        if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
            add_mode(system, descriptor, format, entry.discrete.width, entry.discrete.height);
            continue;
        }
        format.any_size = true;
        add_mode(system, descriptor, format, entry.stepwise.min_width, entry.stepwise.min_height);
        if (entry.stepwise.min_width <= 640 && entry.stepwise.max_width >= 640 &&
            entry.stepwise.min_height <= 480 && entry.stepwise.max_height >= 480)
            add_mode(system, descriptor, format, 640, 480);
        add_mode(system, descriptor, format, entry.stepwise.max_width, entry.stepwise.max_height);
        break;
    }
}

/// The facts of an open device.
Result<NodeFacts> facts_of_node(VideoSystem& system, int descriptor, const std::string& node) {
    v4l2_capability can = {};
    if (call(system, descriptor, VIDIOC_QUERYCAP, &can) < 0) return input_error(node_trouble(node, errno));
    NodeFacts facts{node, text_of(can.driver), text_of(can.card), text_of(can.bus_info)};
    const bool of_node = (can.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
    const std::uint32_t able = of_node ? can.device_caps : can.capabilities;
    facts.captures = (able & V4L2_CAP_VIDEO_CAPTURE) != 0 && (able & V4L2_CAP_STREAMING) != 0;
    if (!facts.captures) return facts;
    for (std::uint32_t index = 0; index < most_entries; ++index) {
        v4l2_fmtdesc entry = {};
        entry.index = index;
        entry.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        if (call(system, descriptor, VIDIOC_ENUM_FMT, &entry) < 0) break;
        NodeFormat format{entry.pixelformat};
        find_modes(system, descriptor, format);
        facts.formats.push_back(std::move(format));
    }
    return facts;
}

/// The rate nearest to what is wanted; nullopt if the camera states none.
std::optional<FrameRate> nearest_rate(const NodeMode& mode, double wanted) {
    const auto nearest = std::ranges::min_element(
        mode.rates, {}, [wanted](const FrameRate& rate) { return std::abs(rate.per_second() - wanted); });
    return nearest == mode.rates.end() ? std::nullopt : std::optional(*nearest);
}

/// Rank of a mode if no size is wanted: first those at the usual rate, then the largest that is not too
/// large.
std::pair<bool, std::int64_t> usual_mark(const NodeMode& mode, double wanted) {
    const auto rate = nearest_rate(mode, wanted);
    const bool fast = !rate || rate->per_second() > 0.9 * wanted;
    const std::int64_t pixels = std::int64_t{mode.width} * mode.height;
    return {fast, pixels <= usual_pixels ? pixels : -pixels};
}

Result<NodeMode> choose_size(const NodeFormat& format, const ModeWish& wish) {
    if (wish.width == 0) {
        const double wanted = wish.rate.value_or(usual_rate);
        return *std::ranges::max_element(format.modes, {},
                                         [wanted](const NodeMode& mode) { return usual_mark(mode, wanted); });
    }
    for (const NodeMode& mode : format.modes)
        if (mode.width == wish.width && mode.height == wish.height) return mode;
    if (format.any_size) return NodeMode{wish.width, wish.height, format.modes.front().rates};
    return usage_error("offers no " + format_text(format.code) + " of " + size_text(wish.width, wish.height) +
                       " (size=); there are " + listed(format.modes, [](const NodeMode& mode) {
                           return size_text(mode.width, mode.height);
                       }));
}

// Enough for the driver to fill one while others wait, few enough that none is old.
constexpr std::uint32_t wanted_buffers = 4, most_buffers = 32;

constexpr bool is_coded(std::uint32_t code) {
    return code == V4L2_PIX_FMT_MJPEG || code == V4L2_PIX_FMT_JPEG;
}

/// Bytes of a pixel in the first plane.
constexpr std::ptrdiff_t bytes_per_pixel(std::uint32_t code) {
    if (code == V4L2_PIX_FMT_RGB24 || code == V4L2_PIX_FMT_BGR24) return 3;
    return code == V4L2_PIX_FMT_NV12 ? 1 : 2;
}

/// Bytes of a picture, without padding after the last row.
std::size_t picture_bytes(const StreamFormat& format) {
    if (is_coded(format.code)) return 1;
    const bool has_chroma_below = format.code == V4L2_PIX_FMT_NV12;
    const std::ptrdiff_t rows = has_chroma_below ? format.height + (format.height + 1) / 2 : format.height;
    return static_cast<std::size_t>(format.stride * (rows - 1) + bytes_per_pixel(format.code) * format.width);
}

/// The driver's time of a picture, if its clock is the machine's and the time is plausible.
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

std::shared_ptr<VideoSystem> system_video() {
    return std::make_shared<LinuxVideo>();
}

int call(VideoSystem& system, int descriptor, unsigned long request, void* argument) {
    while (true) {
        const int result = system.ioctl(descriptor, request, argument);
        if (result >= 0 || errno != EINTR) return result;
    }
}

std::string users_of_node(const std::string& node) {
    struct stat device = {};
    if (::stat(node.c_str(), &device) != 0 || !S_ISCHR(device.st_mode)) return {};
    std::string users;
    std::error_code ignored;
    for (const auto& process : fs::directory_iterator("/proc", ignored)) {
        const std::string number = process.path().filename().string();
        if (!is_digits(number)) continue;
        std::error_code hidden;
        for (const auto& file : fs::directory_iterator(process.path() / "fd", hidden)) {
            struct stat open = {};
            if (::stat(file.path().c_str(), &open) != 0 || !S_ISCHR(open.st_mode) ||
                open.st_rdev != device.st_rdev)
                continue;
            std::string name;
            std::ifstream comm(process.path() / "comm");
            std::getline(comm, name);
            users += (users.empty() ? "" : ", ") + printable(name) + " (process " + number + ")";
            break;
        }
    }
    return users;
}

bool is_depth_format(std::uint32_t code) {
    return std::ranges::find(depth_formats, code) != depth_formats.end();
}

Result<const NodeFormat*> depth_of_node(const NodeFacts& facts) {
    const NodeFormat* best = nullptr;
    for (const NodeFormat& format : facts.formats) {
        if (!is_depth_format(format.code)) continue;
        if (best == nullptr || (format.code == V4L2_PIX_FMT_Z16 && best->code != V4L2_PIX_FMT_Z16))
            best = &format;
    }
    if (best != nullptr) return best;
    return input_error(facts.node + ": " + printable(facts.card) +
                       (facts.captures ? " gives no depth there (" + formats_text(facts) +
                                             "); what can be touched is Z16 or Y16"
                                       : std::string(" gives no pictures there")) +
                       "; touchable cameras lists the nodes that have depth");
}

bool is_colour_format(std::uint32_t code) {
    return std::ranges::find(colour_formats, code) != colour_formats.end();
}

std::string format_text(std::uint32_t code) {
    constexpr std::uint32_t big_endian = 1U << 31;
    std::string text;
    for (int k = 0; k < 4; ++k) text += static_cast<char>((code & ~big_endian) >> (8 * k) & 0xff);
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return printable(text) + ((code & big_endian) != 0 ? " (big-endian)" : "");
}

std::string formats_text(const NodeFacts& facts) {
    const std::string all =
        listed(facts.formats, [](const NodeFormat& format) { return format_text(format.code); });
    return all.empty() ? "nothing" : all;
}

std::string rate_text(const FrameRate& rate) {
    return formatted("%.4g", rate.per_second());
}

Result<NodeMode> choose_mode(const NodeFormat& format, const ModeWish& wish) {
    if (format.modes.empty()) return NodeMode{wish.width, wish.height, {}};
    TRY_ASSIGN(auto mode, choose_size(format, wish));
    const auto rate = nearest_rate(mode, wish.rate.value_or(usual_rate));
    mode.rates = rate ? std::vector{*rate} : std::vector<FrameRate>();
    return mode;
}

std::string mode_text(const NodeMode& mode) {
    const std::string rates = listed(mode.rates, rate_text);
    return size_text(mode.width, mode.height) + (rates.empty() ? "" : " at " + rates + " frames/s");
}

Result<NodeFacts> look_at_node(VideoSystem& system, const std::string& node) {
    const int descriptor = system.open(node.c_str());
    if (descriptor < 0) return input_error(node_trouble(node, errno));
    auto facts = facts_of_node(system, descriptor, node);
    system.close(descriptor);
    return facts;
}

Error V4l2Stream::trouble(int failure) const {
    return input_error(node_trouble(node_, failure));
}

Result<std::unique_ptr<V4l2Stream>> V4l2Stream::open(std::shared_ptr<VideoSystem> system,
                                                     const NodeFacts& facts, const NodeFormat& format,
                                                     const ModeWish& wish) {
    TRY_ASSIGN(const auto mode, error_at(facts.node, choose_mode(format, wish)));
    std::unique_ptr<V4l2Stream> stream(new V4l2Stream(std::move(system), facts.node));
    stream->descriptor_ = stream->system_->open(facts.node.c_str());
    if (stream->descriptor_ < 0) return stream->trouble(errno);
    TRY(stream->begin(format.code, mode));
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
    TRY(set_format(code, mode));
    set_rate(mode);
    TRY(map_buffers());
    for (std::uint32_t index = 0; index < buffers_.size(); ++index) TRY(queue(index));
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ask(VIDIOC_STREAMON, &type) < 0) return trouble(errno);
    streams_ = true;
    return {};
}

/// The driver may choose another form: another size is accepted if none was wanted.
Result<void> V4l2Stream::set_format(std::uint32_t code, const NodeMode& mode) {
    v4l2_format wish = {};
    wish.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ask(VIDIOC_G_FMT, &wish) < 0) return trouble(errno);
    v4l2_pix_format& pixels = wish.fmt.pix;
    pixels.pixelformat = code;
    pixels.field = V4L2_FIELD_NONE;
    pixels.bytesperline = pixels.sizeimage = 0;  // as the driver chooses
    if (mode.width > 0) {
        pixels.width = static_cast<std::uint32_t>(mode.width);
        pixels.height = static_cast<std::uint32_t>(mode.height);
    }
    if (ask(VIDIOC_S_FMT, &wish) < 0) return trouble(errno);
    const std::string settled =
        format_text(pixels.pixelformat) + " of " + size_text(pixels.width, pixels.height);
    const bool other_size = mode.width > 0 && (pixels.width != static_cast<std::uint32_t>(mode.width) ||
                                               pixels.height != static_cast<std::uint32_t>(mode.height));
    if (pixels.pixelformat != code || other_size)
        return input_error(node_ + ": its driver gives " + settled + " where " + format_text(code) +
                           (mode.width > 0 ? " of " + size_text(mode.width, mode.height) : "") +
                           " was asked for; touchable cameras lists what it offers");
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

/// Sets the rate if the driver can; a driver without rates reports none.
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

/// Nullopt: no buffer is ready, or the driver failed to fill one.
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
    if (failure == EIO && ++failed_in_a_row_ < most_faults_in_a_row) {
        ++damaged_;
        return std::optional<v4l2_buffer>();
    }
    if (failure == ENODEV) return input_error("was unplugged");
    return input_error("stopped (" + failure_words(failure) + ")");
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
    const std::int64_t now = steady_now_ns();
    const auto at_ns = drivers_time(buffer, now);
    return {std::move(bytes), buffer.sequence, at_ns.value_or(now), at_ns.has_value()};
}

Result<std::optional<TakenPicture>> V4l2Stream::take(Which which) {
    std::optional<v4l2_buffer> best;
    // At most as many as there are buffers: a camera that is faster than this loop cannot keep it busy.
    for (std::size_t looks = 0; looks < buffers_.size() && (which == Which::newest || !best); ++looks) {
        const auto next = dequeue();
        if (!next && best) break;  // the error comes again
        TRY(next);
        if (!*next) break;
        const bool whole = is_whole(**next);
        damaged_ += !whole;
        const std::optional<v4l2_buffer> given_back = whole ? std::exchange(best, *next) : *next;
        if (given_back) (void)queue(given_back->index);  // a lost device is reported next time
    }
    if (!best) return std::optional<TakenPicture>();
    TakenPicture picture = copied(*best);
    (void)queue(best->index);
    return std::optional(std::move(picture));
}

}  // namespace touchable
