// SPDX-License-Identifier: Apache-2.0
#pragma once

// Plain texts beside pictures, as JSON: YAML, tables with a head line (Virtual KITTI's intrinsic.txt,
// odometry.csv), and lines of a name with its numbers (ScanNet's _info.txt, .ini, .conf, .toml). Pure
// functions, for any thread.

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/checked_json.hpp"

namespace touchable {

inline bool is_any_of(std::string_view name, std::initializer_list<std::string_view> known) {
    return std::ranges::find(known, name) != known.end();
}

/// The rest of the first line that begins so: "WIDTH 640" gives "640"; nothing if there is none.
std::optional<std::string_view> line_after(std::string_view text, const std::string& begin);

/// The name in small letters and digits alone: fl_x, FL.x and flx are one name.
std::string bare_name(std::string_view name);

/// The words of a name in small letters: its runs of letters.
std::vector<std::string> words_in_name(std::string_view name);
/// Whether one of these words begins so or, with a space behind it, is so: "disp " is in "disp0.pfm" and
/// "disp_occ/1.png", not in "display.png".
bool has_beginning(std::string_view name, std::initializer_list<std::string_view> beginnings);

/// A number in a stem, without leading zeros: the last run of digits, or the one `from_end` runs before it;
/// empty: there is none.
std::string number_in(std::string_view stem, int from_end);

/// A table of numbers below a head line that names its columns.
struct NumberTable {
    std::vector<std::string> names{};         ///< bare names
    std::vector<std::vector<double>> rows{};  ///< each as long as `names`, at most `most_table_rows`
    /// Index of the column that has the first of these names found; -1: none is found.
    int column(std::initializer_list<const char*> wanted) const;
};
inline constexpr std::size_t most_table_rows = 1'000'000;

/// Parses columns separated by blanks, commas or semicolons; no rows if the text is no such table.
NumberTable table_in(std::string_view text);

/// Lines "name = numbers", "name: numbers" and "name numbers" as members, those below a line "[name]" within
/// that member; null if the text has none.
checked_json::Json members_in_lines(std::string_view text);

/// Parses JSON, XML or YAML into JSON; null if the text is none of these. An XML element becomes its members,
/// with its attributes unless it holds numbers or words; several of one name become a list. In YAML, tags,
/// anchors and comments are skipped, only the first document is read, and a name with a point, such as
/// ORB-SLAM's Camera.fx, becomes a member of a member.
checked_json::Json json_in(std::string_view text);

}  // namespace touchable
