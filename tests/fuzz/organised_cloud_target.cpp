// Organised clouds of points (PCD, PLY).
#include "engine/formats/organised_cloud.hpp"

#include <cmath>

#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool parse_cloud(std::string_view bytes) {
    (void)begins_organised_cloud(bytes);
    const auto cloud = decode_organised_cloud(bytes, "cloud");
    if (!is_taken(cloud)) return false;
    (void)is_picture(Result<StoredImage>(cloud->depth));
    if (cloud->depth.beside) (void)is_picture(Result<StoredImage>(*cloud->depth.beside->colour));
    for (const float depth : cloud->depth.values)
        require(std::isnan(depth) || depth > 0, "a depth is not ahead");
    if (!cloud->camera) return true;
    const Intrinsics& camera = *cloud->camera;
    require(camera.fx > 0 && camera.fy > 0 && std::isfinite(camera.fx + camera.fy + *camera.cx + *camera.cy),
            "a cloud's camera is none");
    return true;
}

const Registered organised_cloud_target{{.name = "organised_cloud", .parse = parse_cloud}};

}  // namespace
}  // namespace touchable::fuzz
