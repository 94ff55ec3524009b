// Hands: their words, and the tables that they repeat.
#include <cmath>

#include "device/hand.hpp"
#include "device/hand_parts.hpp"
#include "player/run/run_files.hpp"
#include "tests/device/fake_probe.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

constexpr int ticks = 20;

void require_goals(Hand& hand, const SurfaceProbe& probe) {
    std::vector<glm::dvec3> goals(static_cast<std::size_t>(hand.fingers()));
    for (int tick = 0; tick < ticks; ++tick) {
        hand.goals_at(tick, probe, goals);
        for (const glm::dvec3& goal : goals)
            require(std::isfinite(goal.x) && std::isfinite(goal.y) && std::isfinite(goal.z),
                    "a goal is not finite");
    }
}

bool parse_hand(std::string_view bytes) {
    const std::string words(bytes);
    // A table is another target's.
    if (words.starts_with("csv:")) return false;
    const FakeProbe probe = flat_view();
    const auto hand = make_hand(words, 2, default_workspace(640, 500, 800), probe);
    if (!is_taken(hand, Quotes::typed)) return false;
    require_goals(**hand, probe);
    return true;
}

/// A line of options, then the table.
bool parse_recorded_hand(std::string_view bytes) {
    Taken taken(bytes);
    const std::string options(taken.line());
    const FakeProbe probe = flat_view();
    const auto file = file_of(taken.rest(), "hand.csv").string();
    const auto hand = make_hand("csv:" + file + ":" + options, 1, default_workspace(640, 500, 800), probe);
    if (!is_taken(hand, Quotes::typed)) return false;
    require((*hand)->ticks().value_or(0) > 0, "a motion has no length");
    require_goals(**hand, probe);
    return true;
}

bool parse_csv_table(std::string_view bytes) {
    const auto file = file_of(bytes, "table.csv").string();
    (void)is_taken(read_force_table(file));
    const auto table = CsvTable::read(file);
    if (!is_taken(table)) return false;
    require(table->rows() > 0 && table->columns() > 0, "a table without a row");
    for (std::size_t column = 0; column < table->columns(); ++column) {
        const auto numbers = table->numbers(column);
        if (!is_taken(numbers)) continue;
        require(numbers->size() == table->rows(), "not a number for each row");
        for (const double number : *numbers) require(std::isfinite(number), "a number is not finite");
    }
    return true;
}

const Registered hand_target{{.name = "hand", .parse = parse_hand, .most_bytes = 256}};
// Three rows may be a motion of an hour: 82 MiB of ticks.
const Registered recorded_hand_target{
    {.name = "recorded_hand", .parse = parse_recorded_hand, .most_bytes = 1024, .most_live_mebibytes = 96}};
const Registered csv_table_target{{.name = "csv_table", .parse = parse_csv_table, .most_bytes = 1024}};

}  // namespace
}  // namespace touchable::fuzz
