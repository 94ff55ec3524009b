#include "player/commands/filter_facts.hpp"

#include <utility>

#include "player/session/filter_words.hpp"

namespace touchable {

using Json = nlohmann::ordered_json;

namespace {

Json length(const DepthLength& value) {
    return {value.constant, value.quadratic};
}

/// What filters leave on smooth places of the clip.
Json tried_json(const std::vector<TriedFilters>& tried) {
    Json out = Json::array();
    for (const TriedFilters& one : tried) {
        Json filters{{"temporal", one.temporal}, {"median", one.median}, {"terraces", one.terraces}};
        if (one.terraces) filters["levels"] = length(one.levels);
        filters["left_degrees"] = one.left_deg;
        out.push_back(std::move(filters));
    }
    return out;
}

Json measured_json(const MeasuredDepth& measured) {
    return {{"median_depth", measured.median},
            {"pixel_width", measured.pixel},
            {"levels", length(measured.levels)},
            {"level_distance", measured.distance},
            {"kappa", measured.kappa},
            {"contour_width", measured.contours.width},
            {"contour_height", measured.contours.height},
            {"noise", length(measured.noise)},
            {"noise_at_median", measured.noise_at_median()},
            {"noise_at_edges", measured.noise_at_edges},
            {"noise_at_rims", measured.noise_at_rims},
            {"roughness", measured.roughness},
            {"dropouts", measured.dropouts},
            {"tiny_holes", measured.tiny_holes},
            {"flying", measured.flying},
            {"midway", measured.midway},
            {"clean_edges", measured.clean_edges},
            {"from_a_camera", measured.from_a_camera()},
            {"tried", tried_json(measured.tried)}};
}

}  // namespace

Json filters_json(const Scene& scene, const std::optional<ChosenFilters>& chosen,
                  const std::optional<MeasuredDepth>& measured) {
    const FilterSettings& filter = scene.filter;
    Json out{{"median", filter.median},
             {"fill_holes", filter.fill_holes},
             {"terraces", filter.terraces == TerraceRemoval::on},
             {"levels", length(filter.levels)},
             {"terrace_noise", filter.terrace_noise},
             {"terrace_reach", filter.terrace_reach},
             {"temporal", filter.temporal},
             {"temporal_noise", length(filter.temporal_noise)}};
    out["flying_pixels"] = length(filter.flying_pixels);
    out["in_words"] = filters_in_words(scene, chosen);
    if (measured) out["measured"] = measured_json(*measured);
    if (!chosen) return out;
    const auto names = {std::pair{"median", chosen->chosen.median},
                        {"fill_holes", chosen->chosen.fill_holes},
                        {"terraces", chosen->chosen.terraces},
                        {"terrace_reach", filter.terraces == TerraceRemoval::on &&
                                              chosen->chosen.terrace_reach && !chosen->chosen.terraces},
                        {"temporal", chosen->chosen.temporal},
                        {"flying_pixels", chosen->chosen.flying_pixels}};
    out["chosen"] = Json::array();
    for (const auto& [name, is_chosen] : names)
        if (is_chosen) out["chosen"].push_back(name);
    return out;
}

}  // namespace touchable
