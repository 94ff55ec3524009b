// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/camera/v4l2_stream.hpp"

namespace touchable::test {

/// The fate of a picture that a fake camera takes.
enum class Fate { good, lost, damaged, cut, io_error, unplugged, stalled, nameless_error };

struct FakeMode {
    std::uint32_t width = 0, height = 0;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> intervals{{1, 30}};  ///< seconds
};
struct FakeFormat {
    std::uint32_t code = 0;
    std::vector<FakeMode> modes;
    bool stepwise = false;  ///< these are the least and the greatest of all its sizes
};

/// A node as a test wants it. Pictures are delivered one at every poll that finds none, or by the clock.
struct FakeNode {
    std::string card = "A camera", bus = "usb-1";
    std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    std::vector<FakeFormat> formats;
    std::map<unsigned long, int> refusals;  ///< of a request, with this errno; 0: of `open`
    std::uint32_t row_padding = 0;          ///< bytes behind each row
    std::uint32_t buffers = 0;              ///< that it gives, 0: as asked
    std::uint32_t buffer_bytes = 0;         ///< 0: as large as a picture
    std::optional<FakeMode> settles_for;    ///< at any size that is asked for
    std::uint32_t timestamps = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    std::int64_t period_ns = 0;  ///< by the clock; 0: at every poll
    std::function<Fate(std::uint32_t)> fate = [](std::uint32_t) { return Fate::good; };
    /// The driver's count of a picture.
    std::function<std::uint32_t(std::uint32_t)> sequence = [](std::uint32_t number) { return number; };
    /// Row by row without padding; by default all zero.
    std::function<std::vector<std::uint8_t>(std::uint32_t)> paint;
    /// Of steady_clock, ns; by default now.
    std::function<std::int64_t(std::uint32_t)> stamp;
};

/// Stands in for the kernel: it keeps to what V4L2's documentation says of drivers, and notes what a program
/// does that it may not. Memory of a buffer that the driver has is scribbled over.
class FakeVideo final : public VideoSystem {
public:
    ~FakeVideo() override;
    FakeNode& add(const std::string& node);
    /// As pictures that come with no poll in between.
    void take(const std::string& node, int pictures);
    void unplug(const std::string& node);
    /// Every third call is broken off by a signal.
    void set_signals(bool on) { signals_ = on; }
    /// Calls of the program that V4L2 forbids; and nodes, buffers and streams that it left open.
    std::vector<std::string> misuse() const;
    std::vector<std::string> left_over() const;

    std::vector<std::string> nodes() override;
    int open(const char* node) override;
    int close(int descriptor) override;
    int ioctl(int descriptor, unsigned long request, void* argument) override;
    void* mmap(int descriptor, std::size_t length, std::int64_t offset) override;
    int munmap(void* memory, std::size_t length) override;
    int poll(std::span<pollfd> descriptors, int timeout_ms) override;

private:
    struct Buffer {
        std::vector<std::uint8_t> memory;
        bool mapped = false, queued = false;
        v4l2_buffer done = {};
    };
    struct Device {
        FakeNode wants;
        v4l2_pix_format format = {};
        v4l2_fract interval{1, 30};
        int owner = -1;  // the descriptor that has buffers
        std::vector<std::unique_ptr<Buffer>> buffers;
        std::vector<std::uint32_t> waiting, done;  // buffers, in their order
        bool streams = false, gone = false, nameless = false;
        int io_errors = 0;
        std::uint32_t next = 0;  // picture
        std::int64_t begun_ns = 0;
    };
    Device* device_of(int descriptor);
    int fail(int failure);
    bool is_broken_off() { return signals_ && ++calls_ % 3 == 0; }
    int misused(const std::string& what, int failure);
    int answer(Device& device, int descriptor, unsigned long request, void* argument);
    int enumerate(Device& device, unsigned long request, void* argument);
    int set_format(Device& device, int descriptor, v4l2_format& format);
    int request_buffers(Device& device, int descriptor, v4l2_requestbuffers& request);
    int queue(Device& device, v4l2_buffer& buffer);
    int dequeue(Device& device, v4l2_buffer& buffer);
    void take_one(Device& device);
    void take_until_one_is_there(Device& device);
    void catch_up(Device& device);
    short state_of(Device& device);

    mutable std::mutex mutex_;
    std::map<std::string, std::unique_ptr<Device>> devices_;
    std::map<int, std::string> open_;
    int next_descriptor_ = 100'000;
    bool signals_ = false;
    int calls_ = 0;
    std::vector<std::string> misuse_;
};

/// 16 bits, little-endian, of a picture that tells its number: (x + 3 y + 7 n) mod 2000 + 500.
std::uint16_t painted_depth(int x, int y, std::uint32_t number);
std::function<std::vector<std::uint8_t>(std::uint32_t)> depth_painter(int width, int height,
                                                                      bool big_endian = false);
/// A node of depth of this size.
FakeNode& add_depth_node(FakeVideo& video, const std::string& node, int width, int height,
                         std::uint32_t code = V4L2_PIX_FMT_Z16);

}  // namespace touchable::test
