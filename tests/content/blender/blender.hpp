#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace touchable::test {

/// Whether there is a Blender to run.
bool has_blender();

/// What a run of Blender left behind.
struct BlenderRun {
    int code = -1;            ///< exit code; -signal where it died of one
    std::string told, error;  ///< lines of `touchable: ...` on standard output, and on standard error
};

/// Runs Blender without a window, with Python files one after the other, and words behind "--". `environment`
/// has lines NAME=value. Sends SIGINT once that `is_enough`.
BlenderRun run_blender(const std::vector<std::filesystem::path>& scripts,
                       const std::vector<std::string>& words, const std::vector<std::string>& environment,
                       const std::function<bool()>& is_enough = nullptr);

/// Exports the scene of test_scenes.py that has this name.
BlenderRun export_scene(const std::string& scene, const std::vector<std::string>& words,
                        const std::function<bool()>& is_enough = nullptr);

}  // namespace touchable::test
