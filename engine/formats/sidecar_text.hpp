#pragma once

// Plain texts beside pictures, as JSON: YAML, tables with a head line (Virtual KITTI's intrinsic.txt,
// odometry.csv), and lines of a name with its numbers (ScanNet's _info.txt, .ini, .conf, .toml). Pure
// functions, for any thread.

#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/checked_json.hpp"

namespace touchable {

/// The name in small letters and digits alone: fl_x, FL.x and flx are one name.
std::string bare_name(std::string_view name);

/// Digits of a stem, without zeros before them: the last ones, or of those the ones `from_end` before them;
/// empty: there are none.
std::string number_in(std::string_view stem, int from_end);

/// A table of numbers below a head line that names its columns.
struct NumberTable {
    std::vector<std::string> names{};         ///< bare ones
    std::vector<std::vector<double>> rows{};  ///< each as long as `names`, at most `most_table_rows`
    /// The column of the first of these names that is there; -1: none is.
    int column(std::initializer_list<const char*> wanted) const;
};
inline constexpr std::size_t most_table_rows = 1'000'000;

/// Columns between blanks, commas or semicolons; no rows where the text is no such table.
NumberTable table_in(std::string_view text);

/// Lines "name = numbers", "name: numbers" and "name numbers" as members, those below a line "[name]" within
/// that member; null where the text has none.
checked_json::Json members_in_lines(std::string_view text);

/// A text of JSON, XML or YAML as JSON; null where it is none of these. Of XML an element has its members,
/// its attributes unless it is a number or words, or a list of several of one name. Of YAML tags, anchors and
/// comments are passed over, of several documents the first is read, and what has a point in its name, such
/// as Camera.fx of ORB-SLAM, is a member of a member.
checked_json::Json json_in(std::string_view text);

}  // namespace touchable
