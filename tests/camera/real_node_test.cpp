// The kernel's own cameras, where it has some that need no hardware (vivid, v4l2loopback).
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "engine/camera/v4l2_stream.hpp"

namespace touchable::test {
namespace {

TEST(RealNode, StreamsAsTheKernelSays) {
    const auto video = system_video();
    for (const std::string& node : video->nodes()) {
        const auto facts = look_at_node(*video, node);
        if (!facts || facts->driver != "vivid" || facts->formats.empty()) continue;
        for (const NodeFormat& format : facts->formats) {
            if (!is_depth_format(format.code) && !is_colour_format(format.code)) continue;
            auto stream = V4l2Stream::open(video, *facts, format, {640, 360});
            ASSERT_TRUE(stream) << stream.error().message;
            for (int pictures = 0; pictures < 3;) {
                pollfd waited{(*stream)->descriptor(), POLLIN, 0};
                ASSERT_GT(video->poll({&waited, 1}, 5000), 0);
                const auto picture = (*stream)->take(V4l2Stream::Which::oldest);
                ASSERT_TRUE(picture) << picture.error().message;
                pictures += picture->has_value();
            }
        }
        return;
    }
    GTEST_SKIP() << "the kernel has no vivid (sudo modprobe vivid)";
}

/// As who may see it does: here this very program.
TEST(RealNode, SaysWhoHasADeviceOpen) {
    const int descriptor = ::open("/dev/null", O_RDONLY);
    ASSERT_GE(descriptor, 0);
    const std::string self = "(process " + std::to_string(::getpid()) + ")";
    EXPECT_NE(users_of_node("/dev/null").find(self), std::string::npos) << users_of_node("/dev/null");
    ::close(descriptor);
    EXPECT_EQ(users_of_node("/no/such/node"), "");
}

}  // namespace
}  // namespace touchable::test
