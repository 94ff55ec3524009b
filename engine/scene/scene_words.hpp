#pragma once

#include <utility>

#include "engine/scene/scene.hpp"

/// What members of a scene file can be, in its words: read and written by the same tables.
namespace touchable::scene_words {

/// What `depth.coding` can be: a coding of codes, or of what the frames settle to be one.
struct Coding {
    DepthCodingKind kind;
    StoredDepth::Kind stored = StoredDepth::Kind::codes;
    bool operator==(const Coding&) const = default;
};
inline constexpr std::pair<const char*, Coding> coding_names[] = {
    {"linear", {DepthCodingKind::linear}},
    {"inverse", {DepthCodingKind::inverse}},
    {"metric", {DepthCodingKind::metric}},
    {"hue", {DepthCodingKind::hue}},
    {"log", {DepthCodingKind::log}},
    {"disparity", {DepthCodingKind::inverse, StoredDepth::Kind::disparity}},
    {"relative", {DepthCodingKind::linear, StoredDepth::Kind::relative}},
    {"relative-inverse", {DepthCodingKind::inverse, StoredDepth::Kind::relative}}};
inline constexpr std::pair<const char*, bool> byte_order_names[] = {{"plain", false}, {"swapped", true}};
inline constexpr std::pair<const char*, DepthSemantics> semantics_names[] = {
    {"range", DepthSemantics::range}, {"planar", DepthSemantics::planar}};
inline constexpr std::pair<const char*, bool> near_is_high_names[] = {{"high", true}, {"low", false}};
inline constexpr std::pair<const char*, HeightUnits> unit_names[] = {{"levels", HeightUnits::levels},
                                                                     {"world", HeightUnits::world}};
inline constexpr std::pair<const char*, FrameInterpolation> interpolation_names[] = {
    {"hold", FrameInterpolation::hold}, {"linear", FrameInterpolation::linear}};
inline constexpr std::pair<const char*, VideoLayout> layout_names[] = {{"alone", VideoLayout::alone},
                                                                       {"left", VideoLayout::left},
                                                                       {"right", VideoLayout::right},
                                                                       {"top", VideoLayout::top},
                                                                       {"bottom", VideoLayout::bottom}};
inline constexpr std::pair<const char*, VideoValues> value_names[] = {
    {"grey", VideoValues::grey}, {"mean", VideoValues::mean}, {"hue", VideoValues::hue}};

inline constexpr std::pair<const char*, bool> temporal_names[] = {{"off", false}, {"on", true}};
inline constexpr std::pair<const char*, TerraceRemoval> terrace_names[] = {
    {"off", TerraceRemoval::off}, {"on", TerraceRemoval::on}, {"auto", TerraceRemoval::automatic}};

}  // namespace touchable::scene_words
