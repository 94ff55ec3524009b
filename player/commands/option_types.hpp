#pragma once

// Kinds of options: numbers in a range, words of a list, sizes, files; and the files that a command is to
// write (Outputs), which check_outputs holds against the files that it reads. Functions that begin with add_
// add an option to a subcommand; those that begin with read_ read one word, and an error (ErrorKind::usage)
// says what would be right. Without state.

#include <CLI/CLI.hpp>
#include <charconv>
#include <functional>
#include <limits>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// An option (or a word, where `name` has no dashes) that names a file or a folder: an empty name, which is
/// most often a variable of the shell that was never set, is refused.
template <class Path>
CLI::Option* add_file_option(CLI::App& sub, const std::string& name, Path& file, const std::string& what) {
    const CLI::Validator named([](std::string& text) { return text.empty() ? "names no file" : ""; }, "");
    return sub.add_option(name, file, what)->check(named)->type_name("FILE");
}

/// Refuses a file's name with none of these endings, as `what` has one: other programs go by it.
CLI::Validator ends_in(const std::vector<std::string>& endings, const std::string& what);

/// An option whose word `read` takes, or refuses: its error follows the option's name.
inline CLI::Option* add_read_option(CLI::App& sub, const std::string& name,
                                    std::function<Result<void>(const std::string& word)> read,
                                    const std::string& what) {
    const auto take = [name, read = std::move(read)](const std::string& word) {
        if (const auto taken = read(word); !taken) throw CLI::ValidationError(name, taken.error().message);
    };
    return sub.add_option_function<std::string>(name, take, what);
}

/// A whole number as typed after `option`; refused (ErrorKind::usage) where it is none, or out of range. What
/// is too large for its type is refused as well, not cut down to it.
template <class Whole>
Result<Whole> read_whole_number(const std::string& option, std::string_view text, Whole least, Whole most) {
    Whole value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure == std::errc() && end == text.data() + text.size() && value >= least && value <= most)
        return value;
    std::string message = (option.empty() ? "'" : option + " '").append(text);
    message += "' is not allowed; must be a whole number";
    if (least != std::numeric_limits<Whole>::min() || most != std::numeric_limits<Whole>::max())
        message += ", " + std::to_string(least) + " to " + std::to_string(most);
    return usage_error(std::move(message));
}

/// A finite number as typed after `option`; refused (ErrorKind::usage) where it is none, or out of range.
Result<double> read_number(const std::string& option, std::string_view text, double least, double most);

/// Frames per second as typed after `option`, exactly: "25", "29.97" (2997/100), "30000/1001"; 0.001 to 1000.
Result<FrameRate> read_frame_rate(const std::string& option, std::string_view text);

struct PixelSize {
    int width = 0, height = 0;
};
/// "720x480" as typed after `option`, each side `least` to `most` pixels.
Result<PixelSize> read_pixel_size(const std::string& option, std::string_view text, int least, int most);

/// An option that takes a finite number, `least` to `most`, or several where `number` is a list of them. (To
/// CLI11's own CLI::Range NaN lies in every range.)
template <class Option>
CLI::Option* add_number_option(CLI::App& sub, const std::string& name, Option& number,
                               const std::string& what, double least = std::numeric_limits<double>::lowest(),
                               double most = std::numeric_limits<double>::max()) {
    const CLI::Validator finite(
        [=](std::string& text) {
            const auto read = read_number("", text, least, most);
            return read ? std::string() : read.error().message;
        },
        "");
    return sub.add_option(name, number, what)->check(finite);
}

/// An option that takes a whole number, `least` to `most`, in decimal as people write it: 010 is ten.
template <class Option>
CLI::Option* add_whole_option(CLI::App& sub, const std::string& name, Option& number, const std::string& what,
                              int least = std::numeric_limits<int>::min(),
                              int most = std::numeric_limits<int>::max()) {
    const CLI::Validator decimal(
        [=](std::string& text) {
            const auto read = read_whole_number<int>("", text, least, most);
            if (!read) return read.error().message;
            text = std::to_string(*read);
            return std::string();
        },
        "");
    return sub.add_option(name, number, what)->transform(decimal)->type_name("N");
}

/// What a setting's word stands for; refused (ErrorKind::usage) where it is none of the range's.
Result<double> read_word(const SettingRange& range, const std::string& word);

/// An option whose value, an enumerator or a bool, is said by one of some words, which are in the order of
/// its values. `what` says which.
template <class Value>
CLI::Option* add_word_option(CLI::App& sub, const std::string& name, Value& value, const std::string& what,
                             std::vector<const char*> words) {
    const auto read =
        [&value, range = SettingRange{.words = std::move(words)}](const std::string& word) -> Result<void> {
        const auto place = read_word(range, word);
        if (!place) return place.error();
        value = static_cast<Value>(*place);
        return {};
    };
    return add_read_option(sub, name, read, what)->type_name("WORD");
}

/// What --fragmented is for, where it is refused.
inline constexpr const char* fragmented_names = "NAME.mp4; no other form is written in fragments";

/// --fragmented, of the commands that write clips.
inline const CLI::Option* add_fragmented_option(CLI::App& command, ClipStorage& storage) {
    return command.add_flag("--fragmented", storage.fragmented,
                            "of NAME.mp4: in pieces of half a second, as it is sent; a copy that is cut is "
                            "readable up to there. Without an MPEG-4 scene (docs/codecs.md)");
}

class ClipReader;

/// A file as it was named: "--json" and its path, or "the clip" and its path.
struct NamedFile {
    std::string name;
    std::filesystem::path path;
};

/// Files that a command is to write, and what stands in its way.
struct Outputs {
    std::vector<NamedFile> files;
    Existing existing = Existing::keep;  ///< what becomes of earlier files of their names
};

/// Adds --overwrite.
void add_overwrite_option(CLI::App& sub, Existing& existing);

/// Adds every file that a clip is read from; `clip` as it was named.
void add_inputs(std::vector<NamedFile>& inputs, const std::filesystem::path& clip, const ClipReader& reader);

/// Refuses (ErrorKind::usage) an output that is also an input or another output, by whatever name, and
/// whatever was asked for, and one that is there already unless it may be replaced. Standard output is no
/// file, but there is only one.
Result<void> check_outputs(const Outputs& outputs, const std::vector<NamedFile>& inputs);

}  // namespace touchable
