// SPDX-License-Identifier: Apache-2.0
// Your own importer: a file of another program becomes a clip that touchable opens. Here: raw depth of a
// camera, 16 bits little endian in millimetres, one frame after the other, with a confidence of 8 bits behind
// each frame.
//     c++ -std=c++17 own_importer.cpp $(pkg-config --cflags --libs touchable-media) -o own_importer
//     ./own_importer recording.raw 640x480 525 30 recording.mkv
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <touchable.hpp>
#include <vector>

int main(int count, char** words) {
    touch_camera camera = touch::camera();
    if (count != 6 || std::sscanf(words[2], "%dx%d", &camera.width, &camera.height) != 2)
        return std::fputs("own_importer RAW WIDTHxHEIGHT FOCAL_LENGTH FRAMES_PER_SECOND CLIP\n", stderr), 2;
    camera.fx_px = camera.fy_px = std::atof(words[3]);
    camera.cx_px = (camera.width - 1) / 2.0, camera.cy_px = (camera.height - 1) / 2.0;
    camera.frames_per_second = std::atof(words[4]);
    try {
        const touch::Scene scene(camera);  // checks all of it
        touch::Writer clip(words[5], scene);
        const std::size_t pixels =
            static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
        std::vector<std::uint16_t> depth(pixels);
        std::vector<char> confidence(pixels);
        std::ifstream raw(words[1], std::ios::binary);
        int frames = 0;
        for (; raw.read(reinterpret_cast<char*>(depth.data()), static_cast<std::streamsize>(2 * pixels)) &&
               raw.read(confidence.data(), static_cast<std::streamsize>(pixels));
             ++frames) {
            for (std::size_t k = 0; k < pixels; ++k)
                if (static_cast<unsigned char>(confidence[k]) < 128) depth[k] = 0;  // no surface
            touch_frame frame = touch::frame();
            frame.depth = {depth.data(), 2 * camera.width, camera.width, camera.height, TOUCH_U16, 1};
            clip.write(frame);
        }
        clip.finish();  // only now it has its name
        std::printf("%s: %d frames\n", words[5], frames);
    } catch (const touch::Error& error) {
        return std::fprintf(stderr, "%s\n", error.what()), 3;
    }
}
