// The table beside a snapshot of the RealSense Viewer, and the picture that it describes.
#include <cmath>

#include "engine/formats/realsense_raw.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool parse_realsense_table(std::string_view bytes) {
    const auto camera = parse_realsense_metadata(bytes, "metadata");
    const SourceFile raw(file_of(std::string(2 * 4 * 3, '\1'), "snap_Depth.raw"));
    (void)file_of(bytes, "snap_Depth_metadata.csv");
    const bool is_opened = is_picture(read_realsense_raw(raw));
    if (!is_taken(camera)) {
        require(!is_opened, "a picture is read by a table that is refused");
        return false;
    }
    require(camera->width > 0 && camera->height > 0 && camera->fx > 0 && camera->fy > 0 &&
                std::isfinite(camera->fx + camera->fy + *camera->cx + *camera->cy),
            "a camera is none");
    return true;
}

const Registered realsense_metadata_target{{.name = "realsense_metadata", .parse = parse_realsense_table}};

}  // namespace
}  // namespace touchable::fuzz
