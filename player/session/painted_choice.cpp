#include "player/session/painted_choice.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine/authoring/material_clip.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"

namespace touchable {

Result<SegmentStore> read_chosen_segments(const ClipChoice& choice,
                                          const std::function<void(std::int64_t frame)>& progress,
                                          const std::stop_token& given_up) {
    if (choice.is_camera())
        return usage_error(
            "materials are painted on clips, whose segments can be found beforehand; this is a camera");
    const WorkUntil until(given_up);
    ClipChoice own = choice;
    own.shared_clip.reset();
    own.relief.reset();  // heights tell nothing of segments
    own.painted.reset();
    TRY_ASSIGN(const auto reader, own.open());
    return read_segments(*reader, begin_segments, progress);
}

std::string segments_depend_on(const ClipChoice& choice) {
    const auto whole = [](const std::filesystem::path& file) {
        std::error_code failed;
        const auto name = std::filesystem::weakly_canonical(file, failed);
        return failed ? file.string() : name.string();
    };
    nlohmann::ordered_json said = nlohmann::ordered_json::object();
    if (choice.scene_file) said["scene"] = whole(*choice.scene_file);
    const SourceDescription of_camera = choice.camera.value_or(SourceDescription());
    if (of_camera.intrinsics) {
        const Intrinsics& lens = *of_camera.intrinsics;
        said["intrinsics"] = {lens.fx, lens.fy, lens.cx.value_or(-1), lens.cy.value_or(-1)};
    }
    if (of_camera.fov) said["fov"] = *of_camera.fov;
    if (of_camera.metres_per_code) said["depth-unit"] = *of_camera.metres_per_code;
    if (!of_camera.file.empty()) said["camera-file"] = whole(of_camera.file);
    if (!of_camera.preset.empty()) said["preset"] = of_camera.preset;
    if (of_camera.least_confidence) said["least-confidence"] = *of_camera.least_confidence;
    if (choice.alignment != DepthAlignment::automatic)
        said["align"] = choice.alignment == DepthAlignment::on ? "on" : "off";
    if (choice.fill_from_motion) said["fill-from-motion"] = true;
    if (said.empty()) return {};
    return said.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace touchable
