// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/picture_files.hpp"

#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/colour_video.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/organised_cloud.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_files = 10'000'000, most_entries = 1'000'000;
constexpr std::size_t largest_list = std::size_t{256} << 20;
constexpr const char* list_names[] = {"rgb.txt", "color.txt", "colour.txt", "depth.txt"};
constexpr const char* picture_extensions[] = {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".tif", ".tiff",
                                              ".pfm", ".dpt", ".exr",  ".npy", ".npz", ".h5",  ".hdf5"};

/// A file pattern with one field of digits, %d or %0Nd, which the scene has checked.
class Numbered {
public:
    explicit Numbered(const std::string& text) {
        const auto percent = text.find('%'), end = text.find('d', percent);
        before_ = text.substr(0, percent);
        if (end > percent + 1) digits_ = static_cast<std::size_t>(text[percent + 2] - '0');
        after_ = text.substr(end + 1);
    }
    fs::path file(const fs::path& folder, std::int64_t number) const {
        std::string field = std::to_string(number);
        if (field.size() < digits_) field.insert(0, digits_ - field.size(), '0');
        return folder / (before_ + field + after_);
    }
    /// Numbers of the existing files, from `first` on, in order.
    std::vector<std::int64_t> numbers(const fs::path& folder, std::int64_t first) const {
        std::vector<std::int64_t> found;
        const std::string before = (folder / before_).filename().string();
        std::error_code ignored;
        for (const auto& entry : fs::directory_iterator((folder / before_).parent_path() / "", ignored)) {
            const std::string name = entry.path().filename().string();
            if (!name.starts_with(before) || name.size() <= before.size() + after_.size()) continue;
            const std::size_t digits = name.size() - before.size() - after_.size();
            const auto number = parsed_as<std::int64_t>(std::string_view(name).substr(before.size(), digits));
            if (number && *number >= first && file(folder, *number).filename() == name)
                found.push_back(*number);
        }
        std::ranges::sort(found);
        return found;
    }

private:
    std::string before_, after_;
    std::size_t digits_ = 1;
};

std::string why_missing(const fs::path& file) {
    std::error_code ignored;
    return fs::exists(file, ignored) ? " is no regular file" : " is missing";
}

Error missing(const fs::path& file, std::string_view what, std::size_t frame, const std::string& more) {
    return input_error(file.string() + " (" + std::string(what) + ", frame " + std::to_string(frame) +
                       "):" + why_missing(file) + more);
}

/// A hint if depth's first picture is missing and later ones exist; otherwise empty.
std::string first_of(const fs::path& folder, const Numbered& pattern, std::int64_t expected) {
    const auto later = pattern.numbers(folder, expected);
    return later.empty() ? ""
                         : "; the first that is there is number " + std::to_string(later.front()) +
                               ": give folder.first";
}

/// Which numbers an ascending row leaves out from `expected` on, each `step` after the one before: "3, 7 to
/// 9".
std::string gaps_in(const std::vector<std::int64_t>& row, std::int64_t expected, std::int64_t step) {
    std::string gaps;
    for (const std::int64_t number : row) {
        if (number > expected) gaps += (gaps.empty() ? "" : ", ") + std::to_string(expected);
        if (number > expected + step) gaps += " to " + std::to_string(number - step);
        expected = number + step;
    }
    return gaps;
}

/// If depth's picture `expected` is missing and later ones of its row exist: which numbers are missing.
std::string beyond(const fs::path& folder, const Numbered& pattern, std::int64_t expected,
                   std::int64_t step) {
    auto later = pattern.numbers(folder, expected);
    std::erase_if(later, [&](std::int64_t number) { return (number - expected) % step != 0; });
    if (later.empty()) return "";
    return ", though later ones exist up to number " + std::to_string(later.back()) +
           "; missing numbers: " + printable(gaps_in(later, expected, step), 120);
}

Result<PictureFiles> numbered_files(const fs::path& folder, const FolderSource& source) {
    const Numbered pattern(source.depth);
    PictureFiles found;
    const std::int64_t step = source.step;
    for (std::int64_t number = source.first; source.count == 0 || number < source.first + step * source.count;
         number += step) {
        const fs::path file = pattern.file(folder, number);
        if (is_file(file)) {
            found.files.push_back(file);
            continue;
        }
        const bool is_first = number == source.first;
        if (is_first || source.count > 0)
            return missing(file, "depth", found.count(),
                           is_first && source.count == 0 ? first_of(folder, pattern, number) : "");
        const std::string later = beyond(folder, pattern, number, step);
        std::error_code ignored;
        if (!later.empty() || fs::exists(file, ignored))
            found.remark = "ends after " + std::to_string(found.count()) +
                           " frames: " + file.filename().string() + why_missing(file) + later;
        break;
    }
    return found;
}

/// Compares runs of digits as numbers, and all else by its bytes.
bool comes_before(const std::string& a, const std::string& b) {
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (!is_digit(a[i]) || !is_digit(b[j])) {
            if (a[i] != b[j]) return a[i] < b[j];
            ++i, ++j;
            continue;
        }
        while (i < a.size() && a[i] == '0') ++i;
        while (j < b.size() && b[j] == '0') ++j;
        std::size_t m = i, n = j;
        while (m < a.size() && is_digit(a[m])) ++m;
        while (n < b.size() && is_digit(b[n])) ++n;
        if (m - i != n - j) return m - i < n - j;
        if (const int order = a.compare(i, m - i, b, j, n - j)) return order < 0;
        i = m, j = n;
    }
    return a.size() - i < b.size() - j;
}

/// Whether words are digits, or two runs of them with a point between: a time.
bool is_picture_number(std::string_view words) {
    const auto point = words.find('.');
    if (point == std::string_view::npos) return is_digits(words);
    return is_digits(words.substr(0, point)) && is_digits(words.substr(point + 1));
}

/// The numbers in a name: runs of digits; two with a point between them are one number, a time.
struct NumbersInName {
    std::string form;  // the name, with a star for each number
    std::vector<std::string> numbers;
    std::vector<std::size_t> places;  // where each begins in the name
};

NumbersInName numbers_in_name(const std::string& name) {
    NumbersInName found;
    for (std::size_t at = 0; at < name.size();) {
        const std::size_t begin = at;
        while (is_digit(name[at])) ++at;
        if (at == begin) {
            found.form += name[at++];
            continue;
        }
        if (name[at] == '.' && is_digit(name[at + 1]))
            for (++at; is_digit(name[at]);) ++at;
        found.form += '*';
        found.numbers.push_back(name.substr(begin, at - begin));
        found.places.push_back(begin);
    }
    return found;
}

/// Which of several numbers orders names that are alike outside these: the first that is a time, else the
/// first that differs in all names. Nothing if none differs in all, or if in that order a number recurs after
/// others, as that of one of several cameras does.
std::optional<std::size_t> ordering_number(const std::vector<NumbersInName>& names) {
    const std::size_t count = names.front().numbers.size();
    const auto column = [&](std::size_t number) {
        std::vector<std::string> all;
        for (const NumbersInName& name : names) all.push_back(name.numbers[number]);
        return all;
    };
    const auto without_repeats = [](std::vector<std::string> all) {
        std::ranges::sort(all);
        all.erase(std::unique(all.begin(), all.end()), all.end());
        return all;
    };
    std::optional<std::size_t> time, counter;
    for (std::size_t number = count; number-- > 0;) {
        const auto all = column(number), different = without_repeats(all);
        const bool are_times =
            std::ranges::all_of(all, [](const auto& each) { return each.find('.') != std::string::npos; });
        if (different.size() == all.size()) counter = number;
        if (are_times && different.size() > 1) time = number;
    }
    if (!counter) return {};
    const std::size_t order = time.value_or(*counter);
    std::vector<std::size_t> places(names.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    // Equal ones are ordered by their other numbers, not by the folder's order.
    std::ranges::sort(places, [&](std::size_t a, std::size_t b) {
        const auto &one = names[a].numbers, &other = names[b].numbers;
        if (comes_before(one[order], other[order])) return true;
        return !comes_before(other[order], one[order]) && one < other;
    });
    for (std::size_t number = 0; number < count; ++number) {
        const auto all = column(number);
        std::size_t changes = 1;
        for (std::size_t k = 1; k < places.size(); ++k) changes += all[places[k]] != all[places[k - 1]];
        if (changes != without_repeats(all).size()) return {};
    }
    return order;
}

/// Replaces words with several numbers, such as a counter and a time, or a time and the device's ticks (NYU
/// Depth), by the number that orders them. Words that differ from most outside their numbers are left out. If
/// no number orders them, or no words begin and end with numbers, all stay unchanged.
void take_ordering_numbers(std::vector<std::pair<std::string, std::string>>& words_and_names) {
    std::map<std::string, std::vector<std::size_t>> forms;
    std::vector<NumbersInName> all;
    for (const auto& [words, _] : words_and_names) {
        all.push_back(numbers_in_name(words));
        if (all.back().form.starts_with('*') && all.back().form.ends_with('*'))
            forms[all.back().form].push_back(all.size() - 1);
    }
    if (forms.empty()) return;
    const auto& most =
        std::ranges::max_element(forms, {}, [](const auto& form) { return form.second.size(); })->second;
    std::vector<NumbersInName> names;
    for (const std::size_t k : most) names.push_back(all[k]);
    const auto order = names.size() > 1 ? ordering_number(names) : std::nullopt;
    if (!order) return;
    std::vector<std::pair<std::string, std::string>> taken;
    for (const std::size_t k : most) taken.emplace_back(all[k].numbers[*order], words_and_names[k].second);
    words_and_names = std::move(taken);
}

/// Hidden files are no pictures, whatever their names end with: macOS writes ._NAME beside each NAME.
bool is_hidden(const std::string& name) {
    return name.starts_with(".");
}

/// Files of a star pattern. The star stands for a number, or several with words between
/// (take_ordering_numbers). If no file has a number there, as only a scene file's pattern allows, it stands
/// for any words.
Result<PictureFiles> starred_files(const fs::path& folder, const std::string& pattern) {
    const fs::path within = (folder / pattern).parent_path();
    const std::string name = fs::path(pattern).filename().string();
    const auto star = name.find('*');
    if (star == std::string::npos)
        return input_error((folder / pattern).string() + ": its star must be in the name of a file");
    const std::string before = name.substr(0, star), after = name.substr(star + 1);
    std::vector<std::pair<std::string, std::string>> names;  // what the star stands for, and the name
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator(within, failure)) {
        const std::string other = entry.path().filename().string();
        if (is_hidden(other) || other.size() < before.size() + after.size() || !other.starts_with(before) ||
            !other.ends_with(after) || !is_file(entry.path()))
            continue;
        names.emplace_back(other.substr(before.size(), other.size() - before.size() - after.size()), other);
        if (names.size() > most_files) return input_error(within.string() + ": has too many files");
    }
    if (names.empty()) return input_error((folder / pattern).string() + ": no file has such a name");
    const auto has_number = [](const auto& each) { return is_picture_number(each.first); };
    if (std::ranges::any_of(names, has_number))
        std::erase_if(names, std::not_fn(has_number));
    else
        take_ordering_numbers(names);
    std::ranges::sort(names, [](const auto& one, const auto& other) {
        if (comes_before(one.first, other.first)) return true;
        return !comes_before(other.first, one.first) && one.second < other.second;
    });
    if (std::ranges::all_of(names, [](const auto& each) { return parsed_number(each.first).has_value(); }))
        std::ranges::stable_sort(names, {}, [](const auto& each) { return parsed_number(each.first); });
    PictureFiles found;
    for (const auto& [what, file] : names) {
        found.files.push_back(within / file);
        if (const auto key = parsed_number(what)) found.keys.push_back(*key);
        found.has_decimals |= what.find('.') != std::string::npos;
    }
    if (found.keys.size() != found.files.size() || !std::ranges::is_sorted(found.keys)) found.keys.clear();
    return found;
}

/// Reads lines "time name" or "name", with comments after '#'; names are relative to the list's folder.
Result<PictureFiles> listed_files(const fs::path& list) {
    TRY_ASSIGN(auto text, read_given_file(list, list.string(), "a list of pictures", largest_list));
    std::istringstream in(std::move(text));
    PictureFiles found;
    found.list = list;
    std::size_t number = 0;
    for (std::string line; std::getline(in, line);) {
        const std::string where = list.string() + ", line " + std::to_string(++number) + ": ";
        if (line.size() > 4096) return input_error(where + "is too long");
        std::istringstream words(line.substr(0, line.find('#')));
        std::string first, second;
        if (!(words >> first)) continue;
        const bool has_time = static_cast<bool>(words >> second);
        const auto time = parsed_number(first);
        if (has_time && !time) return input_error(where + "must be a time in seconds and a file's name");
        found.files.push_back(list.parent_path() / (has_time ? second : first));
        if (has_time) found.keys.push_back(*time);
        found.has_decimals |= has_time && first.find('.') != std::string::npos;
        if (const fs::path& file = found.files.back(); !is_file(file))
            return input_error(where + printable(file.string()) + why_missing(file));
        if (found.count() > most_files) return input_error(list.string() + ": has too many lines");
    }
    if (found.files.empty()) return input_error(list.string() + ": names no picture");
    if (found.keys.size() != found.files.size()) found.keys.clear();
    if (!std::ranges::is_sorted(found.keys))
        return input_error(list.string() + ": its times must not go backward");
    return found;
}

/// Seconds of a key that is 1; nothing if keys only count.
std::optional<double> seconds_per_key(const PictureFiles& pictures) {
    const std::vector<double>& keys = pictures.keys;
    if (keys.size() < 2) return {};
    // Small whole numbers only count.
    if (const double unit = seconds_of_stamp(keys.back()); unit < 1) return unit;
    const auto counts = [](double key) { return key == std::floor(key); };
    if (!pictures.has_decimals && std::ranges::all_of(keys, counts)) return {};
    return 1;
}

/// Seconds of the pictures, after the first one or of the day; empty if keys only count.
std::vector<double> seconds_of(const PictureFiles& pictures, bool after_first = true) {
    std::vector<double> seconds;
    if (const auto unit = seconds_per_key(pictures))
        for (const double key : pictures.keys)
            seconds.push_back((key - (after_first ? pictures.keys.front() : 0)) * *unit);
    return seconds;
}

/// Says which numbers are missing in a row of evenly counted files; empty if no two are one step apart, as of
/// chosen frames, and for times.
std::string gaps_of(const PictureFiles& found, const std::string& pattern) {
    if (found.count() < 3 || found.keys.empty() || found.has_decimals || seconds_per_key(found)) return "";
    constexpr double largest = 1e15;  // whole numbers, exactly
    if (found.keys.front() < -largest || found.keys.back() > largest) return "";
    const std::vector<std::int64_t> row(found.keys.begin(), found.keys.end());
    std::int64_t step = 0;
    for (std::size_t n = 1; n < row.size(); ++n) step = std::gcd(step, row[n] - row[n - 1]);
    const auto is_next = [&](std::int64_t number, std::int64_t next) { return next - number == step; };
    const std::string gaps = step > 0 ? gaps_in(row, row.front(), step) : "";
    if (gaps.empty() || std::ranges::adjacent_find(row, is_next) == row.end()) return "";
    return pattern + ": missing numbers: " + printable(gaps, 120);
}

/// Says which two pictures have nearly the same time, as no two frames can; otherwise empty.
std::string close_times(const PictureFiles& found, const std::string& pattern) {
    const auto unit = seconds_per_key(found);
    constexpr double shortest_seconds = 1e-9 * shortest_frame_ns;
    for (std::size_t n = 1; unit && n < found.keys.size(); ++n)
        if ((found.keys[n] - found.keys[n - 1]) * *unit < shortest_seconds)
            return pattern + ": the times of " + printable(found.files[n - 1].filename().string()) + " and " +
                   printable(found.files[n].filename().string()) +
                   " are less than 1 ms apart: all are taken evenly, at their mean rate";
    return "";
}

/// A remark on missing numbers or impossible times; empty: none.
std::string row_remark(const PictureFiles& found, const std::string& pattern) {
    return rate_of(found) ? close_times(found, pattern) : gaps_of(found, pattern);
}

/// The rate of frames that are `step` seconds apart: a whole number a second if it is nearly one.
FrameRate rate_of_step(double step) {
    const double rate = 1 / step, whole = std::round(rate);
    if (whole >= 1 && std::abs(rate - whole) < 0.015 * whole) return {static_cast<std::int64_t>(whole), 1};
    return {static_cast<std::int64_t>(std::round(1000 * rate)), 1000};
}

/// Nanoseconds after the first; empty if times are too far apart to be real.
std::vector<std::int64_t> nanoseconds(const std::vector<double>& seconds) {
    constexpr double ns_per_second = 1e9, longest_seconds = 4e9;
    std::vector<std::int64_t> ns;
    for (const double second : seconds) {
        const double after = second - seconds.front();
        if (!(after < longest_seconds)) return {};
        ns.push_back(std::llround(after * ns_per_second));
    }
    return ns;
}

bool keeps_to(const FrameRate& rate, const std::vector<double>& seconds) {
    constexpr double tolerance = 0.002;  // rounding to milliseconds, twice
    for (std::size_t n = 0; n < seconds.size(); ++n) {
        const double even = static_cast<double>(rate.time_ns(static_cast<std::int64_t>(n))) * 1e-9;
        if (!(std::fabs(seconds[n] - seconds[0] - even) <= tolerance)) return false;
    }
    return true;
}

/// Says which of depth's numbers no file of another plane has; empty for times.
std::string unpaired(const PictureFiles& found, const PictureFiles& depth, std::string_view what) {
    for (const PictureFiles* row : {&found, &depth})
        if (row->has_decimals || seconds_per_key(*row)) return "";
    std::string numbers;
    for (const double key : depth.keys)
        if (!std::ranges::binary_search(found.keys, key))
            numbers += (numbers.empty() ? "" : ", ") + formatted("%.0f", key);
    if (numbers.empty()) return "";
    return std::string(what) +
           ": missing numbers that depth has; those frames get the nearest one's: " + printable(numbers, 120);
}

/// Pairs the files of a plane, or of the cameras, with depth's, by their `pattern` and their `own` numbers.
Result<PictureFiles> paired_files(const fs::path& folder, std::string_view what, const std::string& pattern,
                                  const PictureNumbers& own, const FolderSource& source,
                                  const PictureFiles& depth) {
    PictureFiles beside;
    if (is_numbered(pattern)) {
        const Numbered numbered(pattern);
        const std::int64_t first = own.first.value_or(source.first), step = own.step.value_or(source.step);
        for (std::size_t frame = 0; frame < depth.count(); ++frame) {
            beside.files.push_back(numbered.file(folder, first + step * static_cast<std::int64_t>(frame)));
            if (!is_file(beside.files.back())) return missing(beside.files.back(), what, frame, "");
        }
        return beside;
    }
    if (is_still(pattern)) {
        if (!is_file(folder / pattern)) return missing(folder / pattern, what, 0, "");
        beside.files.push_back(folder / pattern);
        beside.frames = depth.count();
        return beside;
    }
    TRY_ASSIGN(const auto found, found_files(folder, pattern));
    beside.list = found.list;
    const bool by_key = !found.keys.empty() && !depth.keys.empty();
    for (std::size_t frame = 0; frame < (by_key ? depth.keys.size() : std::min(found.count(), depth.count()));
         ++frame)
        beside.files.push_back(found.files[by_key ? nearest_key(found.keys, depth.keys[frame]) : frame]);
    beside.frames = depth.count();
    if (by_key) beside.remark = unpaired(found, depth, what);
    if (!by_key && found.count() != depth.count())
        beside.remark = std::string(what) + " has " + std::to_string(found.count()) + " files for depth's " +
                        std::to_string(depth.count()) + ": paired in their order, from the first on";
    return beside;
}

bool is_picture(const fs::path& file) {
    return std::ranges::count(picture_extensions, small_letters(file.extension().string())) > 0;
}

/// A name with a star for one of its numbers before the extension, 0 being the last: a run of digits, or two
/// with a point between them. Nothing if the name has fewer.
std::optional<std::string> starred(const std::string& name, int number) {
    std::size_t end = name.rfind('.');
    if (end == std::string::npos) return {};
    while (true) {
        while (end > 0 && !is_digit(name[end - 1])) --end;
        if (end == 0) return {};
        const auto run_before = [&](std::size_t k) {
            while (k > 0 && is_digit(name[k - 1])) --k;
            return k;
        };
        std::size_t begin = run_before(end);
        if (begin > 1 && name[begin - 1] == '.' && is_digit(name[begin - 2])) begin = run_before(begin - 1);
        if (number-- == 0) return name.substr(0, begin) + "*" + name.substr(end);
        end = begin;
    }
}

/// Whether a file is named as an array of cameras' matrices: it is no picture, in any folder.
bool is_named_camera_array(const fs::path& file) {
    const std::string extension = small_letters(file.extension().string()),
                      stem = small_letters(file.stem().string());
    if (extension != ".npy" && extension != ".npz") return false;
    constexpr const char* names[] = {"k", "cam", "cams", "camera", "cameras"};
    return std::ranges::count(names, stem) > 0 ||
           (!has_word(stem, {"depth"}) &&
            has_word(stem, {"intrinsic", "extrinsic", "pose", "calib", "camk", "cam_k", "c2w", "w2c"}));
}

using Wanted = bool (*)(const fs::path&);

void add_files(const fs::path& folder, const std::string& within, Wanted is_wanted,
               std::map<std::string, PictureGroup>& groups, std::size_t& entries) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder / within, ignored)) {
        if (++entries > most_entries) return;
        const std::string name = entry.path().filename().string();
        std::error_code failure;
        if (is_hidden(name) || name.find_first_of("%*") != std::string::npos || !is_wanted(name) ||
            !entry.is_regular_file(failure))
            continue;
        PictureGroup& group = groups[within + starred(name, 0).value_or(name)];
        if (group.count++ == 0 || entry.path() < group.first) group.first = entry.path();
    }
}

/// Groups files whose last number is the same in all by a number before it: 0001_depth16.png.
void join_by_earlier_numbers(std::map<std::string, PictureGroup>& groups) {
    constexpr int most_numbers = 8;
    for (int number = 1; number < most_numbers; ++number) {
        std::map<std::string, std::vector<std::string>> joined;  // which groups of one file become one
        for (const auto& [pattern, group] : groups) {
            if (group.count > 1) continue;
            if (const auto name = starred(group.first.filename().string(), number))
                joined[(fs::path(pattern).parent_path() / *name).string()].push_back(pattern);
        }
        for (const auto& [pattern, singles] : joined) {
            if (singles.size() < 2) continue;
            PictureGroup& group = groups[pattern];
            for (const std::string& single : singles) {
                const PictureGroup& one = groups[single];
                if (group.count++ == 0 || one.first < group.first) group.first = one.first;
                groups.erase(single);
            }
        }
    }
}

/// The pattern of names that are alike outside their numbers: one star from the first number that differs to
/// the last.
std::string pattern_of_all(const std::vector<NumbersInName>& names, const std::string& first) {
    const auto differs = [&](std::size_t number) {
        return std::ranges::any_of(names, [&](const NumbersInName& name) {
            return name.numbers[number] != names.front().numbers[number];
        });
    };
    std::size_t begin = 0, last = names.front().numbers.size() - 1;
    while (begin < last && !differs(begin)) ++begin;
    while (last > begin && !differs(last)) --last;
    const auto& [form, numbers, places] = names.front();
    return first.substr(0, places[begin]) + '*' + first.substr(places[last] + numbers[last].size());
}

/// Joins files in which several numbers change, so that a star for only one makes many small groups, into one
/// group if one of the numbers orders them.
void join_by_all_numbers(const fs::path& folder, std::map<std::string, PictureGroup>& groups) {
    std::map<std::string, std::vector<std::string>> forms;  // patterns of groups alike outside all numbers
    for (const auto& [pattern, group] : groups) {
        const fs::path within = fs::path(pattern).parent_path();
        forms[(within / numbers_in_name(group.first.filename().string()).form).string()].push_back(pattern);
    }
    std::erase_if(forms, [&](const auto& form) {
        std::size_t largest = 0;
        for (const std::string& pattern : form.second) largest = std::max(largest, groups[pattern].count);
        return form.second.size() < std::max<std::size_t>(largest, 2);
    });
    struct Alike {
        std::vector<std::string> files{};
        std::vector<NumbersInName> names{};  // of these files
    };
    std::map<std::string, Alike> files_of;  // by form
    std::set<fs::path> read;                // a folder may have many forms, and is read once
    std::size_t entries = 0;
    for (const auto& [form, patterns] : forms) {
        const fs::path within = fs::path(form).parent_path();
        if (!read.insert(within).second) continue;
        std::error_code ignored;
        for (const auto& entry : fs::directory_iterator(folder / within / "", ignored)) {
            if (++entries > most_entries || stop_requested()) return;
            const std::string name = entry.path().filename().string();
            NumbersInName numbers = numbers_in_name(name);
            const std::string of = (within / numbers.form).string();
            const bool is_pattern = name.find_first_of("%*") != std::string::npos;
            if (is_pattern || !forms.contains(of) || !is_file(entry.path())) continue;
            files_of[of].files.push_back(name);
            files_of[of].names.push_back(std::move(numbers));
        }
    }
    for (const auto& [form, alike] : files_of) {
        const auto& [files, names] = alike;
        if (names.size() < 2 || !ordering_number(names)) continue;
        const fs::path within = fs::path(form).parent_path();
        const std::string pattern = (within / pattern_of_all(names, files.front())).string();
        if (groups.contains(pattern)) continue;
        PictureGroup joined;
        joined.count = files.size();
        joined.first = folder / within / *std::ranges::min_element(files);
        for (const std::string& each : forms[form]) groups.erase(each);
        groups[pattern] = std::move(joined);
    }
}

/// The folders in `folder / within`, each with its slash.
std::vector<std::string> folders_in(const fs::path& folder, const std::string& within, std::size_t& entries) {
    std::vector<std::string> found;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder / within, ignored)) {
        if (++entries > most_entries) break;
        const std::string name = entry.path().filename().string();
        // A pattern would read % and * of a folder's name as its own.
        const bool is_pattern = name.find_first_of("%*") != std::string::npos;
        if (!is_hidden(name) && !is_pattern && entry.is_directory(ignored))
            found.push_back(within + name + '/');
    }
    return found;
}

/// The groups in the folder and its subfolders, largest first; if these have none, those in their subfolders
/// (depth/Camera_0 of Virtual KITTI).
std::vector<PictureGroup> groups_of(const fs::path& folder, Wanted is_wanted) {
    std::map<std::string, PictureGroup> found;
    std::size_t entries = 0;
    add_files(folder, "", is_wanted, found, entries);
    std::vector<std::string> level = folders_in(folder, "", entries);
    for (const std::string& within : level) add_files(folder, within, is_wanted, found, entries);
    if (found.empty())
        for (const std::string& within : level)
            for (const std::string& deeper : folders_in(folder, within, entries))
                add_files(folder, deeper, is_wanted, found, entries);
    join_by_earlier_numbers(found);
    join_by_all_numbers(folder, found);
    std::vector<PictureGroup> groups;
    for (auto& [pattern, group] : found) {
        group.pattern = group.count > 1 ? pattern : group.first.lexically_relative(folder).string();
        groups.push_back(std::move(group));
    }
    std::ranges::stable_sort(groups, std::greater(), &PictureGroup::count);
    return groups;
}

/// Folders two levels above pictures too deep for a search of `folder`, which goes two levels down.
std::set<fs::path> folders_further_down(const fs::path& folder) {
    constexpr int deepest = 5;
    constexpr std::size_t most_looked_at = 100'000, most_folders = 100;
    std::set<fs::path> found;
    std::size_t entries = 0;
    std::error_code failure;
    for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, failure),
         end;
         !failure && at != end && ++entries < most_looked_at && found.size() < most_folders;
         at.increment(failure)) {
        if (at.depth() >= deepest) at.disable_recursion_pending();
        std::error_code ignored;
        if (is_hidden(at->path().filename().string())) {
            at.disable_recursion_pending();
            continue;
        }
        if (at.depth() > 2 && is_picture(at->path()) && at->is_regular_file(ignored))
            found.insert(at->path().parent_path().parent_path().parent_path());
    }
    return found;
}

}  // namespace

bool is_list(const std::string& pattern) {
    return pattern.ends_with(".txt") && pattern.find('*') == std::string::npos;
}

Result<PictureFiles> depth_files(const fs::path& folder, const FolderSource& source) {
    if (is_numbered(source.depth)) return numbered_files(folder, source);
    if (is_still(source.depth)) {
        if (!is_file(folder / source.depth)) return missing(folder / source.depth, "depth", 0, "");
        return PictureFiles{{folder / source.depth}, {}, false, {}, {}};
    }
    TRY_ASSIGN(auto found, found_files(folder, source.depth));
    const auto first = std::min<std::size_t>(static_cast<std::size_t>(source.first), found.count());
    const auto keep = [&](auto& values) {
        if (values.empty()) return;
        values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(first));
        if (source.count > 0 && values.size() > static_cast<std::size_t>(source.count))
            values.resize(static_cast<std::size_t>(source.count));
    };
    keep(found.files);
    keep(found.keys);
    if (found.files.empty())
        return input_error((folder / source.depth).string() + ": has no picture from folder.first on");
    found.remark = row_remark(found, source.depth);
    return found;
}

Result<PictureFiles> files_beside(const fs::path& folder, PlaneRole role, const FolderSource& source,
                                  const PictureFiles& depth) {
    return paired_files(folder, role_name(role), pattern_of(source, role), numbers_of(source, role), source,
                        depth);
}

Result<PictureFiles> camera_files(const fs::path& folder, const FolderSource& source,
                                  const PictureFiles& depth) {
    return paired_files(folder, "cameras", source.cameras, source.camera_numbers, source, depth);
}

Result<PictureFiles> found_files(const fs::path& folder, const std::string& pattern) {
    auto found = is_list(pattern) ? listed_files(folder / pattern) : starred_files(folder, pattern);
    if (found) found->remark = row_remark(*found, pattern);
    return found;
}

std::size_t nearest_key(const std::vector<double>& keys, double key) {
    const auto after = std::ranges::lower_bound(keys, key);
    if (after == keys.begin()) return 0;
    if (after == keys.end()) return keys.size() - 1;
    const auto n = static_cast<std::size_t>(after - keys.begin());
    return keys[n] - key < key - keys[n - 1] ? n : n - 1;
}

double seconds_of_stamp(double stamp) {
    constexpr double ticks = 1e-7;  // since the year 1 (.NET) or 1601 (Windows)
    constexpr std::pair<double, double> units[] = {{1e18, 1e-9}, {1e17, ticks}, {1e14, 1e-6}, {1e11, 1e-3}};
    for (const auto& [least, unit] : units)
        if (stamp > least) return unit;
    return 1;
}

std::optional<FrameRate> rate_of_seconds(const std::vector<double>& seconds) {
    if (seconds.size() < 2) return {};
    std::vector<double> steps;
    for (std::size_t n = 1; n < seconds.size(); ++n) steps.push_back(seconds[n] - seconds[n - 1]);
    const double mean = (seconds.back() - seconds.front()) / static_cast<double>(steps.size());
    const double middle = sorted_element(steps, steps.size() / 2);
    const auto is_step = [](double step) { return step > 1e-3 && step < 100; };
    if (is_step(middle))
        if (const FrameRate even = rate_of_step(middle); keeps_to(even, seconds)) return even;
    if (auto own = rate_of_own_times(nanoseconds(seconds))) return own;
    return is_step(mean) ? std::optional(rate_of_step(mean)) : std::nullopt;
}

std::vector<double> seconds_of_day(const PictureFiles& pictures) {
    return seconds_of(pictures, false);
}

std::optional<FrameRate> rate_of(const PictureFiles& pictures) {
    return rate_of_seconds(seconds_of(pictures));
}

std::string unusable_times(const PictureFiles& pictures) {
    if (pictures.list.empty() || pictures.keys.size() < 2 || rate_of(pictures)) return "";
    const std::string list = "the times of " + printable(pictures.list.filename().string()) + " are ";
    const auto seconds = seconds_of(pictures);
    if (seconds.empty())
        return list +
               "whole numbers that only count (times are seconds with a point, or milli-, micro- or "
               "nanoseconds since 1970, or ticks of 100 ns)";
    const double mean = seconds.back() / static_cast<double>(seconds.size() - 1);
    return list + short_number(mean) + " s apart on average, as no frames are (times are seconds)";
}

std::optional<FrameRate> own_rate_of(const PictureFiles& pictures) {
    const auto seconds = seconds_of(pictures);
    auto own = rate_of_own_times(nanoseconds(seconds));
    return own ? own : rate_of_seconds(seconds);
}

std::vector<PictureGroup> picture_groups(const fs::path& folder) {
    std::vector<PictureGroup> groups = groups_of(folder, [](const fs::path& file) {
        return is_named_as_picture(file) && !is_named_camera_array(file);
    });
    const auto is_cloud = [](const PictureGroup& group) { return is_named_cloud(group.first); };
    std::erase_if(groups, [&](const PictureGroup& group) {
        return is_cloud(group) && !is_organised_cloud(SourceFile(group.first));
    });
    std::stable_partition(groups.begin(), groups.end(), std::not_fn(is_cloud));
    // TUM's lists pair pictures by their times.
    for (const char* list : list_names)
        if (is_file(folder / list))
            if (const auto listed = found_files(folder, list); listed && is_picture(listed->files.front()))
                groups.insert(groups.begin(), {list, listed->files.front(), listed->count()});
    return groups;
}

std::vector<PictureGroup> camera_groups(const fs::path& folder) {
    return groups_of(folder, [](const fs::path& file) { return file.extension() == ".pincam"; });
}

std::vector<PictureGroup> hdf5_groups(const fs::path& folder) {
    auto groups = groups_of(folder, [](const fs::path& file) { return !is_named_as_picture(file); });
    std::erase_if(groups, [](const PictureGroup& group) { return !is_hdf5_file(SourceFile(group.first)); });
    return groups;
}

std::vector<PictureGroup> camera_arrays(const fs::path& folder) {
    return groups_of(folder, is_named_camera_array);
}

std::vector<std::string> unusable_lists(const fs::path& folder) {
    std::vector<std::string> remarks;
    for (const char* list : list_names)
        if (is_file(folder / list))
            if (const auto listed = found_files(folder, list); !listed)
                remarks.push_back(std::string(list) + " is not used: " + listed.error().message);
    return remarks;
}

std::string found_elsewhere(const fs::path& folder) {
    std::set<fs::path> videos;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
        if (!is_hidden(entry.path().filename().string()) && is_named_as_clip(entry.path()))
            videos.insert(entry.path());
    if (!videos.empty()) {
        const auto named = std::ranges::find_if(videos, is_named_as_depth_video);
        return std::string("but ") + (videos.size() == 1 ? "a video" : "videos") + ": touchable play " +
               shell_word((named == videos.end() ? videos.begin() : named)->string());
    }
    const std::set<fs::path> folders = folders_further_down(folder);
    if (folders.empty()) return "";
    return std::string("but a folder further down has pictures: touchable play ") +
           shell_word(folders.begin()->string()) +
           (folders.size() > 1 ? " (one of " + std::to_string(folders.size()) + " such folders)" : "");
}

std::string folder_of(const PictureGroup& group) {
    const fs::path within = fs::path(group.pattern).parent_path();
    return within.empty() ? "" : within.string() + '/';
}

bool is_named_as_picture(const fs::path& file) {
    return is_picture(file) || is_named_cloud(file);
}

bool is_file(const fs::path& file) {
    std::error_code ignored;
    return fs::is_regular_file(file, ignored);
}

bool has_word(const std::string& name, std::initializer_list<const char*> words) {
    const std::string small = small_letters(name);
    return std::ranges::any_of(words,
                               [&](const char* word) { return small.find(word) != std::string::npos; });
}

}  // namespace touchable
