#include "player/session/measured_filter.hpp"

#include <sstream>

#include "engine/scene/terraces.hpp"

namespace touchable {

std::string MeasuredDepth::in_words() const {
    std::ostringstream words;
    words.precision(3);
    words << "levels " << 1000 * distance * metres_per_unit << " mm apart at " << median * metres_per_unit
          << " m (kappa " << kappa << ")";
    return words.str();
}

std::optional<MeasuredDepth> measured_depth(const DepthSurvey& survey, const Scene& scene) {
    const auto median = survey.median_depth();
    if (!median) return std::nullopt;
    Scene measured = scene;
    if (measured.filter.levels == DepthLength{}) measured.filter.levels = survey.levels();
    const double kappa = kappa_of_depth(measured, *median);
    return MeasuredDepth{scene.metres_per_unit,
                         *median,
                         measured.filter.levels,
                         level_distance(measured, *median),
                         kappa,
                         terrace_scale(measured) && kappa >= kappa_of_terraces};
}

Result<std::optional<MeasuredDepth>> measure_depth(ClipReader& reader, const Scene& scene) {
    DepthSurvey survey(scene);
    for (int k = 0; k < DepthSurvey::frames; ++k) {
        const auto frame = reader.next();
        if (!frame.ok()) return frame.error();
        if (!*frame) break;
        survey.add(**frame);
    }
    if (auto back = reader.rewind(); !back.ok()) return back.error();
    return measured_depth(survey, scene);
}

Result<std::optional<std::string>> settle_terraces(ClipReader& reader, Scene& scene) {
    FilterSettings& filter = scene.filter;
    if (filter.terraces == TerraceRemoval::off) return std::optional<std::string>();
    const auto measured = measure_depth(reader, scene);
    if (!measured.ok()) return measured.error();
    if (!*measured) {
        if (filter.terraces == TerraceRemoval::automatic) filter.terraces = TerraceRemoval::off;
        return std::optional<std::string>();
    }
    if (filter.terraces == TerraceRemoval::automatic)
        filter.terraces = (*measured)->advised ? TerraceRemoval::on : TerraceRemoval::off;
    const bool on = filter.terraces == TerraceRemoval::on;
    if (on) filter.levels = (*measured)->levels;
    if (auto valid = validate(scene); !valid.ok()) return usage_error(valid.error().message);
    return std::optional("terraces " + std::string(on ? "removed: " : "left: ") + (*measured)->in_words());
}

}  // namespace touchable
