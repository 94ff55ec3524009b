#include "player/commands/kiosk_options.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <system_error>

#include "engine/authoring/segments.hpp"
#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

/// A folder of what comes with the program, where it was built and where it is installed.
fs::path folder_from_program(const char* way) {
    std::error_code fault;
    const fs::path program = fs::read_symlink("/proc/self/exe", fault);
    return (program.parent_path() / way).lexically_normal();
}
fs::path folder_of_texts() {
    return folder_from_program(TOUCHABLE_KIOSK_FROM_PROGRAM);
}
fs::path folder_of_studies() {
    return folder_from_program(TOUCHABLE_STUDY_FROM_PROGRAM);
}

/// What there is in such a folder.
std::string names_there(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code failed;
    for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed))
        if (at->path().extension() == ".json") names.push_back(at->path().stem().string());
    std::ranges::sort(names);
    std::string words;
    for (const std::string& name : names) words += (words.empty() ? "" : ", ") + name;
    return words;
}

Result<KioskTexts> read_texts_of(const fs::path& file, const std::string& named) {
    TRY_ASSIGN(const auto text, read_given_file(file, named, "a file of a kiosk's texts (docs/exhibit.md)",
                                                largest_kiosk_texts));
    return parse_kiosk_texts(text, file.string());
}

/// `asked`: a language or a file; empty: the language of whoever is logged in, as far as there are texts.
Result<KioskTexts> choose_texts(const std::string& asked) {
    const std::string language = asked.empty() ? own_language() : asked;
    if (!is_language(language)) return read_texts_of(asked, "--kiosk-texts " + asked);
    const fs::path file = folder_of_texts() / (language + ".json");
    std::error_code failed;
    if (fs::exists(file, failed)) return read_texts_of(file, file.string());
    if (asked.empty() || language == KioskTexts().language) return KioskTexts();
    return usage_error("--kiosk-texts " + asked +
                       ": there are texts in these languages: " + names_there(folder_of_texts()) +
                       "; right would be one of them, or the name of a file");
}

Result<TouchLabels> read_labels(const fs::path& file, const std::optional<fs::path>& segments) {
    TRY_ASSIGN(const auto text, read_given_file(file, "--labels " + file.string(),
                                                "a file of labels (docs/exhibit.md)", largest_labels));
    auto labels = parse_touch_labels(text, file.string(), file.parent_path());
    if (!labels.ok()) return labels;
    std::vector<std::string> names;
    if (segments) {
        TRY_ASSIGN(const auto named, read_given_file(*segments, "--segments " + segments->string(),
                                                     "a file of segments", largest_segment_names));
        TRY_ASSIGN(const auto parsed, parse_segment_names(named, segments->string()));
        for (const NamedSegment& segment : parsed.segments) names.push_back(segment.name);
    }
    if (auto there = labels->has_segments(names); !there.ok())
        return input_error(there.error().message + "; right would be a name in the file of --segments");
    return labels;
}

/// Each file once, however many labels have it.
Result<void> read_sounds(KioskOptions& kiosk) {
    std::map<fs::path, std::shared_ptr<const SpokenSound>> read;
    for (const TouchLabel& label : kiosk.labels.labels) {
        const fs::path* const file = said_in(label.sounds, kiosk.texts.language);
        if (file && !read.contains(*file)) {
            TRY_ASSIGN(auto sound, SpokenSound::read(*file));
            read.emplace(*file, std::move(sound));
        }
        kiosk.label_sounds.push_back(file ? read.at(*file) : nullptr);
    }
    return {};
}

}  // namespace

std::vector<const char*> kiosk_option_names() {
    return {"--kiosk",  "--idle",    "--kiosk-texts", "--kiosk-bar",
            "--labels", "--use-log", "--study",       "--results"};
}

void add_kiosk_options(CLI::App& sub, KioskWords& words) {
    auto* const kiosk =
        sub.add_flag("--kiosk", words.kiosk,
                     "for a place where nobody watches over it: full screen, again and again, an "
                     "invitation to touch, and nothing that ends it (docs/exhibit.md)")
            ->excludes("--record")
            ->excludes("--settings")
            ->excludes("--brush-history");
    add_number_option(sub, "--idle", words.idle,
                      "two times in seconds: how long nobody touches a kiosk until it invites to, and until "
                      "it begins anew; 20 60 where they are left out",
                      0.1, 1e6)
        ->expected(2)
        ->needs(kiosk);
    sub.add_option(
           "--kiosk-texts", words.texts,
           "what a kiosk says: a language that comes with the program (en, de), or a file of texts; left "
           "out: this person's language (docs/exhibit.md)")
        ->needs(kiosk)
        ->type_name("LANGUAGE|FILE");
    sub.add_option(
           "--kiosk-bar", words.bar,
           "whether visitors of a kiosk have a bar of large buttons: on, as where it is left out, or off")
        ->needs(kiosk)
        ->check(CLI::IsMember({"on", "off"}));
    add_file_option(sub, "--labels", words.labels,
                    "captions and sounds of places of the clip, which a kiosk shows and plays where a finger "
                    "rests (docs/exhibit.md)")
        ->needs(kiosk);
    add_file_option(sub, "--use-log", words.use_log,
                    "a table, CSV, to which a kiosk adds each visit and each fault")
        ->needs(kiosk);
    auto* const study = sub.add_option("--study", words.study,
                                       "what participants of a study read, touch and answer: one that comes "
                                       "with the program (paper-4.2), or a file (docs/usability.md)")
                            ->needs(kiosk)
                            ->excludes("--labels")
                            ->excludes("--kiosk-bar")
                            ->excludes("--idle")
                            ->type_name("NAME|FILE");
    auto* const results = sub.add_option("--results", words.results,
                                         "the folder that gets a table, CSV, of each participant of --study")
                              ->needs(study)
                              ->type_name("FOLDER");
    study->needs(results);
}

Result<std::optional<KioskOptions>> read_kiosk(const KioskWords& words,
                                               const std::optional<fs::path>& segments) {
    if (!words.kiosk) return std::optional<KioskOptions>();
    if (!words.idle.empty() && words.idle[1] < words.idle[0])
        return usage_error(
            "--idle: a kiosk begins anew, the second time, no sooner than it invites, the first");
    KioskOptions kiosk;
    if (!words.idle.empty()) kiosk.times = {words.idle[0], words.idle[1]};
    TRY_ASSIGN(auto texts, choose_texts(words.texts));
    kiosk.texts = std::move(texts);
    kiosk.touched_by = has_touch_screen() ? TouchedBy::touch_screen : TouchedBy::mouse;
    if (words.labels) {
        TRY_ASSIGN(auto labels, read_labels(*words.labels, segments));
        kiosk.labels = std::move(labels);
        TRY(read_sounds(kiosk));
    }
    kiosk.has_bar = words.bar != "off";
    kiosk.use_log = words.use_log;
    return std::optional(std::move(kiosk));
}

Result<std::optional<StudyOptions>> read_study(const KioskWords& words, std::size_t clips) {
    if (words.study.empty()) return std::optional<StudyOptions>();
    fs::path file = words.study;
    std::error_code failed;
    if (const fs::path known = folder_of_studies() / (words.study + ".json");
        file.filename() == file && !fs::exists(file, failed) && fs::exists(known, failed))
        file = known;
    const std::string named = "--study " + words.study;
    if (!fs::exists(file, failed) && file.extension() != ".json")
        return usage_error(named + ": there are these studies: " + names_there(folder_of_studies()) +
                           "; right would be one of them, or the name of a file");
    TRY_ASSIGN(const auto text,
               read_given_file(file, named, "a study (JSON, docs/usability.md)", largest_study));
    TRY_ASSIGN(auto study, parse_study(text, file.string()));
    if (study.clips() > clips)
        return usage_error(named + ": has a touch of clip " + std::to_string(study.clips()) +
                           ", and there are " + std::to_string(clips) +
                           "; right would be as many CLIPs as the study has");
    return std::optional(StudyOptions{std::move(study), *words.results});
}

}  // namespace touchable
