#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "engine/scene/scene.hpp"
#include "player/options/word_option.hpp"

namespace touchable {

/// --terraces, instead of the scene's own.
inline CLI::Option* add_terrace_option(CLI::App& sub, std::optional<TerraceRemoval>& terraces) {
    const Words<TerraceRemoval> words{
        {"off", TerraceRemoval::off}, {"on", TerraceRemoval::on}, {"auto", TerraceRemoval::automatic}};
    return add_word_option(
        sub, "--terraces", terraces,
        "remove those of coarse depth, instead of the scene's: off, on, or auto (where kappa "
        "says that it helps; see touchable info)",
        words);
}

}  // namespace touchable
