// SPDX-License-Identifier: Apache-2.0
#include "bench/real/depth_forms.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <half.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include "bench/real/depth_map.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "tests/import/bag_bytes.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;
using Floats = std::vector<float>;

fs::path numbered(const fs::path& folder, std::size_t n, const char* ending) {
    return folder / formatted("depth_%04zu.%s", n, ending);
}

Floats metres_of(const RawFrame& frame, const Scene& scene) {
    Floats metres;
    for (const double depth : depths_of(frame, scene).depths)
        metres.push_back(static_cast<float>(depth * scene.metres_per_unit));
    return metres;
}

Result<fs::path> write_pngs(const fs::path& folder, const Scene& scene, const std::vector<RawFrame>& frames) {
    for (std::size_t n = 0; n < frames.size(); ++n) {
        std::vector<std::uint16_t> codes;  // 0 where depth is invalid, as in the other forms
        for (const double depth : depths_of(frames[n], scene).depths)
            codes.push_back(static_cast<std::uint16_t>(depth / scene.depth.scale + 0.5));
        const PlaneView view{reinterpret_cast<const std::uint8_t*>(codes.data()),
                             std::ptrdiff_t{2} * scene.width,
                             scene.width,
                             scene.height,
                             2,
                             1};
        if (auto done = write_png(numbered(folder, n, "png"), view); !done) return done.error();
    }
    return folder;
}

Result<fs::path> write_array(const fs::path& folder, const Scene& scene,
                             const std::vector<RawFrame>& frames) {
    // https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html, version 1.0
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" +
                         std::to_string(frames.size()) + ", " + std::to_string(scene.height) + ", " +
                         std::to_string(scene.width) + "), }";
    while ((10 + header.size() + 1) % 64 != 0) header += ' ';
    header += '\n';
    std::string bytes("\x93NUMPY\x01\x00", 8);
    test::put(bytes, static_cast<std::uint16_t>(header.size()));
    bytes += header;
    for (const RawFrame& frame : frames) {
        const Floats metres = metres_of(frame, scene);
        bytes.append(reinterpret_cast<const char*>(metres.data()), sizeof(float) * metres.size());
    }
    std::ofstream(folder / "depth.npy", std::ios::binary) << bytes;
    return folder / "depth.npy";
}

Result<fs::path> write_halves(const fs::path& folder, const Scene& scene,
                              const std::vector<RawFrame>& frames) {
    const auto row = static_cast<std::size_t>(scene.width);
    for (std::size_t n = 0; n < frames.size(); ++n) {
        const Floats metres = metres_of(frames[n], scene);
        std::vector<half> halves(metres.begin(), metres.end());
        Imf::Header header(scene.width, scene.height);
        header.channels().insert("Z", Imf::Channel(Imf::HALF));
        Imf::FrameBuffer pixels;
        pixels.insert("Z", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.data()), 2, 2 * row));
        Imf::OutputFile out(numbered(folder, n, "exr").c_str(), header);
        out.setFrameBuffer(pixels);
        out.writePixels(scene.height);
    }
    return folder;
}

Result<fs::path> write_bag(const fs::path& folder, const Scene& scene, const std::vector<RawFrame>& frames) {
    test::BagBytes bag;
    for (std::size_t n = 0; n < frames.size(); ++n) {
        const std::int64_t time = scene.rate.time_ns(static_cast<std::int64_t>(n)) + 1'000'000'000;
        const Floats metres = metres_of(frames[n], scene);
        test::ImageMessage image{
            time, scene.width, scene.height, "32FC1", false, static_cast<std::uint32_t>(4 * scene.width), {}};
        image.data.assign(reinterpret_cast<const char*>(metres.data()), sizeof(float) * metres.size());
        bag.add("/camera/depth/image", "sensor_msgs/Image", time, image.bytes());
    }
    std::ofstream(folder / "depth.bag", std::ios::binary) << bag.file("none");
    return folder / "depth.bag";
}

/// The same scene with millimetres as unit.
Scene in_millimetres(Scene scene) {
    const double mm = 1000 * scene.metres_per_unit;
    DepthCoding& depth = scene.depth;
    depth.near *= mm;
    depth.far *= mm;
    depth.scale *= mm;
    depth.shift *= mm;
    scene.metres_per_unit = 0.001;
    return scene;
}

/// Removed by its destructor.
struct TemporaryFolder {
    fs::path path;
    explicit TemporaryFolder(const std::string& name) : path(fs::temp_directory_path() / name) {
        fs::remove_all(path);
        fs::create_directories(path);
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
};

}  // namespace

const std::vector<DepthForm>& depth_forms() {
    static const std::vector<DepthForm> forms{
        {"png", write_pngs}, {"npy", write_array}, {"exr", write_halves}, {"bag", write_bag}};
    return forms;
}

Result<OpenedForm> opened(const DepthForm& form, const Scene& scene, const std::vector<RawFrame>& frames) {
    const TemporaryFolder folder("touchable-bench-" + std::string(form.name) + "-" +
                                 std::to_string(getpid()));
    const auto written = form.write(folder.path, scene, frames);
    if (!written) return written.error();
    SourceDescription known;
    known.intrinsics = Intrinsics{scene.camera.fx, scene.camera.fy, scene.camera.cx, scene.camera.cy};
    auto reader = open_clip(*written, {}, known);
    if (!reader) return reader.error();
    OpenedForm found{in_millimetres((*reader)->scene()), {}};
    for (;;) {
        auto raw = (*reader)->next();
        if (!raw) return raw.error();
        if (!*raw) return found;
        found.frames.push_back(std::move(**raw));
    }
}

}  // namespace touchable
