// Wrote the bags in tests/fuzz/seeds/bag, by librosbag-storage 1.15.15 of Debian 12, which is not needed to
// build or test:
//   g++ -std=c++17 write_bags.cpp $(pkg-config --cflags --libs rosbag_storage) && ./a.out
// Definitions of messages, which readers of known messages pass over, are left out to keep the files small.
#include <geometry_msgs/Transform.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/Float32.h>

#include <boost/make_shared.hpp>
#include <cstring>
#include <string>

namespace {

template <class Message>
void write(rosbag::Bag& bag, const std::string& topic, ros::Time time, const Message& message) {
    auto header = boost::make_shared<ros::M_string>();
    (*header)["type"] = ros::message_traits::datatype(message);
    (*header)["md5sum"] = ros::message_traits::md5sum(message);
    (*header)["message_definition"] = "";
    bag.write(topic, time, message, header);
}

/// Pixel x, y of picture n: 16 bits 500 + 10 n + 3 x + 40 y; floats a thousandth of it; colour 10 n + x, 2 y,
/// 3 x.
sensor_msgs::Image picture(const std::string& encoding, int n, ros::Time time, const std::string& frame) {
    sensor_msgs::Image image;
    image.header.stamp = time;
    image.header.frame_id = frame;
    image.width = 16;
    image.height = 12;
    image.encoding = encoding;
    const int bytes = encoding == "32FC1" ? 4 : encoding == "rgb8" ? 3 : 2;
    image.step = 16 * bytes;
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 16; ++x) {
            const uint16_t code = 500 + 10 * n + 3 * x + 40 * y;
            const float metres = 0.001F * code;
            unsigned char pixel[4] = {static_cast<unsigned char>(10 * n + x),
                                      static_cast<unsigned char>(2 * y), static_cast<unsigned char>(3 * x)};
            if (bytes == 2) std::memcpy(pixel, &code, 2);
            if (bytes == 4) std::memcpy(pixel, &metres, 4);
            image.data.insert(image.data.end(), pixel, pixel + bytes);
        }
    return image;
}

sensor_msgs::CameraInfo camera(double f) {
    sensor_msgs::CameraInfo info;
    info.width = 16;
    info.height = 12;
    info.distortion_model = "plumb_bob";
    info.D.assign(5, 0);
    info.K = {f, 0, 7.75, 0, f + 1, 5.25, 0, 0, 1};
    info.P = {f, 0, 7.75, 0, 0, f + 1, 5.25, 0, 0, 0, 1, 0};
    return info;
}

/// As Intel's library records its cameras.
void write_realsense() {
    rosbag::Bag bag("realsense_lz4.bag", rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::LZ4);
    const ros::Time start(0, 1);
    const std::string sensor = "/device_0/sensor_0/", depth = sensor + "Depth_0/",
                      colour = "/device_0/sensor_1/Color_0/";
    std_msgs::Float32 unit;
    unit.data = 0.00025F;
    write(bag, sensor + "option/Depth Units/value", start, unit);
    write(bag, depth + "info/camera_info", start, camera(20));
    write(bag, colour + "info/camera_info", start, camera(24));
    geometry_msgs::Transform beside;
    beside.rotation.w = 1;
    write(bag, depth + "tf/0", start, beside);
    beside.translation.x = 0.015;
    beside.rotation.z = 0.001;
    beside.rotation.w = 0.9999995;
    write(bag, colour + "tf/0", start, beside);
    for (int n = 0; n < 3; ++n) {
        const ros::Time recorded(0, 100000000 + n * 66666667);
        write(bag, depth + "image/data", recorded,
              picture("mono16", n, ros::Time(1600000000.066 + n / 15.), ""));
        write(bag, colour + "image/data", recorded,
              picture("rgb8", n, ros::Time(1600000000.070 + n / 15.), ""));
    }
}

/// As the data sets of TUM are, of a Kinect by openni_camera; of two chunks.
void write_tum() {
    rosbag::Bag bag("tum_bz2.bag", rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::BZ2);
    bag.setChunkThreshold(1500);
    const double start = 1305031102.16;
    for (int n = 0; n < 4; ++n) {
        const ros::Time time(start + n / 30.);
        write(bag, "/camera/depth/camera_info", time, camera(21));
        write(bag, "/camera/depth/image", time, picture("32FC1", n, time, "/openni_rgb_optical_frame"));
        write(bag, "/camera/rgb/image_color", time + ros::Duration(0.015),
              picture("rgb8", n, time + ros::Duration(0.015), "/openni_rgb_optical_frame"));
    }
}

void write_plain() {
    rosbag::Bag bag("depth_plain.bag", rosbag::bagmode::Write);
    for (int n = 0; n < 2; ++n) {
        const ros::Time time(100 + n);
        write(bag, "/camera/aligned_depth_to_color/image_raw", time, picture("16UC1", n, time, "lens"));
        write(bag, "/camera/depth/image_rect_raw", time, picture("16UC1", n + 5, time, "lens"));
    }
}

}  // namespace

int main() {
    write_realsense();
    write_tum();
    write_plain();
}
