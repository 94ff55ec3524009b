// Which room may use which: the table of docs/architecture.md, held against every #include. (A header that is
// whole in itself would link from anywhere.)
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
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
     {"engine", "device", "device/falcon", "device/hid", "device/inverse3", "device/network",
      "device/recorded"}},
    {"device/hid", {"engine", "engine/scene", "device"}},
    {"device/measure", {"engine", "device"}},
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
      "engine/surface", "engine/content", "engine/gpu", "haptics_cpu", "device", "device/catalog",
      "device/measure", "shaders", "player/session", "player/view", "player/window"}}};

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

/// The words behind each `std::` or `glm::` of a line of code.
std::set<std::string> library_words(std::string line) {
    line.resize(std::min(line.size(), line.find("//")));
    std::set<std::string> words;
    for (const std::string from : {"std::", "glm::"})
        for (std::size_t at = line.find(from); at != std::string::npos; at = line.find(from, at)) {
            const std::size_t begin = at += from.size();
            while (at < line.size() &&
                   (std::isalnum(static_cast<unsigned char>(line[at])) || line[at] == '_'))
                ++at;
            words.insert(line.substr(begin, at - begin));
        }
    return words;
}

// The C library's may round otherwise on another machine (docs/architecture.md, decision 3);
// engine/trigonometry.hpp has some that do not.
TEST(Rooms, WhatReachesACodeOrAForceCallsNothingThatALibraryRounds) {
    const std::set<std::string> rounded{
        "sin",  "cos",    "tan",    "asin",  "acos",   "atan",      "atan2", "sinh",
        "cosh", "tanh",   "asinh",  "acosh", "atanh",  "exp",       "exp2",  "expm1",
        "log",  "log2",   "log10",  "log1p", "pow",    "cbrt",      "hypot", "erf",
        "erfc", "tgamma", "lgamma", "fma",   "rotate", "angleAxis", "slerp", "perspective"};
    int files = 0;
    for (const auto& [room, allowed] : may_use) {
        if (room.starts_with("player") && room != "player/session") continue;
        for (const auto& entry : fs::directory_iterator(fs::path(TOUCHABLE_SOURCE_DIR) / room)) {
            // Which compares forces that were written down, for a person.
            if (!entry.is_regular_file() || entry.path().filename() == "force_comparison.cpp") continue;
            std::ifstream in(entry.path());
            ++files;
            for (std::string line; std::getline(in, line);)
                for (const std::string& word : library_words(line))
                    EXPECT_FALSE(rounded.contains(word)) << entry.path() << ": " << line;
        }
    }
    EXPECT_GT(files, 300) << "hardly anything was looked at";
}

}  // namespace
}  // namespace touchable::test
