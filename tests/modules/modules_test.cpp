// SPDX-License-Identifier: Apache-2.0
// The rules of docs/architecture.md on modules, checked against every folder, #include and linked target: a
// module's CMakeLists.txt says which others it uses, and which of its headers these may include.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

using Names = std::set<std::string>;

struct Module {
    std::string folder;  ///< from the root
    Names headers;       ///< that other modules may include
    Names uses;          ///< names of modules
    Names libraries;     ///< CMake targets of others
};

fs::path source(const fs::path& file) {
    return fs::path(TOUCHABLE_SOURCE_DIR) / file;
}

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// The words of each call of a CMake function in a text, without what stands in quotes.
std::vector<std::vector<std::string>> calls_of(const std::string& function, const std::string& cmake) {
    std::vector<std::vector<std::string>> calls;
    for (auto at = cmake.find(function + '('); at != std::string::npos;
         at = cmake.find(function + '(', at + 1)) {
        const auto begin = at + function.size() + 1;
        std::istringstream in(cmake.substr(begin, cmake.find(')', begin) - begin));
        calls.emplace_back(std::istream_iterator<std::string>(in), std::istream_iterator<std::string>());
    }
    return calls;
}

const std::vector<std::string> kProduct{"capi", "engine", "haptics_cpu", "device", "player"};

std::map<std::string, Module> read_modules() {
    std::map<std::string, Module> modules;
    for (const std::string& part : kProduct)
        for (const auto& entry : fs::recursive_directory_iterator(source(part))) {
            if (entry.path().filename() != "CMakeLists.txt") continue;
            const std::string cmake = text_of(entry.path());
            for (const auto& words : calls_of("touchable_module", cmake)) {
                Module& module = modules[words.at(0)];
                module.folder = fs::relative(entry.path().parent_path(), source("")).string();
                Names* into = nullptr;
                for (auto word = words.begin() + 1; word != words.end(); ++word) {
                    if (*word == "HEADERS")
                        into = &module.headers;
                    else if (*word == "USES")
                        into = &module.uses;
                    else if (*word == "LIBRARIES" || *word == "PUBLIC_LIBRARIES")
                        into = &module.libraries;
                    else if (*word == "SOURCES" || *word == "WITHOUT" || *word == "OPTIMISED")
                        into = nullptr;
                    else if (into)
                        into->insert(*word);
                }
            }
            // Libraries that a module links only where the machine has them.
            for (const auto& words : calls_of("target_link_libraries", cmake))
                if (words.at(0).starts_with("touchable_"))
                    if (const auto module = modules.find(words[0].substr(std::string("touchable_").size()));
                        module != modules.end())
                        module->second.libraries.insert(words.begin() + 2, words.end());
        }
    return modules;
}

const std::map<std::string, Module>& modules() {
    static const auto read = read_modules();
    return read;
}

/// A module, those that it uses, and those that these use.
Names reach_of(const std::string& name) {
    Names reached{name};
    for (const std::string& used : modules().at(name).uses) reached.merge(reach_of(used));
    return reached;
}

/// The same of all modules of a folder: `capi` has three.
Names reach_of_folder(const std::string& folder) {
    Names reached;
    for (const auto& [name, module] : modules())
        if (module.folder == folder) reached.merge(reach_of(name));
    return reached;
}

std::vector<fs::path> files_of(const Module& module) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(source(module.folder)))
        if (entry.is_regular_file()) files.push_back(entry.path());
    return files;
}

/// The text between two marks in the lines that begin with the first one.
Names included_by(const fs::path& file, const std::string& begin, char end) {
    Names names;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
        if (line.starts_with(begin))
            names.insert(line.substr(begin.size(), line.find(end, begin.size()) - begin.size()));
    return names;
}

/// The CMake target whose a header is, by how its name begins; nothing: the machine's, or the language's.
std::string library_of_header(const std::string& header) {
    static const std::map<std::string, std::string> libraries{
        {"CLI/", "CLI11::CLI11"},
        {"GLFW/", "glfw"},
        {"SDL.h", "PkgConfig::SDL2"},
        {"X11/extensions/XInput2.h", "PkgConfig::X_TOUCH"},
        {"X11/extensions/scrnsaver.h", "PkgConfig::XSS"},
        {"alsa/", "PkgConfig::ALSA"},
        {"backends/imgui", "PkgConfig::IMGUI"},
        {"bzlib.h", "BZip2::BZip2"},
        {"cairo.h", "PkgConfig::CAIRO"},
        {"fontconfig/", "PkgConfig::FONTCONFIG"},
        {"glm/", "glm::glm"},
        {"hidapi.h", "PkgConfig::HIDAPI"},
        {"imgui.h", "PkgConfig::IMGUI"},
        {"libav", "PkgConfig::FFMPEG"},
        {"libheif/", "PkgConfig::HEIF"},
        {"libsw", "PkgConfig::FFMPEG"},
        {"libusb.h", "PkgConfig::LIBUSB"},
        {"libwebsockets.h", "PkgConfig::WEBSOCKETS"},
        {"lz4frame.h", "PkgConfig::LZ4"},
        {"nlohmann/", "nlohmann_json::nlohmann_json"},
        {"openexr.h", "PkgConfig::OPENEXR"},
        {"pugixml.hpp", "PkgConfig::PUGIXML"},
        {"sqlite3.h", "SQLite::SQLite3"},
        {"srt/", "PkgConfig::SRT"},
        {"tiffio.h", "PkgConfig::TIFF"},
        {"vulkan/", "Vulkan::Vulkan"},
        {"zip.h", "PkgConfig::ZIP"},
        {"zlib.h", "ZLIB::ZLIB"},
        {"zstd.h", "PkgConfig::ZSTD"}};
    for (const auto& [begin, library] : libraries)
        if (header.starts_with(begin)) return library;
    return "";
}

/// A header of the language, the compiler, the system, X11 (which two optional libraries bring), or xxhash,
/// which base alone has.
bool is_of_the_machine(const std::string& header) {
    static const Names files{"dirent.h",  "dlfcn.h", "fcntl.h",  "grp.h",       "link.h",
                             "malloc.h",  "math.h",  "netdb.h",  "poll.h",      "pthread.h",
                             "pwd.h",     "sched.h", "stddef.h", "stdint.h",    "spawn.h",
                             "termios.h", "time.h",  "unistd.h", "emmintrin.h", "xxhash.h"};
    const bool is_standard = header.find_first_of("./") == std::string::npos;
    return is_standard || files.contains(header) || header.starts_with("sys/") ||
           header.starts_with("X11/") || header.starts_with("linux/") || header.starts_with("arpa/") ||
           header.starts_with("netinet/") || header.starts_with("sanitizer/");
}

bool is_code(const fs::path& file) {
    return file.extension() == ".cpp" || file.extension() == ".hpp" || file.extension() == ".h";
}

TEST(Modules, CoverEachProductFile) {
    Names folders;
    for (const auto& [name, module] : modules()) folders.insert(module.folder);
    for (const std::string& part : kProduct)
        for (const auto& entry : fs::recursive_directory_iterator(source(part)))
            if (is_code(entry.path())) {
                EXPECT_TRUE(folders.contains(fs::relative(entry.path().parent_path(), source("")).string()))
                    << entry.path() << " is in no module's folder";
            }
    EXPECT_GT(folders.size(), 15u);
}

TEST(Modules, StateThreadsInPublicHeaders) {
    for (const auto& [name, module] : modules())
        for (const std::string& header : module.headers)
            EXPECT_NE(text_of(source(module.folder) / header).find("\n// Threads: "), std::string::npos)
                << module.folder << '/' << header << " is not there, or does not say what threads may use";
}

TEST(Modules, IncludeOnlyPublicHeaders) {
    std::map<std::string, std::string> of_folder;
    for (const auto& [name, module] : modules())
        if (!module.folder.starts_with("capi")) of_folder[module.folder] = name;
    std::map<std::string, Names> included;
    int includes = 0;
    for (const auto& [name, module] : modules()) {
        const Names reach = reach_of_folder(module.folder);
        for (const fs::path& file : files_of(module))
            for (const std::string& header : included_by(file, "#include \"", '"')) {
                const std::string folder = fs::path(header).parent_path().string();
                ++includes;
                if (folder == "shaders" || folder == module.folder) continue;
                if (folder.empty()) {  // a header that is installed, beside those that it includes
                    EXPECT_TRUE(fs::exists(source(module.folder) / header)) << file << " includes " << header;
                    continue;
                }
                const auto used = of_folder.find(folder);
                ASSERT_NE(used, of_folder.end()) << file << " includes " << header;
                EXPECT_TRUE(reach.contains(used->second))
                    << file << " includes " << header << ", and " << name << " does not use " << used->second;
                const std::string file_name = fs::path(header).filename().string();
                EXPECT_TRUE(modules().at(used->second).headers.contains(file_name))
                    << file << " includes " << header << ", which is private to " << used->second;
                included[used->second].insert(file_name);
            }
    }
    EXPECT_GT(includes, 450) << "hardly anything was looked at";
    for (const auto& [name, module] : modules())
        for (const std::string& header : module.headers)
            EXPECT_TRUE(included[name].contains(header))
                << "no other module includes " << module.folder << '/' << header;
}

TEST(Modules, IncludeOnlyLinkedLibraries) {
    for (const auto& [name, module] : modules()) {
        Names linked;
        for (const std::string& reached : reach_of(name))
            linked.insert(modules().at(reached).libraries.begin(), modules().at(reached).libraries.end());
        for (const fs::path& file : files_of(module))
            for (const std::string& header : included_by(file, "#include <", '>')) {
                const std::string library = library_of_header(header);
                // GLM and JSON come with the modules that show them in headers.
                const bool comes_along = library == "glm::glm" || library == "nlohmann_json::nlohmann_json" ||
                                         library == "Vulkan::Vulkan" || library == "CLI11::CLI11";
                EXPECT_TRUE(library.empty() ? is_of_the_machine(header)
                                            : (comes_along ? linked : module.libraries).contains(library))
                    << file << " includes " << header << ", and " << name << " does not link "
                    << (library.empty() ? "a library that is known here" : library);
            }
    }
}
/// The literals between double quotes in a file, without comments.
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
    static const std::regex option("--[a-z]");
    return std::regex_search(text, option);
}

TEST(Modules, LiteralsAreFoundInCode) {
    EXPECT_EQ(literals_of("f(\"a\\\"b\");  // \"no\"\nconstexpr int k = 1'000; g('\"', L' ', \"--fov\");"),
              (std::vector<std::string>{"a\\\"b", "--fov"}));
    EXPECT_TRUE(names_an_option("with --fov"));
    EXPECT_FALSE(names_an_option("a -- b, --, -f"));
}

// A library has no command line: an error or a guess there hints at a `Setting`, and
// player/commands/option_types.cpp knows its option.
TEST(Modules, OnlyCommandLineNamesOptions) {
    // Options of udevadm, and the command whose output goes to it; of programs that export other recordings;
    // of h5dump, zenity and kdialog.
    const std::set<std::string> allowed{"--udev-rules",        "--reload",         "--mode 4",
                                        "--output_path_dir",   "--filename",       "--export_depth_images",
                                        "--no-compact-subset", "--file-selection", "--title",
                                        "--getopenfilename"};
    const auto is_allowed = [&](const std::string& literal) {
        return std::ranges::any_of(
            allowed, [&](const std::string& option) { return literal.find(option) != std::string::npos; });
    };
    std::size_t literals = 0;
    for (const auto& [name, module] : modules()) {
        if (name == "commands") continue;
        for (const fs::path& file : files_of(module)) {
            if (file.extension() != ".cpp" && file.extension() != ".hpp") continue;
            for (const std::string& literal : literals_of(text_of(file))) {
                ++literals;
                EXPECT_FALSE(names_an_option(literal) && !is_allowed(literal))
                    << file << ": \"" << literal << '"';
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
// engine/base/same_bits.hpp has some that do not.
TEST(Modules, AvoidLibraryRounding) {
    const std::set<std::string> rounded{
        "sin",  "cos",    "tan",    "asin",  "acos",   "atan",      "atan2", "sinh",
        "cosh", "tanh",   "asinh",  "acosh", "atanh",  "exp",       "exp2",  "expm1",
        "log",  "log2",   "log10",  "log1p", "pow",    "cbrt",      "hypot", "erf",
        "erfc", "tgamma", "lgamma", "fma",   "rotate", "angleAxis", "slerp", "perspective"};
    int files = 0;
    for (const auto& [name, module] : modules()) {
        if (module.folder.starts_with("player") && name != "run" && name != "session") continue;
        for (const fs::path& file : files_of(module)) {
            // This one compares forces that were written down, for a person.
            if (file.filename() == "force_table.cpp") continue;
            std::ifstream in(file);
            ++files;
            for (std::string line; std::getline(in, line);)
                for (const std::string& word : library_words(line))
                    EXPECT_FALSE(rounded.contains(word)) << file << ": " << line;
        }
    }
    EXPECT_GT(files, 300) << "hardly anything was looked at";
}

// Pages refer to each other by links: each leads to a file that is there, and to a heading of it.

/// All files of the project, without what is made in its folder.
std::vector<fs::path> all_files() {
    const Names left_out{"build", "out", ".git", ".cache"};
    std::vector<fs::path> files;
    for (fs::recursive_directory_iterator at(source("")), end; at != end; ++at) {
        if (at.depth() == 0 && left_out.contains(at->path().filename())) at.disable_recursion_pending();
        if (at->is_regular_file()) files.push_back(at->path());
    }
    return files;
}

std::vector<fs::path> pages() {
    std::vector<fs::path> found = all_files();
    std::erase_if(found, [](const fs::path& file) { return file.extension() != ".md"; });
    return found;
}

/// Lines of a page outside its blocks of code.
std::vector<std::string> lines_of(const fs::path& page) {
    std::ifstream in(page);
    std::vector<std::string> lines;
    bool is_code = false;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("```")) is_code = !is_code;
        if (!is_code && !line.starts_with("    ")) lines.push_back(line);
    }
    return lines;
}

/// The anchor of a heading, as GitHub makes it: small letters, strokes for spaces, no signs.
std::string anchor_of(const std::string& heading) {
    std::string anchor;
    for (const char letter : heading) {
        const auto byte = static_cast<unsigned char>(letter);
        if (std::isalnum(byte) || letter == '-' || letter == '_' || byte >= 0x80)
            anchor += static_cast<char>(std::tolower(byte));
        if (letter == ' ') anchor += '-';
    }
    return anchor;
}

std::set<std::string> anchors_of(const fs::path& page) {
    static const std::regex link(R"(\[([^\]]*)\]\([^)]*\))");
    std::set<std::string> anchors;
    for (const std::string& line : lines_of(page)) {
        if (!line.starts_with('#')) continue;
        const std::string heading = line.substr(line.find_first_not_of("# "));
        anchors.insert(anchor_of(std::regex_replace(heading, link, "$1")));
    }
    return anchors;
}

TEST(Links, LeadToExistingHeadings) {
    static const std::regex link(R"(\]\(([^)\s]+)\))");
    int checked = 0;
    for (const fs::path& page : pages())
        for (const std::string& line : lines_of(page))
            for (std::sregex_iterator at(line.begin(), line.end(), link), end; at != end; ++at) {
                const std::string to = (*at)[1];
                if (to.find("://") != std::string::npos || to.starts_with("mailto:")) continue;
                const std::size_t sharp = std::min(to.find('#'), to.size());
                const fs::path file = sharp == 0 ? page : page.parent_path() / to.substr(0, sharp);
                ++checked;
                EXPECT_TRUE(fs::exists(file)) << page << ": " << to << " is not there";
                const bool names_heading = sharp < to.size() && file.extension() == ".md";
                EXPECT_TRUE(!names_heading || anchors_of(file).contains(to.substr(sharp + 1)))
                    << page << ": " << to << " is no heading there";
            }
    EXPECT_GT(checked, 200);
}

TEST(Pages, NameExistingFiles) {
    static const std::regex name(R"(`([\w./-]+\.(cpp|hpp|h|c|comp|vert|frag|js|py|cmake))`)");
    std::string files;
    for (const fs::path& file : all_files()) files += file.string() + '\n';
    int checked = 0;
    for (const fs::path& page : pages())
        for (const std::string& line : lines_of(page))
            for (std::sregex_iterator at(line.begin(), line.end(), name), end; at != end; ++at, ++checked)
                EXPECT_NE(files.find('/' + (*at)[1].str() + '\n'), std::string::npos)
                    << page << ": there is no " << (*at)[1];
    EXPECT_GT(checked, 200);
}

// A test stands at the public face, or is an oracle for an algorithm with a written contract
// (CONTRIBUTING.md, Tests). private_headers.txt lists the private headers that tests include; the list only
// shrinks.

/// Whether a header is the product's, and its module does not name it as public. (No module includes the C
/// API's installed headers, so none names them.)
bool is_private(const std::string& header) {
    const fs::path path(header);
    const std::string folder = path.parent_path().string(), file = path.filename().string();
    if (folder.empty() || std::ranges::find(kProduct, path.begin()->string()) == kProduct.end() ||
        header.starts_with("capi/touchable."))
        return false;
    return std::ranges::none_of(modules(), [&](const auto& module) {
        return module.second.folder == folder && module.second.headers.contains(file);
    });
}

/// What has to change about a private header, or nothing. `entry`: its word in the list, a heading of docs/
/// or a number of files; empty: it is not listed. `files`: how many files of tests/ include it.
std::string change_of_list(const std::string& entry, std::size_t files) {
    if (entry.empty()) return "include a public header instead, or list the heading of its contract in docs/";
    if (files == 0) return "no test includes it: remove its line";
    if (entry.find_first_not_of("0123456789") == std::string::npos) {
        const std::size_t listed = std::stoul(entry);
        if (files > listed)
            return std::to_string(files) + " files include it, " + entry +
                   " may: include a public header instead";
        if (files < listed) return "fewer files include it: write " + std::to_string(files) + " in its line";
        return "";
    }
    const std::size_t sharp = std::min(entry.find('#'), entry.size() - 1);
    const fs::path page = source("docs") / entry.substr(0, sharp);
    const bool has_contract = fs::is_regular_file(page) && anchors_of(page).contains(entry.substr(sharp + 1));
    return has_contract ? "" : "docs/" + entry + " is no heading: name the one of its contract";
}

TEST(PrivateHeaders, OfTestsAreListed) {
    std::map<std::string, std::string> listed;
    std::istringstream lines(text_of(source("tests/modules/private_headers.txt")));
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line.starts_with('#')) continue;
        const std::size_t space = std::min(line.find(' '), line.size() - 1);
        EXPECT_TRUE(listed.emplace(line.substr(0, space), line.substr(space + 1)).second) << line;
    }
    std::map<std::string, Names> included;
    for (const auto& [header, entry] : listed) included[header];
    int files = 0;
    for (const auto& found : fs::recursive_directory_iterator(source("tests"))) {
        if (!is_code(found.path())) continue;
        ++files;
        for (const std::string& header : included_by(found.path(), "#include \"", '"'))
            if (is_private(header)) included[header].insert(fs::relative(found.path(), source("")).string());
    }
    for (const auto& [header, by] : included)
        EXPECT_EQ(change_of_list(listed[header], by.size()), "")
            << header << ", included by " << ::testing::PrintToString(by);
    EXPECT_GT(files, 200) << "hardly anything was looked at";
}

TEST(PrivateHeaders, ListOnlyShrinks) {
    const auto stays = [](const std::string& entry, std::size_t files) {
        return change_of_list(entry, files).empty();
    };
    const std::string heading = "conventions.md#what-is-measured";
    EXPECT_TRUE(stays("2", 2) && stays(heading, 1) && stays(heading, 5));
    EXPECT_FALSE(stays("", 1) || stays("2", 3) || stays("2", 1) || stays("2", 0));
    EXPECT_FALSE(stays(heading, 0) || stays(heading + "-here", 1) || stays("none.md#units", 1));
    EXPECT_TRUE(is_private("haptics_cpu/cast.hpp"));
    for (const char* header : {"haptics_cpu/haptic_loop.hpp", "capi/touchable.h", "tests/must.hpp"})
        EXPECT_FALSE(is_private(header)) << header;
}

// Recordings are looked for by one function, so that one word in the environment takes all of them away.

TEST(RealData, IsFoundByOneFunction) {
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(source("tests"))) {
        const fs::path& file = entry.path();
        if (!is_code(file) || file.filename() == "real_data.hpp" || file.filename() == "modules_test.cpp")
            continue;
        const std::string text = text_of(file);
        ++files;
        for (const char* way : {"TOUCHABLE_TEST_DATA", "shared/data"})
            EXPECT_EQ(text.find(way), std::string::npos)
                << file << " finds recordings by " << way << ", not by real_data()";
    }
    EXPECT_GT(files, 200) << "hardly anything was looked at";
}

// Each source file names its licence in a line of SPDX's, at its beginning, where programs look for it.

TEST(Licence, IsNamedBySources) {
    const Names kinds{".cpp", ".hpp", ".h",    ".c",     ".comp", ".vert", ".frag",          ".js", ".py",
                      ".sh",  ".awk", ".bash", ".cmake", ".css",  ".html", "CMakeLists.txt", "run"};
    int files = 0;
    for (const fs::path& file : all_files()) {
        if (!kinds.contains(file.extension()) && !kinds.contains(file.filename())) continue;
        const std::string text = text_of(file);
        EXPECT_LT(text.find("SPDX-License-Identifier: Apache-2.0"), 100U) << file;
        ++files;
    }
    EXPECT_GT(files, 1000) << "hardly anything was looked at";
}

}  // namespace
}  // namespace touchable::test
