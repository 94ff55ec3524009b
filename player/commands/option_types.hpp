// SPDX-License-Identifier: Apache-2.0
#pragma once

// Kinds of options: numbers in a range, words of a list, sizes, files; and a command's output files
// (Outputs), which check_outputs compares with its input files. Functions that begin with add_ add an option
// to a subcommand; those that begin with read_ read one word, and an error (ErrorKind::usage) states the
// valid values. message_with_options and remark_with_options put options into words that hint at settings.
// Stateless.

#include <CLI/CLI.hpp>
#include <charconv>
#include <functional>
#include <limits>
#include <nlohmann/json_fwd.hpp>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/scene/scene.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

/// Adds an option (or a word, if `name` has no dashes) that names a file or a folder, by its path or a
/// file:// URL. An empty name, usually an unset shell variable, is refused.
template <class Path>
CLI::Option* add_file_option(CLI::App& sub, const std::string& name, Path& file, const std::string& what) {
    const auto read = [](std::string& text) {
        text = typed_path(text);
        return text.empty() ? "names no file" : "";
    };
    return sub.add_option(name, file, what)->transform(CLI::Validator(read, ""))->type_name("FILE");
}

/// Refuses file names without one of these endings, because other programs use them to recognise `what`.
CLI::Validator ends_in(const std::vector<std::string>& endings, const std::string& what);

/// Topics of the help. expert_topic holds rarely needed options and is listed last, before help_topic.
inline constexpr const char *expert_topic = "Expert", *help_topic = "Help";
inline constexpr const char *files_topic = "Files", *picture_topic = "Picture", *filters_topic = "Filters";

/// Options added from now on are listed under this topic of the help.
inline void begin_topic(CLI::App& sub, const char* topic) {
    sub.option_defaults()->group(topic);
}

/// Makes `command` do this work once `sub` is parsed.
inline void set_work(CLI::App& sub, std::function<Result<void>()>& command,
                     std::function<Result<void>()> work) {
    sub.callback([&command, work = std::move(work)] { command = work; });
}

/// "frames of 720x480 pixels": the main use of memory.
inline std::string frames_in_words(const Scene& scene) {
    return "frames of " + size_text(scene.width, scene.height) + " pixels";
}

/// Type of an option whose value is or may be one of these words: "NAME:{a,b}". Help and completion take the
/// words from it. With NAME "WORD" no other value is allowed.
template <class Words>
std::string type_with_words(const std::string& name, const Words& words) {
    return name + ":{" + listed(words, {}, ",") + "}";
}

/// A refused value for a message: as it is, or in quotes if it would not read as one word.
inline std::string refused_value(std::string_view value) {
    const bool is_plain = !value.empty() && value.find_first_of(" \t\n;:,'\"") == std::string_view::npos;
    return is_plain ? printable(value) : "'" + printable(value) + "'";
}
/// "--size: 5 is not allowed; must be ...". `option` may be empty if CLI11 prepends it.
inline Error not_allowed(const std::string& option, std::string_view value, const std::string& right) {
    return usage_error((option.empty() ? "" : option + ": ") + refused_value(value) +
                       " is not allowed; must be " + right);
}

/// An option whose word is passed to `read`; an error of `read` follows the option's name.
inline CLI::Option* add_read_option(CLI::App& sub, const std::string& name,
                                    std::function<Result<void>(const std::string& word)> read,
                                    const std::string& what) {
    const auto take = [name, read = std::move(read)](const std::string& word) {
        if (const auto taken = read(word); !taken) throw CLI::ValidationError(name, taken.error().message);
    };
    return sub.add_option_function<std::string>(name, take, what);
}

/// A whole number as typed after `option`; refused (ErrorKind::usage) if invalid, out of range or too large
/// for its type.
template <class Whole>
Result<Whole> read_whole_number(const std::string& option, std::string_view text, Whole least, Whole most) {
    const auto value = parsed_as<Whole>(text);
    if (value && *value >= least && *value <= most) return *value;
    std::string right = "a whole number";
    if (least != std::numeric_limits<Whole>::min() || most != std::numeric_limits<Whole>::max())
        right += ", " + std::to_string(least) + " to " + std::to_string(most);
    return not_allowed(option, text, right);
}

/// A finite number as typed after `option`; refused (ErrorKind::usage) if invalid or out of range. `unit` is
/// named by the message, as in the help ("METRES", "N/mm").
Result<double> read_number(const std::string& option, std::string_view text, double least, double most,
                           std::string_view unit = "");

/// Frames per second as typed after `option`, exactly: "25", "29.97" (2997/100), "30000/1001"; 0.001 to 1000.
Result<FrameRate> read_frame_rate(const std::string& option, std::string_view text);

struct PixelSize {
    int width = 0, height = 0;
};
/// "720x480" as typed after `option`, each side `least` to `most` pixels.
Result<PixelSize> read_pixel_size(const std::string& option, std::string_view text, int least, int most);

/// An option that takes a finite number, `least` to `most`, or several if `number` is a list. (CLI11's own
/// CLI::Range accepts NaN in every range.)
template <class Option>
CLI::Option* add_number_option(CLI::App& sub, const std::string& name, Option& number,
                               const std::string& what, double least = std::numeric_limits<double>::lowest(),
                               double most = std::numeric_limits<double>::max()) {
    CLI::Option* const option = sub.add_option(name, number, what)->type_name("NUMBER");
    const CLI::Validator finite(
        [=](std::string& text) {
            const auto read = read_number("", text, least, most, option->get_type_name());
            return read ? std::string() : read.error().message;
        },
        "");
    return option->check(finite);
}

/// An option that takes a whole number, `least` to `most`, always decimal: 010 is ten.
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

/// Value of a setting's word; refused (ErrorKind::usage) if not a word of the range.
Result<double> read_word(const SettingRange& range, const std::string& word);

/// An option whose value is one of `words`; for an enumeration or a bool in the order of its values.
template <class Value>
CLI::Option* add_word_option(CLI::App& sub, const std::string& name, Value& value, const std::string& what,
                             std::vector<const char*> words) {
    const std::string type = type_with_words("WORD", words);
    const auto read =
        [&value, range = SettingRange{.words = std::move(words)}](const std::string& word) -> Result<void> {
        TRY_ASSIGN(const double place, read_word(range, word));
        if constexpr (std::is_same_v<Value, std::string>)
            value = range.words[static_cast<std::size_t>(place)];
        else
            value = static_cast<Value>(place);
        return {};
    };
    return add_read_option(sub, name, read, what)->type_name(type);
}

/// Names that allow --fragmented, for its refusal.
inline constexpr const char* fragmented_names = "NAME.mp4; no other form is written in fragments";

/// Adds --archive, --exact-colour and --fragmented, for commands that write clips.
void add_storage_options(CLI::App& command, ClipStorage& storage);

/// This program; empty: the system does not tell.
std::filesystem::path program_file();
/// A folder of files that come with the program, in the build tree or the installation; `way` leads there
/// from the program's own folder.
std::filesystem::path folder_from_program(const char* way);

class OutputFile;

/// A file with its name in messages: "--json" and its path, or "the clip" and its path.
struct NamedFile {
    std::string name;
    std::filesystem::path path;
};

/// A command's output files.
struct Outputs {
    std::vector<NamedFile> files;
    Existing existing = Existing::keep;  ///< treatment of existing files of their names
};

/// Adds --overwrite.
CLI::Option* add_overwrite_option(CLI::App& sub, Existing& existing);

/// --json: alone it prints to standard output, in place of the words; --json=FILE writes beside them.
struct JsonOutput {
    std::optional<std::filesystem::path> file;
    Existing existing = Existing::keep;

    bool replaces_words() const;
    /// Call before the work; see check_outputs.
    Result<void> check(const std::vector<NamedFile>& inputs = {}) const;
    /// Does nothing without --json.
    Result<void> write(const nlohmann::ordered_json& json) const;
};
/// Writes a report as all of a file, which is finished.
Result<void> write_report(const nlohmann::ordered_json& report, OutputFile& file);

/// Adds --json and --overwrite.
CLI::Option* add_json_option(CLI::App& sub, JsonOutput& json, const std::string& what);
/// Adds --json. `takes_word`: a word behind it that is no option is its FILE.
CLI::Option* add_json_option(CLI::App& sub, std::optional<std::filesystem::path>& file,
                             const std::string& what, bool takes_word = false);

/// Refuses (ErrorKind::usage) an output that is also an input or another output, under any name and even with
/// --overwrite, and an existing file unless it may be replaced. Standard output is no file, but may be used
/// only once.
Result<void> check_outputs(const Outputs& outputs, const std::vector<NamedFile>& inputs);

/// The error's message with the options of its hinted settings. If the message begins with a setting's bare
/// name ("damping must be ..."), the option replaces it; others follow in brackets. `knows`: whether the
/// failed command has an option; unknown options are omitted.
using KnowsOption = std::function<bool(const std::string& option)>;
std::string message_with_options(const Error& error, const KnowsOption& knows = {});
/// A remark with the options that correct it, if it is a guess.
std::string remark_with_options(const Remark& remark);
std::vector<std::string> remarks_with_options(const std::vector<Remark>& remarks);

/// " --intrinsics 525,525 --depth-unit 0.001", to append to a command.
std::string typed_options(const Hints& hints);

}  // namespace touchable
