#pragma once

#include <string>
#include <vector>

#include "player/commands/clip_facts.hpp"
#include "player/commands/verify_run.hpp"

namespace touchable {

/// What somebody who wants to touch a clip should do next, in one line: "good to touch: touchable play CLIP",
/// or the one thing that would help most. With what reading all of it found, if that was done.
std::string verdict_on(const ClipFacts& facts, const std::vector<NamedFinding>* findings);

}  // namespace touchable
