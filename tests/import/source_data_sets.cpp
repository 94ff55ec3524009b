// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "engine/picture/image.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/import/source_writer.hpp"
#include "tests/picture/hdf5_file.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

const std::string measured_flat = "[140.5, 0, 79.9, 0, 140.7, 60.1, 0, 0, 1]";
std::string matrix_of(const Camera& k, const std::string& between = " ", const std::string& rows = "\n") {
    std::ostringstream text;
    text << k.fx << between << 0 << between << k.cx << rows << 0 << between << k.fy << between << k.cy << rows
         << 0 << between << 0 << between << 1;
    return text.str();
}
/// Without the hole.
double whole_room(int n, int x, int y) {
    return room(n, std::max(x, 4), y);
}
/// NumPy's array of two cameras.
std::string measured_twice() {
    constexpr float fx = 140.5F, fy = 140.7F, cx = 79.9F, cy = 60.1F;
    return npy_bytes("2, 3, 3", {fx, 0, cx, 0, fy, cy, 0, 0, 1, fx, 0, cx, 0, fy, cy, 0, 0, 1});
}
constexpr Camera measured_float{140.5F, 140.7F, 79.9F, 60.1F};

// Networks.

Made midas(Writer& w) {
    const RelativeDepth depth{65535};
    const std::string name = w.name("input-dpt_beit_large_512.png", "a.png");
    w.png16(name, [v = depth.values()](int x, int y) { return v(0, x, y); });
    return made(w / name, depth.metres(), seen(60));
}
Made depth_anything(Writer& w) {
    const RelativeDepth depth{255};
    const std::string name = w.name("street.png", "a.png");
    const Depth value = depth.values();
    write_in_folder(w / name,
                    made_image(wide, high, 1, 3, [&](int x, int y, int) { return value(0, x, y); }));
    return made(w / name, depth.metres(), seen(60));
}
Made depth_anything_metric(Writer& w) {
    const fs::path file = w / w.name("street_raw_depth_meter.npy", "a.npy");
    write_bytes(file, npy_bytes(shape_of_room(), floats_of(whole_room, 0)));
    return made(file, whole_room, seen(60));
}
std::vector<float> two_frames(const Depth& depth, double of_none) {
    std::vector<float> values = floats_of(depth, of_none, 0), second = floats_of(depth, of_none, 1);
    values.insert(values.end(), second.begin(), second.end());
    return values;
}
Made da3(Writer& w) {
    const fs::path file = w / w.name("exports/npz/results.npz", "a.npz");
    write_npz(file, {{"depth", npy_bytes(shape_of_room("2, "), two_frames(whole_room, 0))},
                     {"conf", npy_bytes(shape_of_room("2, "), std::vector<float>(2 * wide * high, 1.7F))},
                     {"extrinsics", npy_bytes("2, 3, 4", std::vector<float>(24, 1))},
                     {"intrinsics", measured_twice()}});
    return made(file, whole_room, measured_float, 2);
}
Made vda(Writer& w) {
    const RelativeDepth depth{700, true, false};
    const Depth still = [v = depth.values()](int, int x, int y) { return v(0, x, y); };
    write_npz(w / "walk_depths.npz", {{"depths", npy_bytes(shape_of_room("2, "), two_frames(still, 0))}});
    write_film(w / "walk_src.mp4", 2, {24, 1});
    return made(
        w / "walk_depths.npz", [z = depth.metres()](int, int x, int y) { return z(0, x, y); }, seen(60), 2,
        24, true);
}
Made moge(Writer& w) {
    const std::string depth = w.name("depth.exr", "a.exr"), image = w.name("image.jpg", "b.jpg");
    write_exr(w / depth, {{"Y", floats_of(room, INFINITY)}});
    write_exr(w / "points.exr",
              {{"R", floats_of(room, 0)}, {"G", floats_of(room, 0)}, {"B", floats_of(room, 0)}});
    w.colour(image);
    w.grey("mask.png", [](int x, int) { return x < 4 ? 0 : 255; });
    w.text(w.name("fov.json", "f.json"), R"({"fov_x": 59.31, "fov_y": 46.26})");
    Camera camera = seen(59.31);
    return made(w.folder(), room, camera, 1, 30, true);
}
Made depth_pro(Writer& w) {
    const fs::path file = w / w.name("street.npz", "a.npz");
    write_npz(file, {{"depth", npy_bytes(shape_of_room(), floats_of(whole_room, 0))}});
    w.colour(file.stem().string() + ".jpg");
    return made(file, whole_room, seen(60), 1, 30, true);
}
Made zoedepth(Writer& w) {
    const std::string name = w.name("depth.png", "a.png");
    w.room16(name, 256);
    return made(w / name, room_in(256), seen(60));
}
Made depth_buffer(Writer& w) {
    const fs::path file = w / w.name("depth.npy", "a.npy");
    const auto share = [](int n, int x, int y) { return (10 - 1 / room(n, x, y)) / (10 - 0.01); };
    write_bytes(file, npy_bytes(shape_of_room(), floats_of(share, 1)));
    return made(file, room, seen(60));
}
/// Rounded to 11 bits.
Made midair(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), rgb = w.name("color_left/", "b/");
    const auto half = [](int n, int x, int y) {
        int exponent = 0;
        const double share = std::frexp(10 * room(n, x, y), &exponent);
        return std::isnan(share) ? std::pair(0, 0.0)
                                 : std::pair(exponent, std::lround(share * 2048) / 2048.0);
    };
    for (int n = 0; n < 2; ++n) {
        w.png16(depth + six_digits(n) + ".png", [=](int x, int y) {
            const auto [exponent, share] = half(n, x, y);
            return share == 0 ? 0 : (exponent + 14) * 1024 + static_cast<int>(share * 2048) - 1024;
        });
        w.colour(rgb + six_digits(n) + ".jpg");
    }
    const auto metres = [half](int n, int x, int y) {
        const auto [exponent, share] = half(n, x, y);
        return share == 0 ? none : std::ldexp(share, exponent);
    };
    return made(w.folder(), metres, seen(60), 2, 30, true);
}
Made marigold(Writer& w) {
    const RelativeDepth depth{1, false, false};
    const fs::path file = w / w.name("depth_npy/street_pred.npy", "a.npy");
    write_bytes(file, npy_bytes(shape_of_room(), floats_of(depth.values(), 0)));
    return made(file, depth.metres(), seen(60));
}
Made rgbd(Writer& w) {
    const RelativeDepth depth{255};
    const fs::path file = w / w.name("desk_rgbd.png", "a.png");
    write_in_folder(file, made_image(2 * wide, high, 1, 3, [value = depth.values()](int x, int y, int c) {
                        if (x >= wide) return static_cast<int>(value(0, x - wide, y));
                        return c == 0 ? 40 + x : c == 1 ? 120 : 200 - y;
                    }));
    return made(file, depth.metres(), seen(60), 1, 30, true);
}

Made mvsnet(Writer& w) {
    const fs::path file = w / w.name("depth_map_0000.pfm", "a.pfm");
    write_pfm(file, floats_of(millimetres(room), 0));
    return made(file, room, seen(60));
}

// Data sets.

Made tum(Writer& w) {
    std::string depths = "# depth maps\n# file: 'x.bag'\n# timestamp filename\n", colours = depths,
                poses = "# p\n";
    for (int n = 0; n < 3; ++n) {
        std::ostringstream stamp;
        stamp << std::fixed << std::setprecision(6) << 1305031102.160407 + n / 30.0;
        w.room16("depth/" + stamp.str() + ".png", 5000, n);
        w.colour("rgb/" + stamp.str() + ".png");
        depths += stamp.str() + " depth/" + stamp.str() + ".png\n";
        colours += stamp.str() + " rgb/" + stamp.str() + ".png\n";
        poses += stamp.str() + " 1.3 0.6 1.6 0.6 0.6 -0.3 -0.3\n";
    }
    w.text("depth.txt", depths);
    w.text("rgb.txt", colours);
    w.text("groundtruth.txt", poses);
    return made(w.folder(), room_in(5000), {525 / 4.0, 525 / 4.0, 79.5, 59.5}, 3, 30, true);
}
Made seven_scenes(Writer& w) {
    const std::string depth = w.name(".depth.png", ".a.png"), colour = w.name(".color.png", ".b.png");
    for (int n = 0; n < 2; ++n) {
        const std::string frame = "frame-" + six_digits(n);
        w.png16(frame + depth, [=](int x, int y) {
            return std::isnan(room(n, x, y)) ? 65535 : int{room_code(1000, n, x, y)};
        });
        w.colour(frame + colour);
        w.text(frame + ".pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    }
    return made(w.folder(), room_in(1000),
                {585 / 4.0, 585 / 4.0, (320 - 319.5) / 4 + 79.5, (240 - 239.5) / 4 + 59.5}, 2, 30, true);
}
Made scannet(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), colour = w.name("color/", "b/");
    for (int n = 0; n < 2; ++n) {
        w.room16(depth + std::to_string(n) + ".png", 1000, n);
        w.colour(colour + std::to_string(n) + ".jpg");
        w.text("pose/" + std::to_string(n) + ".txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    }
    w.text("intrinsic/intrinsic_depth.txt", "140.5 0 79.9 0\n0 140.7 60.1 0\n0 0 1 0\n0 0 0 1\n");
    w.text("intrinsic/intrinsic_color.txt", "1170 0 648 0\n0 1170 484 0\n0 0 1 0\n0 0 0 1\n");
    w.text("intrinsic/extrinsic_depth.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    return made(w.folder(), room_in(1000), measured, 2, 30, true);
}
Made bop(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), rgb = w.name("rgb/", "b/");
    std::string cameras;
    for (int n = 0; n < 3; ++n) {
        w.room16(depth + six_digits(n) + ".png", 10000, n);
        w.colour(rgb + six_digits(n) + ".png");
        cameras += (n ? ", \"" : "\"") + std::to_string(n) + R"(": {"cam_K": )" + measured_flat +
                   R"(, "depth_scale": 0.1})";
    }
    w.text(w.name("scene_camera.json", "c.json"), '{' + cameras + '}');
    w.text("scene_gt.json",
           R"({"0": [{"cam_R_m2c": [1,0,0,0,1,0,0,0,1], "cam_t_m2c": [0,0,700], "obj_id": 1}]})");
    return made(w.folder(), room_in(10000), measured, 3, 30, true);
}
Made sun(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), image = w.name("image/", "b/");
    w.png16(depth + "NYU0001.png", [](int x, int y) {
        const std::uint16_t code = room_code(1000, 0, x, y);
        return (code << 3 | code >> 13) & 65535;
    });
    w.room16(w.name("depth_bfx/", "c/") + "NYU0001.png", 8000, 1);  // filled by its authors
    w.colour(image + "NYU0001.jpg");
    w.text(w.name("intrinsics.txt", "k.txt"), matrix_of(measured));
    w.text("extrinsics/20140801000000.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n");
    return made(w.folder(), room_in(1000), measured, 1, 30, true);
}
Made redwood(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), colour = w.name("color/", "b/");
    std::string poses;
    for (int n = 0; n < 2; ++n) {
        w.room16(depth + six_digits(n) + ".png", 1000, n);
        w.colour(colour + six_digits(n) + ".jpg");
        poses += std::to_string(n) + ' ' + std::to_string(n) + " 2\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    }
    w.text("trajectory.log", poses);
    return made(w.folder(), room_in(1000), {525 / 4.0, 525 / 4.0, 79.5, 59.5}, 2, 30, true);
}
Made icl(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), rgb = w.name("rgb/", "b/");
    for (int n = 0; n < 2; ++n) {
        w.room16(depth + std::to_string(n) + ".png", 5000, n);
        w.colour(rgb + std::to_string(n) + ".png");
    }
    return made(w.folder(), room_in(5000), {481.2 / 4, 480 / 4.0, 79.5, 59.5}, 2, 30, true);
}
Made void_set(Writer& w) {
    for (int n = 0; n < 2; ++n) {
        const std::string name = n ? "1551915398.7090.png" : "1551915398.6757.png";
        w.room16("ground_truth/" + name, 256, n);
        w.colour("image/" + name);
        w.png16("sparse_depth/" + name,
                [=](int x, int y) { return x % 7 || y % 7 ? 0 : int{room_code(256, n, x, y)}; });
        w.grey("validity_map/" + name, [](int x, int y) { return x % 7 || y % 7 ? 0 : 255; });
    }
    w.text("K.txt", matrix_of(measured));
    return made(w.folder(), room_in(256), measured, 2, 30, true);
}
Made kitti(Writer& w) {
    const auto code = [](int n, int x, int y) {
        return (x + 3 * y) % 5 || y < 40
                   ? 0
                   : static_cast<int>(std::lround(256 * (2000.0 / (y + 5) + 0.01 * x + n)));
    };
    for (int n = 0; n < 2; ++n)
        w.png16(
            "image_02/000000000" + std::to_string(5 + n) + ".png",
            [=](int x, int y) { return code(n, x, y); }, 414, 125);
    w.name("", "");
    return made(
        w.folder() / "image_02",
        [=](int n, int x, int y) { return code(n, x, y) ? code(n, x, y) / 256.0 : none; },
        {721.5377 / 3, 721.5377 / 3, (609.5593 - 620.5) / 3 + 206.5, (172.854 - 187) / 3 + 62}, 2, 30, false,
        414, 125);
}
Made vkitti(Writer& w) {
    const std::string depth = "depth/Camera_0/depth_";
    std::string cameras = "frame cameraID K[0,0] K[1,1] K[0,2] K[1,2]\n";
    for (int n = 0; n < 2; ++n) {
        w.png16("frames/" + depth + "0000" + std::to_string(n) + ".png", [=](int x, int y) {
            return std::isnan(room(n, x, y)) ? 65535 : static_cast<int>(std::lround(1400 * room(n, x, y)));
        });
        w.colour("frames/rgb/Camera_0/rgb_0000" + std::to_string(n) + ".jpg");
        cameras += std::to_string(n) + " 0 140.5 140.7 79.9 60.1\n";
    }
    w.text("intrinsic.txt", cameras);
    return made((w / ("frames/" + depth)).parent_path(),
                [](int n, int x, int y) { return std::round(1400 * room(n, x, y)) / 100; }, measured, 2);
}
Made diode(Writer& w) {
    const std::string stem = "00019_00183_indoors_000_010";
    w.text(stem + "_depth.npy", npy_bytes(shape_of_room("", ", 1"), floats_of(room, 0)));
    w.text(stem + "_depth_mask.npy", npy_bytes(shape_of_room(), std::vector<float>(wide * high, 1)));
    w.colour(stem + ".png");
    return made(w / (stem + "_depth.npy"), room, seen(60), 1, 30, true);
}
Made middlebury(Writer& w) {
    const auto disparity = [](int n, int x, int y) { return 140.5 * 0.193001 / room(n, x, y) - 2.5; };
    write_pfm(w / "disp0.pfm", floats_of(disparity, INFINITY));
    w.colour("im0.png");
    w.text("calib.txt",
           "cam0=[140.5 0 79.9; 0 140.5 60.1; 0 0 1]\ncam1=[140.5 0 82.4; 0 140.5 60.1; 0 0 1]\ndoffs=2.5\n"
           "baseline=193.001\nwidth=160\nheight=120\nndisp=60\nisint=0\nvmin=5\nvmax=50\n");
    return made(w / "disp0.pfm", room, {140.5, 140.5, 79.9, 60.1}, 1, 30, true);
}
Made kitti_stereo(Writer& w) {
    const auto code = [](int n, int x, int y) {
        return std::isnan(room(n, x, y)) ? 0
                                         : static_cast<int>(std::lround(256 * 140.5 * 0.54 / room(n, x, y)));
    };
    w.png16("training/disp_occ_0/000000_10.png", [&](int x, int y) { return code(0, x, y); });
    w.colour("training/image_2/000000_10.png");
    w.text("training/calib_cam_to_cam/000000.txt",
           "calib_time: 01-Jan-2012 00:00:00\nS_rect_02: 160 120\n"
           "P_rect_02: 140.5 0 79.9 8.97 0 140.5 60.1 0.04 0 0 1 0.003\n"
           "P_rect_03: 140.5 0 79.9 -66.9 0 140.5 60.1 0.04 0 0 1 0.003\n");
    return made(
        w.folder() / "training",
        [=](int n, int x, int y) { return code(n, x, y) ? 256 * 140.5 * 0.54 / code(n, x, y) : none; },
        {140.5, 140.5, 79.9, 60.1}, 1, 30, true);
}
Made tartanair(Writer& w) {
    const std::string depth = w.name("depth_lcam_front/", "a/"), image = w.name("image_lcam_front/", "b/");
    for (int n = 0; n < 2; ++n) {
        const std::string number = "00000" + std::to_string(n), name = w.name("_lcam_front", "");
        const std::string file = depth + number + (name.empty() ? "" : name + "_depth") + ".png";
        write_bytes(w / file, rgba_png(wide, high, [n](int x, int y, int k) {
                        const double z = room(n, x, y);
                        const auto bits =
                            std::bit_cast<std::uint32_t>(static_cast<float>(std::isnan(z) ? 0 : z));
                        constexpr int places[] = {2, 1, 0, 3};
                        return bits >> 8 * places[k] & 0xffU;
                    }));
        w.colour(image + number + name + ".png");
    }
    return made(w.folder(), room, seen(90), 2, 30, true);
}
Made pointodyssey(Writer& w) {
    constexpr double unit = 0.01525902;
    for (int n = 0; n < 2; ++n) {
        const std::string number = "0000" + std::to_string(n);
        w.room16(w.name("depths/depth_", "a/") + number + ".png", 1 / unit, n);
        w.colour(w.name("rgbs/rgb_", "b/") + number + ".jpg");
    }
    write_npz(w / w.name("anno.npz", "words.npz"),
              {{"intrinsics", measured_twice()},
               {"extrinsics", npy_bytes("2, 4, 4", std::vector<float>(32, 1))},
               {"trajs_2d", npy_bytes("2, 7, 2", std::vector<float>(28, 1))}});
    return made(w.folder(), room_in(1 / unit), measured_float, 2, 30, true);
}
Made sintel(Writer& w) {
    for (int n = 0; n < 2; ++n) {
        const std::vector<float> floats = floats_of(room, 0, n);
        const std::int32_t size[] = {wide, high};
        w.text(w.name("alley_1/frame_000", "a/") + std::to_string(n + 1) + ".dpt",
               "PIEH" + std::string(reinterpret_cast<const char*>(size), sizeof size) +
                   std::string(reinterpret_cast<const char*>(floats.data()), 4 * floats.size()));
    }
    return made(w / w.name("alley_1", "a"), room, seen(60), 2);
}
Made lerobot(Writer& w) {
    const double low = std::log(0.01 + 3.5), span = std::log(10 + 3.5) - low;
    const auto code = [=](int n, int x, int y) {
        const double z = room(n, x, y);
        return std::isnan(z) ? 0 : static_cast<int>(std::lround((std::log(z + 3.5) - low) / span * 4095));
    };
    ForeignVideo video{"libx265", AV_PIX_FMT_GRAY12, wide, high, 3};
    video.tag = MKTAG('h', 'v', 'c', '1');
    const std::string file = "/chunk-000/file-000.mp4";
    write_video(w / ("videos/observation.images.wrist_depth" + file), video, [=](AVFrame& frame, int n) {
        fill_plane(frame, 0, [&](int x, int y) { return code(n, x, y); });
    });
    write_film(w / ("videos/observation.images.wrist" + file), 3);
    w.text("meta/info.json", R"({"codebase_version": "v3.0", "fps": 30, "features": {
        "observation.images.wrist_depth": {"dtype": "video", "shape": [120, 160, 1],
            "names": ["height", "width", "channels"], "info": {"is_depth_map": true, "video.codec": "hevc",
            "video.pix_fmt": "gray12le", "video.fps": 30, "video.depth_min": 0.01, "video.depth_max": 10.0,
            "video.shift": 3.5, "video.use_log": true}},
        "observation.images.wrist": {"dtype": "video", "shape": [120, 160, 3], "info": {"is_depth_map": false,
            "video.codec": "h264", "video.pix_fmt": "yuv420p"}}}})");
    return made(
        w.folder(),
        [=](int n, int x, int y) {
            return code(n, x, y) ? std::exp(code(n, x, y) * span / 4095 + low) - 3.5 : none;
        },
        seen(60), 3, 30, true);
}

void add_floats(const fs::path& file, const std::string& path, const std::vector<int>& shape,
                const std::vector<float>& values) {
    EXPECT_TRUE(add_data_set(file, {path, shape, "FP", 32},
                             std::string(reinterpret_cast<const char*>(values.data()), 4 * values.size())))
        << "needs h5import (hdf5-tools)";
}
Made hypersim(Writer& w) {
    for (int n = 0; n < 2; ++n)
        add_floats(w / ("frame.000" + std::to_string(n) + ".depth_meters.hdf5"), "dataset", {high, wide},
                   floats_of(room, 0, n));
    Made found = made(w.folder(), room, seen(60), 2);
    found.semantics = DepthSemantics::range;
    return found;
}
Made nyuv2(Writer& w) {
    const std::string file = w.name("nyu_depth_v2_labeled.mat", "a.mat");
    // Rows and columns change places, as MATLAB stores its first index last.
    std::vector<float> turned;
    for (int n = 0; n < 2; ++n)
        for (int x = 0; x < wide; ++x)
            for (int y = 0; y < high; ++y)
                turned.push_back(std::isnan(room(n, x, y)) ? 0 : static_cast<float>(room(n, x, y)));
    add_floats(w / "plain.h5", "depths", {2, wide, high}, turned);
    put_matlab_before(w / "plain.h5", w / file);
    return made(w / file, room, seen(57.8), 2);
}
Made robomimic(Writer& w) {
    const std::string file = w.name("image_demo.hdf5", "a.h5");
    for (const char* demo : {"0", "1"})
        add_floats(w / file, "data/demo_" + std::string(demo) + "/obs/agentview_depth", {2, high, wide, 1},
                   two_frames(room, 0));
    return made(w / file, room, seen(45), 2);
}
Made pcl(Writer& w) {
    const std::string file = w.name("cloud.pcd", "a.pcd");
    std::string bytes =
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\n"
        "TYPE F F F\nCOUNT 1 1 1\nWIDTH 160\nHEIGHT 120\nVIEWPOINT 0 0 0 1 0 0 0\n"
        "POINTS 19200\nDATA binary\n";
    for (int y = 0; y < high; ++y)
        for (int x = 0; x < wide; ++x) {
            const double z = room(0, x, y);
            for (const double at :
                 {(x - measured.cx) / measured.fx * z, (y - measured.cy) / measured.fy * z, z}) {
                const auto number = static_cast<float>(at);
                bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
            }
        }
    w.text(file, bytes);
    return made(w / file, room, measured);
}

}  // namespace

std::map<std::string, SourceMaker> data_set_makers() {
    return {{"midas", midas},
            {"depth-anything", depth_anything},
            {"depth-anything-metric", depth_anything_metric},
            {"da3", da3},
            {"vda", vda},
            {"moge", moge},
            {"depth-pro", depth_pro},
            {"zoedepth", zoedepth},
            {"depth-buffer", depth_buffer},
            {"marigold", marigold},
            {"rgbd", rgbd},
            {"mvsnet", mvsnet},
            {"tum", tum},
            {"7scenes", seven_scenes},
            {"scannet", scannet},
            {"midair", midair},
            {"bop", bop},
            {"sun", sun},
            {"redwood", redwood},
            {"icl", icl},
            {"void", void_set},
            {"kitti", kitti},
            {"vkitti", vkitti},
            {"diode", diode},
            {"middlebury", middlebury},
            {"sintel", sintel},
            {"lerobot", lerobot},
            {"kitti-stereo", kitti_stereo},
            {"tartanair", tartanair},
            {"pointodyssey", pointodyssey},
            {"hypersim", hypersim},
            {"nyuv2", nyuv2},
            {"robomimic", robomimic},
            {"pcl", pcl}};
}

}  // namespace touchable::test
