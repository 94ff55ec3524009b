// SPDX-License-Identifier: Apache-2.0
#include "player/commands/option_types.hpp"

#include <sys/stat.h>
#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/source_description.hpp"
#include "player/run/run_files.hpp"
#include "player/run/terminal.hpp"

namespace touchable {

namespace {

/// One comma, with digits on both sides.
bool has_decimal_comma(std::string_view text) {
    const std::size_t comma = text.find(',');
    return comma != std::string_view::npos && comma > 0 && comma + 1 < text.size() &&
           is_digit(text[comma - 1]) && is_digit(text[comma + 1]) &&
           text.find(',', comma + 1) == std::string_view::npos;
}

/// Digits only, at most 9: a scene's limit for the terms of a rate.
std::optional<std::int64_t> digits(std::string_view text) {
    return is_digits(text) && text.size() <= 9 ? parsed_as<std::int64_t>(text) : std::nullopt;
}

/// num and den of "num/den" or of a decimal fraction.
std::optional<FrameRate> exact_fraction(std::string_view text) {
    if (const std::size_t slash = text.find('/'); slash != std::string_view::npos) {
        const auto num = digits(text.substr(0, slash)), den = digits(text.substr(slash + 1));
        return num && den ? std::optional(FrameRate{*num, *den}) : std::nullopt;
    }
    const std::size_t point = std::min(text.find('.'), text.size());
    const std::string_view behind = text.substr(std::min(point + 1, text.size()));
    const auto all = digits(std::string(text.substr(0, point)).append(behind));
    if (!all || point == 0 || (point < text.size() && behind.empty())) return std::nullopt;
    std::int64_t den = 1;
    for (std::size_t n = 0; n < behind.size(); ++n) den *= 10;
    return FrameRate{*all, den};
}

namespace fs = std::filesystem;

std::string identity_of(const struct stat& file) {
    return std::to_string(file.st_dev) + ':' + std::to_string(file.st_ino);
}

/// Equal for two names of one file, existing or to be created.
std::string file_behind(const fs::path& path) {
    if (is_standard_output(path)) return "standard output";
    struct stat file = {}, folder = {};
    if (stat(path.c_str(), &file) == 0) return identity_of(file);
    std::error_code failure;
    fs::path whole = fs::weakly_canonical(fs::absolute(path, failure), failure);
    if (failure) whole = path.lexically_normal();
    if (stat(whole.parent_path().c_str(), &folder) != 0) return whole.string();
    return identity_of(folder) + '/' + whole.filename().string();
}

/// Whether a file or a dangling link has that name. Folders and devices are refused when they are opened.
bool is_taken(const fs::path& path) {
    std::error_code ignored;
    const auto named = fs::symlink_status(path, ignored);
    if (!fs::exists(named)) return false;
    const auto led_to = fs::status(path, ignored);
    return !fs::exists(led_to) || fs::is_regular_file(led_to);
}

Result<void> refuse(const NamedFile& output, const std::string& why) {
    return usage_error(output.name + " " + output.path.string() + why);
}

/// The text typed for a setting: an option, or another word of a command.
struct Spelling {
    Setting::Name setting;
    std::string option;
    std::string_view value{};  ///< as in --help; empty: no value, or stated by messages
};

/// Most settings' options have the setting's name.
Spelling spelling_of(const Hint& hint) {
    static const std::array irregular{Spelling{Setting::clip, "CLIP"},
                                      Spelling{Setting::device_rules, std::string(udev_rules_command)},
                                      Spelling{Setting::forces, "touch --forces"},
                                      Spelling{Setting::haptic_map, "--haptic"},
                                      Spelling{Setting::height_map, "--height"},
                                      Spelling{Setting::intrinsics, "--intrinsics", "FX,FY,CX,CY"},
                                      Spelling{Setting::playback, "--play"},
                                      Spelling{Setting::record, "touch --record"},
                                      Spelling{Setting::scene_file, "--scene", "FILE"},
                                      Spelling{Setting::stiffness_rise, "--stiffness-slew"}};
    const auto* const found = std::ranges::find(irregular, hint.setting, &Spelling::setting);
    if (found != irregular.end()) return *found;
    const SourceSetting* const of_source = source_setting(hint.setting);
    return {hint.setting, "--" + with_dashes(hint.setting), of_source ? of_source->form : ""};
}

std::string typed(std::string_view option, std::string_view value) {
    return std::string(option) + (value.empty() ? "" : ' ' + std::string(value));
}

/// "--damping" for "damping must be ...".
bool begins_with_name(std::string_view message, std::string_view option) {
    if (!option.starts_with("--")) return false;
    option.remove_prefix(2);
    return message.starts_with(option) && message.substr(option.size()).starts_with(' ');
}

}  // namespace

CLI::Validator ends_in(const std::vector<std::string>& endings, const std::string& what) {
    return {[=](std::string& name) {
                const std::string ending = CLI::detail::to_lower(fs::path(name).extension());
                if (std::ranges::find(endings, ending) != endings.end()) return std::string();
                return "'" + name + "' does not end in " + CLI::detail::join(endings, " or ") + ", as " +
                       what + " does";
            },
            ""};
}

Result<FrameRate> read_frame_rate(const std::string& option, std::string_view text) {
    constexpr std::int64_t fastest = 1000, slowest_seconds = 1000;
    const auto rate = exact_fraction(text);
    if (rate && rate->den > 0 && rate->num <= fastest * rate->den &&
        rate->num * slowest_seconds >= rate->den) {
        const std::int64_t common = std::gcd(rate->num, rate->den);
        return FrameRate{rate->num / common, rate->den / common};
    }
    return not_allowed(option, text, "frames per second, 0.001 to 1000, such as 30, 29.97 or 30000/1001");
}

Result<double> read_number(const std::string& option, std::string_view text, double least, double most,
                           std::string_view unit) {
    const auto value = parsed_number(text.starts_with('+') ? text.substr(1) : text);
    if (value && *value >= least && *value <= most) return *value;
    std::string right = "a number", example;
    if (unit == "METRES") example = ", such as 0.001 for mm";
    if (unit == "N/mm") example = ", such as 0.6 for 600 N/m";
    const bool is_unit = unit.find(' ') == std::string_view::npos || unit.find('/') != std::string_view::npos;
    if (is_unit && unit != "NUMBER" && !unit.empty())  // "FROM TO" is none
        right += " of " + (unit[0] == 'N' ? std::string(unit) : small_letters(std::string(unit)));
    const bool has_least = least != std::numeric_limits<double>::lowest(),
               has_most = most != std::numeric_limits<double>::max();
    if (has_least && has_most)
        right += formatted(", %g to %g", least, most);
    else if (has_least)
        right += formatted(", %g or more", least);
    if (has_decimal_comma(text)) right += ", with a decimal point in place of the comma";
    return not_allowed(option, text, right + example);
}

Result<double> read_word(const SettingRange& range, const std::string& word) {
    if (const auto value = range.value_of(word)) return *value;
    return not_allowed("", word, range.in_words());
}

Result<PixelSize> read_pixel_size(const std::string& option, std::string_view text, int least, int most) {
    const std::size_t cross = text.find('x');
    if (cross != std::string_view::npos) {
        const auto width = read_whole_number(option, text.substr(0, cross), least, most);
        const auto height = read_whole_number(option, text.substr(cross + 1), least, most);
        if (width && height) return PixelSize{*width, *height};
    }
    return not_allowed(option, text,
                       "WIDTHxHEIGHT in pixels, each " + std::to_string(least) + " to " +
                           std::to_string(most) + ", such as 720x480");
}

void add_storage_options(CLI::App& command, ClipStorage& storage) {
    add_word_option(command, "--archive", storage.archive,
                    "how a clip is compressed. fast (default): quick to write and read; small: fewest "
                    "bytes, slow to write (0.2 s for a picture of 640x480); both keep every value of "
                    "depth, haptic and height (docs/codecs.md)",
                    {"fast", "small"});
    command.add_flag("--exact-colour", storage.exact_colour,
                     "keep every value of a clip's colour. Otherwise it is as good as the eye can tell");
    command.add_flag("--fragmented", storage.fragmented,
                     "write NAME.mp4 in pieces of half a second, as it is sent. A copy that is cut "
                     "off is readable up to there; it has no MPEG-4 scene (docs/codecs.md)");
}

fs::path program_file() {
    // The portable program is started by its loader, which /proc would name (cmake/launcher.c).
    if (const char* const started = std::getenv("TOUCHABLE_STARTED_AS")) return started;
    std::error_code fault;
    return fs::read_symlink("/proc/self/exe", fault);
}

fs::path folder_from_program(const char* way) {
    return (program_file().parent_path() / way).lexically_normal();
}

CLI::Option* add_overwrite_option(CLI::App& sub, Existing& existing) {
    return sub
        .add_flag_callback(
            "--overwrite", [&existing] { existing = Existing::replace; },
            "replace files that exist, instead of refusing to")
        ->group(files_topic);
}

CLI::Option* add_json_option(CLI::App& sub, std::optional<fs::path>& file, const std::string& what,
                             bool takes_word) {
    const auto keep = [&file](std::string& name) {
        file = name;
        return std::string();
    };
    const std::string text =
        what + (takes_word ? "; without FILE to standard output" : "; =FILE: to a file, too");
    return sub.add_flag("--json{-}", text)
        ->expected(0, takes_word ? 1 : 0)
        ->multi_option_policy(CLI::MultiOptionPolicy::Throw)
        ->check(CLI::Validator(keep, ""))
        ->type_name(takes_word ? "[FILE]" : "[=FILE]");
}

CLI::Option* add_json_option(CLI::App& sub, JsonOutput& json, const std::string& what) {
    add_overwrite_option(sub, json.existing)->group(sub.option_defaults()->get_group());
    return add_json_option(sub, json.file, what);
}

bool JsonOutput::replaces_words() const {
    return file && is_standard_output(*file);
}

Result<void> JsonOutput::check(const std::vector<NamedFile>& inputs) const {
    return file ? check_outputs({{{"--json", *file}}, existing}, inputs) : Result<void>();
}

Result<void> JsonOutput::write(const nlohmann::ordered_json& json) const {
    if (!file) return {};
    TRY_ASSIGN(const auto out, OutputFile::create("--json", *file, existing));
    return write_report(json, *out);
}

Result<void> write_report(const nlohmann::ordered_json& report, OutputFile& file) {
    const auto replace = nlohmann::json::error_handler_t::replace;  // file names need not be UTF-8
    TRY(file.write(report.dump(2, ' ', true, replace) + '\n'));     // ASCII: also for a terminal
    return file.finish();
}

Result<void> check_outputs(const Outputs& outputs, const std::vector<NamedFile>& inputs) {
    std::map<std::string, std::string> taken;
    for (const NamedFile& input : inputs)
        if (!input.path.empty()) taken.emplace(file_behind(input.path), input.name);
    for (const NamedFile& output : outputs.files) {
        const auto [at, free] = taken.emplace(file_behind(output.path), output.name);
        if (!free && is_standard_output(output.path))
            return usage_error(output.name + " - and " + at->second +
                               " -: one of them can go to standard output; give the other a file's name");
        if (!free)
            return refuse(output,
                          " is also " + at->second + ", which it would replace; give it a name of its own");
        if (outputs.existing == Existing::keep && is_taken(output.path))
            return refuse(output, " is there already; give another name, or --overwrite");
    }
    return {};
}

std::string message_with_options(const Error& error, const KnowsOption& knows) {
    std::string text = error.message, behind;
    for (const Hint& hint : error.hints) {
        const std::string option = spelling_of(hint).option;
        if (knows && option.starts_with("--") && !knows(option)) continue;
        if (&hint == &error.hints.front() && begins_with_name(text, option))
            text.insert(0, "--");
        else
            behind += (behind.empty() ? "" : ", ") + typed(option, hint.value);
    }
    if (behind.empty()) return text;
    if (!text.ends_with(')')) return text + " (" + behind + ')';
    text.back() = ';';  // avoids two pairs of brackets
    return text + ' ' + behind + ')';
}

std::string remark_with_options(const Remark& remark) {
    if (remark.hints.empty() && (!remark.is_guess || !remark.otherwise.empty()))
        return remark_in_words(remark);
    std::string options;
    const Hints anything{{Setting::scene_file}};  // the fallback if no option exists
    for (const Hint& hint : remark.hints.empty() ? anything : remark.hints) {
        const Spelling spelling = spelling_of(hint);
        options += options.empty() ? "" : " or ";
        options += typed(spelling.option, hint.value.empty() ? spelling.value : hint.value);
    }
    Remark with_options = remark;
    with_options.otherwise =
        remark.otherwise.empty() ? options + " says otherwise" : remark.otherwise + ": " + options;
    return remark_in_words(with_options);
}

std::vector<std::string> remarks_with_options(const std::vector<Remark>& remarks) {
    std::vector<std::string> words;
    for (const Remark& remark : remarks) words.push_back(remark_with_options(remark));
    return words;
}

std::string typed_options(const Hints& hints) {
    std::string words;
    for (const Hint& hint : hints) words += ' ' + typed(spelling_of(hint).option, hint.value);
    return words;
}

}  // namespace touchable
