#include "player/commands/filter_facts.hpp"

#include "player/session/filter_words.hpp"

namespace touchable {

using Json = nlohmann::ordered_json;

Json to_json(const std::optional<MeasuredDepth>& measured) {
    if (!measured) return nullptr;
    const auto length = [](const DepthLength& value) { return Json{value.constant, value.quadratic}; };
    return {{"median_depth", measured->median},
            {"pixel_width", measured->pixel},
            {"levels", length(measured->levels)},
            {"level_distance", measured->distance},
            {"kappa", measured->kappa},
            {"noise", length(measured->noise)},
            {"noise_at_median", measured->noise_at_median()},
            {"noise_at_edges", measured->noise_at_edges},
            {"noise_at_rims", measured->noise_at_rims},
            {"roughness", measured->roughness},
            {"dropouts", measured->dropouts},
            {"specks", measured->specks},
            {"flying", measured->flying},
            {"from_a_camera", measured->from_a_camera()}};
}

Json filters_json(const Scene& scene, const std::optional<ChosenFilters>& chosen) {
    const FilterSettings& filter = scene.filter;
    Json out{{"median", filter.median},
             {"fill_holes", filter.fill_holes},
             {"terraces", filter.terraces == TerraceRemoval::on},
             {"temporal", filter.temporal},
             {"temporal_noise", {filter.temporal_noise.constant, filter.temporal_noise.quadratic}}};
    out["flying_pixels"] = {filter.flying_pixels.constant, filter.flying_pixels.quadratic};
    out["in_words"] = filters_in_words(scene, chosen);
    if (!chosen) return out;
    const auto names = {std::pair{"median", chosen->chosen.median},
                        {"fill_holes", chosen->chosen.fill_holes},
                        {"terraces", chosen->chosen.terraces},
                        {"temporal", chosen->chosen.temporal},
                        {"flying_pixels", chosen->chosen.flying_pixels}};
    out["chosen"] = Json::array();
    for (const auto& [name, is_chosen] : names)
        if (is_chosen) out["chosen"].push_back(name);
    out["measured"] = to_json(chosen->measured);
    return out;
}

}  // namespace touchable
