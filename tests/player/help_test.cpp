#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

std::vector<std::string> split(const std::string& text, char between) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, between);) parts.push_back(part);
    return parts;
}

/// A line of `touchable --list-options`.
struct Option {
    std::string topic, names, value;
    std::vector<std::string> words;
};
struct Table {
    std::map<std::string, std::vector<Option>> options;  ///< of each command; "": of the program
    std::map<std::string, std::vector<std::string>> examples;
};

const Table& table() {
    static const Table read = [] {
        Table all;
        for (const std::string& line : split(run_touchable({"--list-options"}).out, '\n')) {
            const auto fields = split(line, '\t');
            if (fields[0] == "option")
                all.options[fields.at(1)].push_back(
                    {fields.at(2), fields.at(3), fields.at(4), split(fields.at(5), ',')});
            if (fields[0] == "example") all.examples[fields.at(1)].push_back(fields.at(2));
        }
        all.options.erase("touchable");
        return all;
    }();
    return read;
}

std::vector<std::string> lines_of(const std::vector<std::string>& words) {
    const Outcome run = run_touchable(words);
    EXPECT_EQ(run.code, 0) << run.err;
    return split(run.out, '\n');
}

/// The heads of the entries: "-h, --help", "--scene FILE".
std::vector<std::string> heads_of(const std::vector<std::string>& lines) {
    std::vector<std::string> heads;
    for (const std::string& line : lines)
        if (line.starts_with("  ") && line.size() > 2 && line[2] != ' ')
            heads.push_back(line.substr(2, line.find("  ", 2) - 2));
    return heads;
}

TEST(Help, IsShort) {
    ASSERT_GT(table().options.size(), 10U);
    for (const char* command :
         {"play", "touch", "export", "convert", "info", "make", "serve", "init-scene", "relief", "materials"})
        EXPECT_EQ(table().examples.at(command).size(), 2U) << command;
    for (const auto& [command, options] : table().options) {
        const auto lines = lines_of({command, "--help"});
        EXPECT_LE(lines.size(), 25U) << command;
        for (const std::string& line : lines) EXPECT_LE(line.size(), 100U) << command << ": " << line;
        EXPECT_EQ(lines, lines_of({"help", command}));
    }
}

TEST(Help, ExamplesAreCommandsThatParse) {
    for (const auto& [command, examples] : table().examples)
        for (const std::string& example : examples) {
            const TemporaryFolder folder;  // without the files that the example reads
            std::istringstream in(example.substr(0, example.find('#')));
            std::vector<std::string> words;
            for (std::string word; in >> word;) words.push_back(word);
            ASSERT_EQ(words.at(0), "touchable") << example;
            ASSERT_EQ(words.at(1), command) << example;
            words.erase(words.begin());
            if (command == "make") words.insert(words.end(), {"--size", "16x12", "--frames", "1"});
            // Where the camera of an example is plugged in.
            if (command == "play") words.insert(words.end(), {"--headless", "--seconds", "1"});
            if (command == "serve") words.insert(words.end(), {"--seconds", "1"});
            const Outcome run = run_in_folder(words, folder.path());
            EXPECT_NE(run.code, 2) << example << ": " << run.err;
            EXPECT_TRUE(run.code == 0 || run.one_line_of_error()) << example << ": " << run.err;
        }
}

TEST(Help, AllHasEveryOptionOnceUnderItsTopic) {
    for (const auto& [command, options] : table().options) {
        const auto lines = lines_of({command, "--help-all"});
        EXPECT_EQ(lines, lines_of({"help", command, "all"}));
        const auto heads = heads_of(lines);
        std::set<std::string> topics;
        for (const Option& option : options) {
            const std::string head = option.names + (option.value.empty() ? "" : " " + option.value);
            EXPECT_EQ(std::ranges::count(heads, head), 1) << command << ' ' << head;
            topics.insert(option.topic);
        }
        EXPECT_EQ(heads.size(), options.size()) << command;
        std::size_t found = 0;
        for (const std::string& topic : topics)
            found += heads_of(lines_of({command, "--help", topic})).size();
        EXPECT_EQ(found, options.size()) << command;
        for (const std::string& line : lines) {
            EXPECT_LE(line.size(), 100U) << command << ": " << line;
            for (const char* noise : {"Excludes:", "Needs:", "TEXT", "FLOAT", "REQUIRED", "{"})
                EXPECT_EQ(line.find(noise), std::string::npos) << command << ": " << line;
        }
    }
    EXPECT_GT(table().options.at("play").size(), 50U);
    EXPECT_GT(table().options.at("touch").size(), 50U);
}

TEST(Help, UnknownTopicIsToldTheTopics) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"play", "--help", "weather"}, {"help", "play", "weather"}}) {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2);
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        for (const char* right : {"weather", "camera", "kiosk", "all"})
            EXPECT_NE(run.err.find(right), std::string::npos) << run.err;
    }
    EXPECT_EQ(run_touchable({"play", "--help", "Camera"}).out, run_touchable({"help", "play", "camera"}).out);
}

TEST(Help, ListsTheWordsThatAreAllowed) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    ASSERT_EQ(run_touchable({"make", "plane", clip, "--size", "16x12", "--frames", "1"}).code, 0);
    std::size_t lists = 0;
    for (const auto& [command, options] : table().options)
        for (const Option& option : options) {
            std::string shown;
            for (const std::string& word : option.words) shown += (shown.empty() ? "" : "|") + word;
            const bool has_only_words = option.value == "WORD" || option.value == shown;
            if (option.words.empty() || (!has_only_words && option.names != "--preset")) continue;
            const Outcome run = run_touchable({command, clip, option.names, "nonsense"});
            EXPECT_EQ(run.code, 2) << command << ' ' << option.names;
            EXPECT_NE(run.err.find("nonsense"), std::string::npos) << run.err;
            for (const std::string& word : option.words)
                EXPECT_NE(run.err.find(word), std::string::npos) << option.names << ": " << run.err;
            ++lists;
        }
    EXPECT_GT(lists, 20U);
    for (const Option& option : table().options.at("touch"))
        if (option.names == "--hand" || option.names == "--device")
            for (const std::string& word : option.words) {
                const Outcome run = run_touchable({"touch", clip, "--live", option.names, "nonsense"});
                EXPECT_NE(run.err.find(word.substr(0, word.find(':'))), std::string::npos) << run.err;
                if (option.names == "--hand" && word.find(':') == std::string::npos) {
                    const Outcome ran = run_touchable({"touch", clip, "--seconds", "0.01", "--hand", word});
                    EXPECT_EQ(ran.code, 0) << ran.err;
                }
            }
}

}  // namespace
}  // namespace touchable::test
