#pragma once

#include <array>
#include <filesystem>
#include <string>

namespace touchable::test {

/// A clip of each kind of file, among the seeds of the fuzzer.
inline const std::array<std::string, 15> kept_clips{
    "clip/small.mkv",         "bag/realsense_lz4.bag", "bag/tum_bz2.bag",       "bag/depth_plain.bag",
    "k4a/with_colour.mkv",    "video/v.mp4",           "video/v.webm",          "video/v.avi",
    "depthkit_video/png.mov", "heic/portrait.heic",    "jpeg_depth/gdepth.jpg", "npy_stack/stack.npy",
    "npy_stack/stack.npz",    "png/grey16.png",        "tiff/float.tif"};

/// Copies one to `folder`, with the files that it needs beside it.
inline std::filesystem::path copied_clip(const std::string& kept, const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    const fs::path seeds = fs::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds",
                   clip = folder / fs::path(kept).filename();
    fs::copy_file(seeds / kept, clip, fs::copy_options::overwrite_existing);
    if (kept.starts_with("depthkit_video/"))
        fs::copy_file(seeds / "depthkit/one.asset", folder / (clip.stem().string() + ".Metadata.asset"),
                      fs::copy_options::overwrite_existing);
    return clip;
}

}  // namespace touchable::test
