#include "player/draw/drawn_vertex.hpp"

#include <algorithm>

#include "shaders/blend_rule.h"

namespace touchable {

float blend_reach(const HeightField& field) {
    const auto longest = static_cast<double>(BLEND_RULE_SECONDS);
    const double seconds = std::min(field.frame_interval().value_or(longest), longest);
    return static_cast<float>(static_cast<double>(BLEND_RULE_SPEED) * seconds /
                              field.scene().metres_per_unit);
}

bool are_mixed(const HeightField& field, const FieldVertex& prev, const FieldVertex& next) {
    return prev.valid && next.valid &&
           depths_mix(static_cast<float>(prev.depth), static_cast<float>(next.depth), blend_reach(field));
}

FieldVertex drawn_vertex(const HeightField& field, std::int64_t i, std::int64_t j) {
    const auto [prev, next] = field.vertices_of_frames(i, j);
    if (are_mixed(field, prev, next)) return {prev.depth + (next.depth - prev.depth) * field.blend(), true};
    return field.blend() >= 0.5 ? next : prev;
}

}  // namespace touchable
