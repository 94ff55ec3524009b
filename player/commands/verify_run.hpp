#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "player/commands/clip_facts.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// Where findings are to be drawn.
struct VerifyPicture {
    std::optional<std::filesystem::path> file;
    Existing existing = Existing::keep;
};

/// A finding as it is told.
struct NamedFinding {
    std::string name, what, mend;
    std::string colour;  ///< of its marks in the picture; empty: it has none there
};

/// What was found, and the measures by which it was decided.
struct Verified {
    std::vector<NamedFinding> findings;
    bool drawn = false;  ///< into a picture
    nlohmann::ordered_json measures;
    std::string measures_in_words;
};

/// Reads the whole clip for what would feel wrong (findings_of), and draws where.
Result<Verified> verify_clip(const ClipChoice& choice, const ClipFacts& facts, const VerifyPicture& picture);

/// Lines after the clip's facts.
std::string verified_in_words(const Verified& verified);
/// Adds `findings` and `measures`.
void add_verified(const Verified& verified, nlohmann::ordered_json& json);

}  // namespace touchable
