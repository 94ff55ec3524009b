// What `touchable cameras` tells a person.
#include "engine/camera/camera.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "tests/camera/fake_video.hpp"

namespace touchable::test {
namespace {

std::string how_to_touch(const std::string& camera, const std::string& with_colour) {
    return "    touch " + camera + " or " + with_colour + '\n';
}

TEST(CameraList, SaysWhatToDoWhereThereIsNone) {
    FakeVideo video;
    const std::string words = cameras_in_words(video, how_to_touch);
    EXPECT_EQ(words,
              "No camera is there (no /dev/video*): plug one in. Where one is plugged in, its driver is "
              "missing: sudo modprobe uvcvideo is that of USB cameras.\n");
}

TEST(CameraList, SaysWhatEachOffersAndHowItIsTouched) {
    FakeVideo video;
    FakeNode& depth = video.add("/dev/video0");
    depth.card = "Intel(R) RealSense(TM)";
    depth.formats = {{V4L2_PIX_FMT_Z16, {{640, 480, {{1, 30}, {1, 60}}}, {848, 480}}}};
    FakeNode& metadata = video.add("/dev/video1");
    metadata.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
    FakeNode& colour = video.add("/dev/video2");
    colour.formats = {{V4L2_PIX_FMT_YUYV, {{640, 480}}}, {V4L2_PIX_FMT_MJPEG, {}}};
    video.add("/dev/video3").refusals[0] = EACCES;
    EXPECT_EQ(
        cameras_in_words(video, how_to_touch),
        "/dev/video0  Intel(R) RealSense(TM) (fake, usb-1)\n"
        "    Z16     640x480 at 60, 30 frames/s; 848x480 at 30 frames/s\n"
        "    touch v4l2:/dev/video0 or v4l2:/dev/video0,colour=/dev/video2\n"
        "/dev/video1  A camera (fake, usb-1)\n"
        "    gives no pictures: a node of metadata or of another kind\n"
        "/dev/video2  A camera (fake, usb-1)\n"
        "    YUYV    640x480 at 30 frames/s\n"
        "    MJPG    its driver does not say which sizes\n"
        "    colour alone: there is nothing to touch\n"
        "/dev/video3: may not be opened by this user; right would be sudo usermod -aG video $USER, then "
        "log in again\n");
    EXPECT_EQ(video.misuse(), std::vector<std::string>());
    EXPECT_EQ(video.left_over(), std::vector<std::string>()) << "it only looks";
}

TEST(CameraList, SaysWhatARealSenseLacks) {
    FakeVideo video;
    FakeNode& colour = video.add("/dev/video0");
    colour.card = "Intel(R) RealSense(TM)";
    colour.formats = {{V4L2_PIX_FMT_YUYV, {{640, 480}}}};
    const std::string words = cameras_in_words(video, how_to_touch);
    EXPECT_NE(words.find("has no node of depth (Z16)"), std::string::npos) << words;
    EXPECT_NE(words.find("None of them gives depth"), std::string::npos) << words;
}

}  // namespace
}  // namespace touchable::test
