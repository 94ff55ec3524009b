// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/base/result.hpp"
#include "engine/content/scenes.hpp"

namespace touchable::test {

// The program's steps before and after a session, by the rooms of a session alone: so ThreadSanitizer sees
// its threads without a build of the program.

/// As `touchable make`: a clip of a generated scene, over an earlier one.
Result<void> write_generated_clip(const std::string& scene, const std::filesystem::path& file,
                                  const SceneOptions& options, int frames);

/// As `touchable touch --replay`: an error where the recording cannot be read, or a force or a frame is
/// another than the recorded one.
Result<void> replay_in_process(const std::filesystem::path& recording);

}  // namespace touchable::test
