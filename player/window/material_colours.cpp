#include "player/window/material_colours.hpp"

#include <utility>

namespace touchable {
namespace {

using Rgb = std::array<std::uint8_t, 3>;
constexpr std::pair<std::string_view, Rgb> colours_of_materials[] = {
    {"wood", {186, 128, 66}},       {"metal", {132, 152, 186}},  {"glass", {112, 222, 226}},
    {"ceramic", {238, 232, 226}},   {"plastic", {238, 84, 130}}, {"paper", {250, 244, 160}},
    {"cardboard", {206, 176, 130}}, {"cloth", {128, 108, 214}},  {"felt", {40, 130, 112}},
    {"leather", {118, 58, 32}},     {"rubber", {66, 66, 78}},    {"foam", {255, 204, 84}},
    {"cork", {232, 140, 46}},       {"skin", {250, 184, 164}},   {"stone", {140, 140, 128}},
    {"brick", {198, 62, 44}},       {"carpet", {166, 52, 156}},  {"fur", {222, 198, 232}},
    {"grass", {96, 186, 52}},       {"water", {38, 110, 232}}};

}  // namespace

std::array<std::uint8_t, 3> material_colour(std::string_view name) {
    for (const auto& [material, colour] : colours_of_materials)
        if (name == material) return colour;
    return {170, 170, 170};
}

}  // namespace touchable
