// SPDX-License-Identifier: Apache-2.0
#include "tests/camera/fake_video.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <thread>

#include "engine/clip/readers.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t page = 1 << 20;  // from one buffer's offset to the next's

std::uint32_t row_bytes_of(std::uint32_t code, std::uint32_t width) {
    if (code == V4L2_PIX_FMT_MJPEG) return 0;
    if (code == V4L2_PIX_FMT_RGB24 || code == V4L2_PIX_FMT_BGR24) return 3 * width;
    return code == V4L2_PIX_FMT_NV12 ? width : 2 * width;
}

std::uint32_t rows_of(std::uint32_t code, std::uint32_t height) {
    return code == V4L2_PIX_FMT_NV12 ? height * 3 / 2 : height;
}

template <std::size_t n>
void put_text(std::uint8_t (&to)[n], const std::string& text) {
    std::memcpy(to, text.c_str(), std::min(n, text.size() + 1));
}

}  // namespace

FakeVideo::~FakeVideo() = default;

FakeNode& FakeVideo::add(const std::string& node) {
    auto& device = devices_[node] = std::make_unique<Device>();
    return device->wants;
}

std::vector<std::string> FakeVideo::misuse() const {
    const std::lock_guard lock(mutex_);
    return misuse_;
}

std::vector<std::string> FakeVideo::left_over() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> left;
    for (const auto& [descriptor, node] : open_) left.push_back(node + " is open");
    for (const auto& [node, device] : devices_) {
        if (device->streams) left.push_back(node + " streams");
        for (const auto& buffer : device->buffers)
            if (buffer->mapped) left.push_back(node + " has a buffer that is mapped");
    }
    return left;
}

int FakeVideo::fail(int failure) {
    errno = failure;
    return -1;
}

int FakeVideo::misused(const std::string& what, int failure) {
    misuse_.push_back(what);
    return fail(failure);
}

FakeVideo::Device* FakeVideo::device_of(int descriptor) {
    const auto found = open_.find(descriptor);
    return found == open_.end() ? nullptr : devices_.at(found->second).get();
}

std::vector<std::string> FakeVideo::nodes() {
    std::vector<std::string> all;
    for (const auto& [node, device] : devices_) all.push_back(node);
    return all;
}

int FakeVideo::open(const char* node) {
    const std::lock_guard lock(mutex_);
    const auto found = devices_.find(node);
    if (found == devices_.end()) return fail(ENOENT);
    Device& device = *found->second;
    if (const auto refused = device.wants.refusals.find(0); refused != device.wants.refusals.end())
        return fail(refused->second);
    if (device.gone) return fail(ENODEV);
    open_[next_descriptor_] = node;
    return next_descriptor_++;
}

int FakeVideo::close(int descriptor) {
    const std::lock_guard lock(mutex_);
    Device* device = device_of(descriptor);
    if (device == nullptr) return misused("close of what is not open", EBADF);
    if (device->owner == descriptor) {
        if (device->streams) misuse_.emplace_back("closed while it streams");
        for (const auto& buffer : device->buffers)
            if (buffer->mapped) misuse_.emplace_back("closed while a buffer is mapped");
        device->owner = -1;
        device->buffers.clear();
        device->waiting.clear();
        device->done.clear();
    }
    open_.erase(descriptor);
    return 0;
}

void* FakeVideo::mmap(int descriptor, std::size_t length, std::int64_t offset) {
    const std::lock_guard lock(mutex_);
    Device* device = device_of(descriptor);
    const auto index = static_cast<std::size_t>(offset / page);
    if (device == nullptr || device->owner != descriptor || offset % page != 0 ||
        index >= device->buffers.size() || device->buffers[index]->memory.size() != length ||
        device->buffers[index]->mapped) {
        misused("mmap of what is no buffer", EINVAL);
        return MAP_FAILED;
    }
    device->buffers[index]->mapped = true;
    return device->buffers[index]->memory.data();
}

int FakeVideo::munmap(void* memory, std::size_t length) {
    const std::lock_guard lock(mutex_);
    for (const auto& [node, device] : devices_)
        for (const auto& buffer : device->buffers)
            if (buffer->memory.data() == memory && buffer->memory.size() == length && buffer->mapped) {
                buffer->mapped = false;
                if (device->streams) misuse_.emplace_back("unmapped while it streams");
                return 0;
            }
    return misused("munmap of what is not mapped", EINVAL);
}

int FakeVideo::ioctl(int descriptor, unsigned long request, void* argument) {
    const std::lock_guard lock(mutex_);
    if (is_broken_off()) return fail(EINTR);
    Device* device = device_of(descriptor);
    if (device == nullptr) return misused("ioctl of what is not open", EBADF);
    if (device->gone && request != VIDIOC_STREAMOFF) return fail(ENODEV);
    if (const auto refused = device->wants.refusals.find(request); refused != device->wants.refusals.end())
        return fail(refused->second);
    return answer(*device, descriptor, request, argument);
}

int FakeVideo::answer(Device& device, int descriptor, unsigned long request, void* argument) {
    const bool of_owner = device.owner == descriptor;
    switch (request) {
        case VIDIOC_QUERYCAP: {
            auto& can = *static_cast<v4l2_capability*>(argument);
            can = {};
            put_text(can.driver, "fake");
            put_text(can.card, device.wants.card);
            put_text(can.bus_info, device.wants.bus);
            can.device_caps = device.wants.capabilities;
            // Of all nodes of the camera together: a trap for who asks the wrong one.
            can.capabilities = device.wants.capabilities | V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE |
                               V4L2_CAP_META_CAPTURE;
            return 0;
        }
        case VIDIOC_G_FMT:
            static_cast<v4l2_format*>(argument)->fmt.pix = device.format;
            return 0;
        case VIDIOC_S_FMT:
            return set_format(device, descriptor, *static_cast<v4l2_format*>(argument));
        case VIDIOC_G_PARM:
        case VIDIOC_S_PARM: {
            auto& capture = static_cast<v4l2_streamparm*>(argument)->parm.capture;
            if (request == VIDIOC_S_PARM) device.interval = capture.timeperframe;
            capture.capability = V4L2_CAP_TIMEPERFRAME;
            capture.timeperframe = device.interval;
            return 0;
        }
        case VIDIOC_REQBUFS:
            return request_buffers(device, descriptor, *static_cast<v4l2_requestbuffers*>(argument));
        case VIDIOC_QUERYBUF: {
            auto& buffer = *static_cast<v4l2_buffer*>(argument);
            if (!of_owner || buffer.index >= device.buffers.size())
                return misused("QUERYBUF of no buffer", EINVAL);
            buffer.length = static_cast<std::uint32_t>(device.buffers[buffer.index]->memory.size());
            buffer.m.offset = static_cast<std::uint32_t>(buffer.index * page);
            return 0;
        }
        case VIDIOC_QBUF:
        case VIDIOC_DQBUF: {
            auto& buffer = *static_cast<v4l2_buffer*>(argument);
            if (!of_owner || buffer.type != V4L2_BUF_TYPE_VIDEO_CAPTURE || buffer.memory != V4L2_MEMORY_MMAP)
                return misused("a buffer of another kind, or of another owner", EINVAL);
            return request == VIDIOC_QBUF ? queue(device, buffer) : dequeue(device, buffer);
        }
        case VIDIOC_STREAMON:
            if (!of_owner || *static_cast<int*>(argument) != V4L2_BUF_TYPE_VIDEO_CAPTURE)
                return misused("STREAMON without buffers", EINVAL);
            if (device.waiting.size() != device.buffers.size())
                misuse_.emplace_back("STREAMON with buffers that are not queued");
            device.streams = true;
            device.next = 0;
            device.begun_ns = steady_now_ns();
            return 0;
        case VIDIOC_STREAMOFF:
            if (!of_owner || !device.streams) return misused("STREAMOFF of what does not stream", EINVAL);
            device.streams = false;
            return 0;
        default:
            return enumerate(device, request, argument);
    }
}

int FakeVideo::enumerate(Device& device, unsigned long request, void* argument) {
    const auto format_of = [&](std::uint32_t code) -> const FakeFormat* {
        for (const FakeFormat& format : device.wants.formats)
            if (format.code == code) return &format;
        return nullptr;
    };
    if (request == VIDIOC_ENUM_FMT) {
        auto& entry = *static_cast<v4l2_fmtdesc*>(argument);
        if (entry.index >= device.wants.formats.size()) return fail(EINVAL);
        entry.pixelformat = device.wants.formats[entry.index].code;
        put_text(entry.description, "Pictures");
        return 0;
    }
    if (request == VIDIOC_ENUM_FRAMESIZES) {
        auto& entry = *static_cast<v4l2_frmsizeenum*>(argument);
        const FakeFormat* format = format_of(entry.pixel_format);
        if (format == nullptr || entry.index >= format->modes.size()) return fail(EINVAL);
        if (format->stepwise) {
            const FakeMode &least = format->modes.front(), &most = format->modes.back();
            entry.type = V4L2_FRMSIZE_TYPE_STEPWISE;
            entry.stepwise = {least.width, most.width, 1, least.height, most.height, 1};
            return 0;
        }
        entry.type = V4L2_FRMSIZE_TYPE_DISCRETE;
        entry.discrete = {format->modes[entry.index].width, format->modes[entry.index].height};
        return 0;
    }
    if (request == VIDIOC_ENUM_FRAMEINTERVALS) {
        auto& entry = *static_cast<v4l2_frmivalenum*>(argument);
        const FakeFormat* format = format_of(entry.pixel_format);
        if (format == nullptr) return fail(EINVAL);
        for (const FakeMode& mode : format->modes) {
            if (!format->stepwise && (mode.width != entry.width || mode.height != entry.height)) continue;
            if (entry.index >= mode.intervals.size()) return fail(EINVAL);
            entry.type = V4L2_FRMIVAL_TYPE_DISCRETE;
            entry.discrete = {mode.intervals[entry.index].first, mode.intervals[entry.index].second};
            return 0;
        }
        return fail(EINVAL);
    }
    return fail(ENOTTY);
}

int FakeVideo::set_format(Device& device, int descriptor, v4l2_format& format) {
    if (device.owner != -1)
        return device.owner == descriptor ? misused("S_FMT with buffers", EBUSY) : fail(EBUSY);
    v4l2_pix_format& pixels = format.fmt.pix;
    const auto& formats = device.wants.formats;
    if (std::none_of(formats.begin(), formats.end(),
                     [&](const FakeFormat& each) { return each.code == pixels.pixelformat; }))
        pixels.pixelformat = formats.front().code;
    if (device.wants.settles_for) {
        pixels.width = device.wants.settles_for->width;
        pixels.height = device.wants.settles_for->height;
    }
    pixels.bytesperline = row_bytes_of(pixels.pixelformat, pixels.width);
    if (pixels.bytesperline > 0) pixels.bytesperline += device.wants.row_padding;
    pixels.sizeimage = pixels.bytesperline * rows_of(pixels.pixelformat, pixels.height);
    if (pixels.pixelformat == V4L2_PIX_FMT_MJPEG) pixels.sizeimage = 2 * pixels.width * pixels.height + 4096;
    device.format = pixels;
    return 0;
}

int FakeVideo::request_buffers(Device& device, int descriptor, v4l2_requestbuffers& request) {
    if (device.owner != -1) return fail(EBUSY);
    if (request.memory != V4L2_MEMORY_MMAP) return fail(EINVAL);
    if (device.wants.buffers > 0) request.count = device.wants.buffers;
    const std::size_t bytes =
        device.wants.buffer_bytes > 0 ? device.wants.buffer_bytes : device.format.sizeimage;
    for (std::uint32_t k = 0; k < request.count; ++k) {
        device.buffers.push_back(std::make_unique<Buffer>());
        device.buffers.back()->memory.resize(bytes);
    }
    device.owner = descriptor;
    return 0;
}

int FakeVideo::queue(Device& device, v4l2_buffer& buffer) {
    if (buffer.index >= device.buffers.size()) return misused("QBUF of no buffer", EINVAL);
    Buffer& given = *device.buffers[buffer.index];
    if (given.queued) return misused("QBUF of a buffer that the driver has", EINVAL);
    given.queued = true;
    std::fill(given.memory.begin(), given.memory.end(), std::uint8_t{0xee});
    device.waiting.push_back(buffer.index);
    return 0;
}

int FakeVideo::dequeue(Device& device, v4l2_buffer& buffer) {
    if (!device.streams) return misused("DQBUF of what does not stream", EINVAL);
    catch_up(device);
    if (device.gone) return fail(ENODEV);
    if (device.io_errors > 0) {
        --device.io_errors;
        return fail(EIO);
    }
    if (device.done.empty()) return fail(EAGAIN);
    Buffer& given = *device.buffers[device.done.front()];
    device.done.erase(device.done.begin());
    given.queued = false;
    buffer = given.done;
    return 0;
}

void FakeVideo::take_one(Device& device) {
    const std::uint32_t number = device.next;
    const Fate fate = device.wants.fate(number);
    if (fate == Fate::stalled) return;
    if (fate == Fate::unplugged) device.gone = true;
    if (fate == Fate::nameless_error) device.nameless = true;
    if (device.gone || device.nameless) return;
    ++device.next;
    if (fate == Fate::io_error) ++device.io_errors;
    if (fate == Fate::lost || fate == Fate::io_error || device.waiting.empty()) return;
    const std::uint32_t index = device.waiting.front();
    device.waiting.erase(device.waiting.begin());
    device.done.push_back(index);
    Buffer& buffer = *device.buffers[index];
    std::uint32_t used = device.format.sizeimage;
    if (device.wants.paint) {
        const std::vector<std::uint8_t> picture = device.wants.paint(number);
        const std::uint32_t row = row_bytes_of(device.format.pixelformat, device.format.width);
        if (row == 0) {
            std::memcpy(buffer.memory.data(), picture.data(), picture.size());
            used = static_cast<std::uint32_t>(picture.size());
        }
        for (std::uint32_t y = 0; row > 0 && y < rows_of(device.format.pixelformat, device.format.height);
             ++y)
            std::memcpy(buffer.memory.data() + y * device.format.bytesperline, picture.data() + y * row, row);
    }
    buffer.done = {};
    buffer.done.index = index;
    buffer.done.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.done.memory = V4L2_MEMORY_MMAP;
    buffer.done.length = static_cast<std::uint32_t>(buffer.memory.size());
    buffer.done.bytesused = fate == Fate::cut ? used - device.format.width - device.wants.row_padding : used;
    buffer.done.flags = device.wants.timestamps | (fate == Fate::damaged ? V4L2_BUF_FLAG_ERROR : 0U);
    buffer.done.sequence = device.wants.sequence(number);
    const std::int64_t at_ns = device.wants.stamp ? device.wants.stamp(number) : steady_now_ns();
    buffer.done.timestamp.tv_sec = at_ns / 1'000'000'000;
    buffer.done.timestamp.tv_usec = at_ns % 1'000'000'000 / 1000;
}

/// Those that are due by the clock.
void FakeVideo::catch_up(Device& device) {
    if (!device.streams || device.wants.period_ns == 0) return;
    const std::int64_t due = (steady_now_ns() - device.begun_ns) / device.wants.period_ns;
    for (std::uint32_t before = device.next + 1; device.next < due && device.next != before;) {
        before = device.next;
        take_one(device);
        if (device.gone || device.nameless) return;
    }
}

/// Or none will ever be.
void FakeVideo::take_until_one_is_there(Device& device) {
    std::uint32_t before = device.next + 1;
    while (device.streams && device.done.empty() && device.io_errors == 0 && device.next != before) {
        before = device.next;
        take_one(device);
    }
}

short FakeVideo::state_of(Device& device) {
    catch_up(device);
    if (device.gone || device.io_errors > 0) return POLLERR;
    if (device.nameless) return POLLERR;
    if (!device.streams) return POLLERR;
    return device.done.empty() ? short{0} : short{POLLIN | POLLRDNORM};
}

int FakeVideo::poll(std::span<pollfd> descriptors, int timeout_ms) {
    const std::int64_t until = steady_now_ns() + std::int64_t{timeout_ms} * 1'000'000;
    {
        const std::lock_guard lock(mutex_);
        if (is_broken_off()) return fail(EINTR);
    }
    for (bool again = false;; again = true) {
        int ready = 0;
        {
            const std::lock_guard lock(mutex_);
            for (pollfd& waited : descriptors) {
                waited.revents = 0;
                Device* device = device_of(waited.fd);
                if (device == nullptr) continue;
                if (!again && device->wants.period_ns == 0) take_until_one_is_there(*device);
                waited.revents = state_of(*device);
                ready += waited.revents != 0;
            }
        }
        if (ready > 0 || steady_now_ns() >= until) return ready;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

void FakeVideo::take(const std::string& node, int pictures) {
    const std::lock_guard lock(mutex_);
    for (int k = 0; k < pictures; ++k) take_one(*devices_.at(node));
}

void FakeVideo::unplug(const std::string& node) {
    const std::lock_guard lock(mutex_);
    devices_.at(node)->gone = true;
}

std::uint16_t painted_depth(int x, int y, std::uint32_t number) {
    return static_cast<std::uint16_t>((static_cast<std::uint32_t>(x + 3 * y) + 7 * number) % 2000 + 500);
}

std::function<std::vector<std::uint8_t>(std::uint32_t)> depth_painter(int width, int height,
                                                                      bool big_endian) {
    return [=](std::uint32_t number) {
        std::vector<std::uint8_t> bytes;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint16_t depth = painted_depth(x, y, number);
                const auto low = static_cast<std::uint8_t>(depth & 0xff),
                           high = static_cast<std::uint8_t>(depth >> 8);
                bytes.push_back(big_endian ? high : low);
                bytes.push_back(big_endian ? low : high);
            }
        return bytes;
    };
}

FakeNode& add_depth_node(FakeVideo& video, const std::string& node, int width, int height,
                         std::uint32_t code) {
    FakeNode& made = video.add(node);
    made.formats = {{code, {{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)}}}};
    made.paint = depth_painter(width, height, code == V4L2_PIX_FMT_Y16_BE);
    return made;
}

}  // namespace touchable::test
