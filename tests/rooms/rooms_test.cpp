// Which room may use which: the table of docs/architecture.md, held against every folder, #include and linked
// target.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

using Names = std::set<std::string>;

struct Room {
    Names rooms;      ///< that it may use by itself, as folders from the root
    Names libraries;  ///< of others, as the table calls them
};

fs::path source(const fs::path& file) {
    return fs::path(TOUCHABLE_SOURCE_DIR) / file;
}

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string trimmed(const std::string& text) {
    const auto first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::vector<std::string> parts_of(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, separator);) parts.push_back(trimmed(part));
    return parts;
}

/// `engine/scene/` in backticks, as the table writes a room; empty: that is no room.
std::string folder_in(const std::string& cell) {
    const auto end = cell.find("/`");
    return cell.starts_with('`') && end != std::string::npos ? cell.substr(1, end - 1) : "";
}

std::map<std::string, Room> read_table() {
    std::map<std::string, Room> table;
    std::ifstream in(source("docs/architecture.md"));
    for (std::string line; std::getline(in, line);) {
        const auto cells = parts_of(line, '|');
        if (cells.size() < 4 || folder_in(cells[1]).empty()) continue;
        Room& room = table[folder_in(cells[1])];
        for (const std::string& name : parts_of(cells[3], ',')) {
            const std::string folder = folder_in(name);
            if (!name.empty())
                (folder.empty() ? room.libraries : room.rooms).insert(folder.empty() ? name : folder);
        }
    }
    return table;
}

const std::map<std::string, Room>& table() {
    static const auto read = read_table();
    return read;
}

/// A room, those that it may use, and those that these may.
Names reach_of(const std::string& room) {
    Names reached{room};
    for (const std::string& used : table().at(room).rooms) reached.merge(reach_of(used));
    return reached;
}

std::vector<fs::path> files_of(const std::string& room) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(source(room)))
        if (entry.is_regular_file()) files.push_back(entry.path());
    return files;
}

/// What stands between two marks in the lines that begin with the first one.
Names included_by(const fs::path& file, const std::string& begin, char end) {
    Names names;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
        if (line.starts_with(begin))
            names.insert(line.substr(begin.size(), line.find(end, begin.size()) - begin.size()));
    return names;
}

/// Whose a header is, by how its name begins; nothing: the machine's, or the language's.
std::string library_of_header(const std::string& header) {
    static const std::map<std::string, std::string> libraries{{"CLI/", "CLI11"},
                                                              {"GLFW/", "GLFW"},
                                                              {"X11/extensions/scrnsaver.h", "libXss"},
                                                              {"SDL.h", "SDL2"},
                                                              {"X11/", "X11"},
                                                              {"alsa/", "ALSA"},
                                                              {"backends/imgui", "Dear ImGui"},
                                                              {"bzlib.h", "bzip2"},
                                                              {"cairo.h", "cairo"},
                                                              {"fontconfig/", "fontconfig"},
                                                              {"glm/", "GLM"},
                                                              {"hidapi.h", "hidapi"},
                                                              {"imgui.h", "Dear ImGui"},
                                                              {"libav", "FFmpeg"},
                                                              {"libheif/", "libheif"},
                                                              {"libsw", "FFmpeg"},
                                                              {"libusb.h", "libusb"},
                                                              {"libwebsockets.h", "libwebsockets"},
                                                              {"lz4frame.h", "LZ4"},
                                                              {"nlohmann/", "nlohmann/json"},
                                                              {"openexr.h", "OpenEXR"},
                                                              {"pugixml.hpp", "pugixml"},
                                                              {"sqlite3.h", "SQLite"},
                                                              {"srt/", "libsrt"},
                                                              {"tiffio.h", "libtiff"},
                                                              {"vulkan/", "Vulkan"},
                                                              {"xxhash.h", "xxhash"},
                                                              {"zip.h", "libzip"},
                                                              {"zlib.h", "zlib"},
                                                              {"zstd.h", "zstd"}};
    for (const auto& [begin, library] : libraries)
        if (header.starts_with(begin)) return library;
    return "";
}

bool is_of_the_machine(const std::string& header) {
    static const Names files{"dlfcn.h", "fcntl.h",   "grp.h",  "link.h",   "malloc.h",   "netdb.h",
                             "poll.h",  "pthread.h", "pwd.h",  "sched.h",  "stddef.h",   "stdint.h",
                             "spawn.h", "termios.h", "time.h", "unistd.h", "emmintrin.h"};
    const bool is_standard = header.find_first_of("./") == std::string::npos;
    return is_standard || files.contains(header) || header.starts_with("sys/") ||
           header.starts_with("linux/") || header.starts_with("arpa/") || header.starts_with("netinet/");
}

TEST(Rooms, EachFolderIsInTheTable) {
    for (const std::string part : {"capi", "engine", "haptics_cpu", "device", "shaders", "player"})
        for (const auto& entry : fs::recursive_directory_iterator(source(part))) {
            const auto extension = entry.path().extension();
            if (extension != ".cpp" && extension != ".hpp" && extension != ".h") continue;
            const auto folder = fs::relative(entry.path().parent_path(), source(""));
            EXPECT_TRUE(table().contains(folder.string()))
                << entry.path() << ": docs/architecture.md does not know its folder";
        }
    EXPECT_GT(table().size(), 20u);
}

/// The list of where is what: names of files in backticks, without what they end in.
TEST(Rooms, FilesThatTheListNamesAreThere) {
    std::istringstream page(text_of(source("docs/architecture.md")));
    int named = 0;
    bool in_list = false;
    for (std::string line; std::getline(page, line);) {
        if (line.starts_with("## ")) in_list = line == "## Where is what";
        if (!in_list || !line.starts_with('|')) continue;
        const std::vector<std::string> quoted = parts_of(line, '`');
        for (std::size_t k = 1; k < quoted.size(); k += 2) {
            const std::string& name = quoted[k];
            if (name.find('/') == std::string::npos || name.ends_with('/')) continue;
            ++named;
            EXPECT_TRUE(fs::exists(source(name)) || fs::exists(source(name + ".cpp")) ||
                        fs::exists(source(name + ".hpp")))
                << name;
        }
    }
    EXPECT_GT(named, 150);
}

TEST(Rooms, IncludeOnlyWhatTheyMayUse) {
    int includes = 0;
    for (const auto& [room, own] : table()) {
        const Names reach = reach_of(room);
        for (const fs::path& file : files_of(room))
            for (const std::string& header : included_by(file, "#include \"", '"')) {
                const std::string used = fs::path(header).parent_path().string();
                ++includes;
                // A header that is installed is beside those that it includes.
                EXPECT_TRUE(used.empty() ? fs::exists(source(room) / header) : reach.contains(used))
                    << file << " includes " << header;
            }
    }
    EXPECT_GT(includes, 450) << "hardly anything was looked at";
}

TEST(Rooms, IncludeOnlyTheLibrariesOfTheirLine) {
    for (const auto& [room, own] : table())
        for (const fs::path& file : files_of(room))
            for (const std::string& header : included_by(file, "#include <", '>')) {
                const std::string library = library_of_header(header);
                EXPECT_TRUE(library.empty() ? is_of_the_machine(header) : own.libraries.contains(library))
                    << file << " includes " << header << ", "
                    << (library.empty() ? "which nobody knows" : library);
            }
}

/// The words of each target_link_libraries of a room, behind its own name.
std::vector<std::string> linked_by(const std::string& cmake) {
    std::vector<std::string> words;
    const std::string call = "target_link_libraries(";
    for (std::size_t at = cmake.find(call); at != std::string::npos; at = cmake.find(call, at + 1)) {
        std::istringstream in(cmake.substr(at + call.size(), cmake.find(')', at) - at - call.size()));
        std::string word;
        in >> word;  // the room's own
        while (in >> word)
            if (word != "PUBLIC" && word != "PRIVATE") words.push_back(word);
    }
    return words;
}

// A room that links another one's target compiles with all that is in it.
TEST(Rooms, LinkOnlyWhatTheyMayUse) {
    std::map<std::string, std::string> room_of_target;
    for (const auto& [room, own] : table()) {
        const std::string cmake = text_of(source(room) / "CMakeLists.txt"), call = "touchable_room(";
        const auto at = cmake.find(call);
        if (at == std::string::npos) continue;
        const auto begin = at + call.size();
        room_of_target["touchable_" + cmake.substr(begin, cmake.find_first_of(" \n", begin) - begin)] = room;
    }
    static const std::map<std::string, std::string> library_of_target{
        {"BZip2::BZip2", "bzip2"},
        {"CLI11::CLI11", "CLI11"},
        {"PkgConfig::ALSA", "ALSA"},
        {"PkgConfig::CAIRO", "cairo"},
        {"PkgConfig::FFMPEG", "FFmpeg"},
        {"PkgConfig::FONTCONFIG", "fontconfig"},
        {"PkgConfig::HEIF", "libheif"},
        {"PkgConfig::HIDAPI", "hidapi"},
        {"PkgConfig::IMGUI", "Dear ImGui"},
        {"PkgConfig::LIBUSB", "libusb"},
        {"PkgConfig::LZ4", "LZ4"},
        {"PkgConfig::OPENEXR", "OpenEXR"},
        {"PkgConfig::PUGIXML", "pugixml"},
        {"PkgConfig::SDL2", "SDL2"},
        {"PkgConfig::SRT", "libsrt"},
        {"PkgConfig::TIFF", "libtiff"},
        {"PkgConfig::WEBSOCKETS", "libwebsockets"},
        {"PkgConfig::XSS", "libXss"},
        {"PkgConfig::X_TOUCH", "X11"},
        {"PkgConfig::ZIP", "libzip"},
        {"PkgConfig::ZSTD", "zstd"},
        {"SQLite::SQLite3", "SQLite"},
        {"Vulkan::Vulkan", "Vulkan"},
        {"ZLIB::ZLIB", "zlib"},
        {"glfw", "GLFW"},
        {"glm::glm", "GLM"},
        {"nlohmann_json::nlohmann_json", "nlohmann/json"}};
    const Names of_the_machine{"Threads::Threads", "${CMAKE_DL_LIBS}"};
    std::size_t rooms = 0;
    for (const auto& [room, own] : table())
        for (const std::string& target : linked_by(text_of(source(room) / "CMakeLists.txt"))) {
            if (of_the_machine.contains(target)) continue;
            const auto used = room_of_target.find(target);
            const auto library = library_of_target.find(target);
            if (used != room_of_target.end()) {
                ++rooms;
                EXPECT_TRUE(reach_of(room).contains(used->second)) << room << " links " << target;
            } else {
                ASSERT_NE(library, library_of_target.end())
                    << room << " links " << target << ", which nobody knows";
                EXPECT_TRUE(own.libraries.contains(library->second)) << room << " links " << target;
            }
        }
    EXPECT_GT(rooms, 20u) << "hardly anything was looked at";
}

/// What stands between double quotes in a file, comments left out.
std::vector<std::string> literals_of(const std::string& code) {
    std::vector<std::string> literals;
    for (std::size_t at = 0; at < code.size(); ++at) {
        if (code.compare(at, 2, "//") == 0) at = std::min(code.find('\n', at), code.size());
        if (at >= code.size()) break;
        const char quote = code[at];
        const auto is_digit = [&](std::size_t n) {
            return std::isxdigit(static_cast<unsigned char>(code[n]));
        };
        const bool is_digit_mark =
            quote == '\'' && at > 0 && at + 1 < code.size() && is_digit(at - 1) && is_digit(at + 1);
        if ((quote != '"' && quote != '\'') || is_digit_mark) continue;
        const std::size_t begin = ++at;
        while (at < code.size() && code[at] != quote) at += code[at] == '\\' ? 2 : 1;
        if (quote == '"') literals.push_back(code.substr(begin, at - begin));
    }
    return literals;
}

/// Whether "--fov" or its like is in a text.
bool names_an_option(const std::string& text) {
    for (std::size_t at = text.find("--"); at != std::string::npos; at = text.find("--", at + 2))
        if (at + 2 < text.size() && std::islower(static_cast<unsigned char>(text[at + 2]))) return true;
    return false;
}

TEST(Rooms, LiteralsAreFoundInCode) {
    EXPECT_EQ(literals_of("f(\"a\\\"b\");  // \"no\"\nconstexpr int k = 1'000; g('\"', L' ', \"--fov\");"),
              (std::vector<std::string>{"a\\\"b", "--fov"}));
    EXPECT_TRUE(names_an_option("with --fov"));
    EXPECT_FALSE(names_an_option("a -- b, --, -f"));
}

// A library has no command line: an error or a guess there hints at a `Setting`, and
// player/options/setting_words.cpp knows its option.
TEST(Rooms, OnlyTheCommandLineNamesOptions) {
    const Names of_the_command_line{"player", "player/options", "player/check", "player/commands"};
    const std::map<std::string, std::string> allowed{
        {"engine/camera/video_system.cpp", "udevadm's"},
        {"device/catalog/udev_rules.hpp", "udevadm's, behind the command that prints the rules"}};
    std::size_t literals = 0;
    for (const auto& [room, own] : table()) {
        if (of_the_command_line.contains(room)) continue;
        for (const fs::path& file : files_of(room)) {
            if (file.extension() != ".cpp" && file.extension() != ".hpp") continue;
            if (allowed.contains(fs::relative(file, source("")).string())) continue;
            for (const std::string& literal : literals_of(text_of(file))) {
                ++literals;
                EXPECT_FALSE(names_an_option(literal)) << file << ": \"" << literal << '"';
            }
        }
    }
    EXPECT_GT(literals, 5000u) << "hardly anything was looked at";
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
    for (const auto& [room, own] : table()) {
        const Names of_player{"player/run", "player/record", "player/session"};
        if (room.starts_with("player") && !of_player.contains(room)) continue;
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
