// SPDX-License-Identifier: Apache-2.0
// A frame's surface as triangles, and their PLY file.

#include <bit>
#include <cerrno>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

constexpr std::uint32_t no_vertex = std::numeric_limits<std::uint32_t>::max();

/// Vertex number of each pixel of a row, `no_vertex` for invalid ones.
void add_row(const SurfaceFrame& frame, const Scene& scene, int y, Mesh& mesh,
             std::vector<std::uint32_t>& row) {
    const double height_per_code =
        largest_height(scene.height_coding, scene.depth) / scene.height_coding.code_max;
    for (int x = 0; x < frame.width; ++x) {
        const DepthSample sample = frame.vertices->at(x, y);
        std::uint32_t& vertex = row[static_cast<std::size_t>(x)];
        if (!sample.valid) {
            vertex = no_vertex;
            continue;
        }
        vertex = static_cast<std::uint32_t>(mesh.positions.size());
        const auto pixel = frame.index(x, y);
        const double depth =
            frame.heights.empty() ? sample.depth : sample.depth - height_per_code * frame.heights[pixel];
        const double planar = planar_depth(scene.camera, frame.coding.semantics, x, y, depth);
        mesh.positions.push_back(unproject(scene.camera, x, y, planar));
        mesh.pixels.push_back(static_cast<std::uint32_t>(pixel));
    }
}

void add_cells(const std::vector<std::uint32_t>& upper, const std::vector<std::uint32_t>& lower, Mesh& mesh) {
    for (std::size_t x = 0; x + 1 < upper.size(); ++x) {
        const std::uint32_t top_left = upper[x], top_right = upper[x + 1];
        const std::uint32_t bottom_left = lower[x], bottom_right = lower[x + 1];
        if (top_left == no_vertex || top_right == no_vertex || bottom_left == no_vertex ||
            bottom_right == no_vertex)
            continue;
        mesh.triangles.push_back({top_left, bottom_left, bottom_right});
        mesh.triangles.push_back({top_left, bottom_right, top_right});
    }
}

/// Appends integers and IEEE floats low byte first, whatever the machine's own order.
class LittleEndianWriter {
public:
    explicit LittleEndianWriter(std::ofstream& stream) : stream_(stream) { bytes_.reserve(block + 64); }
    void put(std::uint8_t value) { put_bytes(value, 1); }
    void put(std::uint32_t value) { put_bytes(value, 4); }
    void put(float value) { put_bytes(std::bit_cast<std::uint32_t>(value), 4); }
    void flush() {
        stream_.write(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
        bytes_.clear();
    }

private:
    static constexpr std::size_t block = 1 << 16;

    void put_bytes(std::uint64_t value, int count) {
        for (int k = 0; k < count; ++k) bytes_.push_back(static_cast<char>(value >> (8 * k)));
        if (bytes_.size() >= block) flush();
    }

    std::ofstream& stream_;
    std::string bytes_;
};

std::string header(const Mesh& mesh, bool coloured) {
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    text += "comment scene units; X right, Y up, camera at the origin looking along -Z\n";
    text += "element vertex " + std::to_string(mesh.positions.size()) + "\n";
    for (const char* axis : {"x", "y", "z"}) text += std::string("property float ") + axis + "\n";
    if (coloured)
        for (const char* channel : {"red", "green", "blue"})
            text += std::string("property uchar ") + channel + "\n";
    text += "element face " + std::to_string(mesh.triangles.size()) + "\n";
    return text + "property list uchar int vertex_indices\nend_header\n";
}

void write_body(std::ofstream& stream, const Mesh& mesh, const PlaneView& colour) {
    LittleEndianWriter out(stream);
    for (std::size_t n = 0; n < mesh.positions.size(); ++n) {
        for (int axis = 0; axis < 3; ++axis) out.put(static_cast<float>(mesh.positions[n][axis]));
        if (colour.empty()) continue;
        const int pixel = static_cast<int>(mesh.pixels[n]);
        for (int channel = 0; channel < 3; ++channel)
            out.put(
                static_cast<std::uint8_t>(colour.sample(pixel % mesh.width, pixel / mesh.width, channel)));
    }
    for (const auto& triangle : mesh.triangles) {
        out.put(std::uint8_t{3});
        for (const std::uint32_t vertex : triangle) out.put(vertex);
    }
    out.flush();
}

}  // namespace

Mesh make_mesh(const SurfaceFrame& frame, const Scene& scene) {
    Mesh mesh;
    mesh.width = frame.width;
    mesh.height = frame.height;
    std::vector<std::uint32_t> upper(static_cast<std::size_t>(frame.width)), lower(upper);
    for (int y = 0; y < frame.height; ++y) {
        add_row(frame, scene, y, mesh, lower);
        if (y > 0) add_cells(upper, lower, mesh);
        upper.swap(lower);
    }
    return mesh;
}

Result<void> write_ply(NewFile& file, const Mesh& mesh, const PlaneView& colour) {
    if (!colour.empty() && (colour.width != mesh.width || colour.height != mesh.height ||
                            colour.channels != 3 || colour.bytes_per_sample != 1))
        return input_error(file.target().string() +
                           ": the colours are not three channels of 8 bits of the mesh's picture, " +
                           size_text(mesh.width, mesh.height));

    TRY(file.check());
    std::ofstream stream(file.path(), std::ios::binary | std::ios::trunc);
    if (stream) {
        stream << header(mesh, !colour.empty());
        write_body(stream, mesh, colour);
        stream.close();
    }
    if (!stream)
        return input_error(file.target().string() + ": cannot be written: " +
                           std::error_code(errno, std::generic_category()).message());
    return {};
}

}  // namespace touchable
