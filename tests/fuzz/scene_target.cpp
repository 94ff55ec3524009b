#include <nlohmann/json.hpp>

#include "engine/scene/checked_json.hpp"
#include "engine/scene/scene.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// What was read, written and read again is the same.
bool parse_scene_file(std::string_view bytes) {
    const auto scene = parse_scene(bytes, "scene.json");
    if (!is_taken(scene)) {
        require(scene.error().message.starts_with("scene.json"), "a scene is refused without its name");
        return false;
    }
    require(bool(validate(*scene)), "a scene that was read cannot be");
    const std::string text = scene_to_json(*scene);
    const auto again = parse_scene(text, "again");
    require(bool(again), again ? "" : "a scene that was written is refused: " + again.error().message);
    require(scene_to_json(*again) == text, "a scene is another one when it is read again");
    return true;
}

bool parse_json(std::string_view bytes) {
    try {
        const auto value = checked_json::parse(bytes);
        require(nlohmann::json::accept(bytes), "what is taken is no JSON");
        require(checked_json::parse(value.dump()) == value, "JSON is another when it is read again");
        return true;
    } catch (const checked_json::Refusal& refusal) {
        require_readable(input_error(refusal.message));
        require(refusal.message.find("line ") != std::string::npos, "JSON is refused without the line");
        return false;
    }
}

const Registered scene_target{{.name = "scene",
                               .parse = parse_scene_file,
                               .cuts_are_refused = true,
                               .changes = 600,
                               .most_bytes = 8192}};
const Registered json_target{{.name = "json", .parse = parse_json}};

}  // namespace
}  // namespace touchable::fuzz
