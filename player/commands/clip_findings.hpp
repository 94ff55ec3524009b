#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/authoring/clip_quality.hpp"
#include "engine/picture/image_file.hpp"
#include "player/commands/clip_facts.hpp"

namespace touchable {

/// Something of a clip that would feel wrong.
struct Finding {
    std::string name;  ///< one word, for a program: "registration"
    std::string what;  ///< for a person, with its figures
    std::string mend;  ///< what helps: a command, or where there is none what to do
    /// Pixels of the first frame, 1 where it is; nothing: it has no place.
    const std::vector<std::uint8_t>* where = nullptr;
};

/// All that is found, in the order in which it matters for a hand. `where` points into `quality`.
std::vector<Finding> findings_of(const ClipFacts& facts, const ClipQuality& quality);

/// The first frame, darkened, with the places of findings in their colours.
Image picture_of(const std::vector<Finding>& findings, const Image& first_frame);
/// "red": of the k-th finding; empty where the first frame shows nothing of it.
std::string colour_of(const std::vector<Finding>& findings, std::size_t k);

}  // namespace touchable
