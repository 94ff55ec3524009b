// Which room may use which: the table of docs/architecture.md, held against every #include. (A header that is
// whole in itself would link from anywhere.)
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

using Rooms = std::set<std::string>;

const std::map<std::string, Rooms> may_use{
    {"engine", {}},
    {"engine/scene", {"engine"}},
    {"engine/frame", {"engine", "engine/scene", "shaders"}},
    {"engine/media", {"engine", "engine/scene", "engine/frame"}},
    {"engine/import", {"engine", "engine/scene", "engine/frame", "engine/media"}},
    {"engine/camera", {"engine", "engine/scene", "engine/frame", "engine/media", "engine/import"}},
    {"engine/surface", {"engine", "engine/scene", "engine/frame", "engine/gpu", "shaders"}},
    {"engine/content", {"engine", "engine/scene", "engine/frame"}},
    {"engine/gpu", {"engine"}},
    {"haptics_cpu", {"engine", "engine/scene", "engine/frame"}},
    {"device", {"engine"}},
    {"device/inverse3", {"engine", "device"}},
    {"device/network", {"engine", "device"}},
    {"device/falcon", {"engine", "device"}},
    {"device/recorded", {"engine", "device"}},
    {"device/catalog",
     {"engine", "device", "device/falcon", "device/inverse3", "device/network", "device/recorded"}},
    {"shaders", {}},
    {"player/view",
     {"engine", "engine/scene", "engine/frame", "engine/media", "engine/surface", "engine/gpu", "haptics_cpu",
      "shaders"}},
    {"player/session",
     {"engine", "engine/scene", "engine/frame", "engine/media", "engine/import", "engine/camera",
      "engine/surface", "engine/gpu", "haptics_cpu", "device"}},
    {"player/window",
     {"engine", "engine/scene", "engine/frame", "engine/media", "engine/import", "engine/camera",
      "engine/surface", "engine/gpu", "haptics_cpu", "device", "player/session", "player/view"}},
    {"player/commands",
     {"engine", "engine/scene", "engine/frame", "engine/media", "engine/import", "engine/camera",
      "engine/surface", "engine/content", "engine/gpu", "haptics_cpu", "device", "device/catalog", "shaders",
      "player/session", "player/view", "player/window"}}};

/// The folders of what a file includes from the root.
Rooms used_by(const fs::path& file) {
    Rooms rooms;
    std::ifstream in(file);
    const std::string include = "#include \"";
    for (std::string line; std::getline(in, line);)
        if (line.starts_with(include))
            rooms.insert(fs::path(line.substr(include.size())).parent_path().string());
    return rooms;
}

TEST(Rooms, IncludeOnlyWhatTheyMayUse) {
    int includes = 0;
    for (const auto& [room, allowed] : may_use)
        for (const auto& entry : fs::directory_iterator(fs::path(TOUCHABLE_SOURCE_DIR) / room)) {
            if (!entry.is_regular_file()) continue;
            for (const std::string& used : used_by(entry.path())) {
                ++includes;
                EXPECT_TRUE(used == room || allowed.contains(used)) << entry.path() << " includes " << used;
            }
        }
    EXPECT_GT(includes, 450) << "hardly anything was looked at";
}

}  // namespace
}  // namespace touchable::test
