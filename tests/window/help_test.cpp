// The list of keys: what is in it, and that all of it can be read in windows from 640x400 on.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "player/window/command_table.hpp"
#include "player/window/panel_parts.hpp"
#include "player/window/window_command.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

PanelFacts facts_of(bool is_held) {
    PanelFacts facts;
    if (is_held) facts.hand.emplace().buttons = 2;
    return facts;
}

/// Rows of all groups that say so.
int rows_that_say(const std::vector<HelpGroup>& groups, const std::string& what) {
    int count = 0;
    for (const HelpGroup& group : groups)
        count += static_cast<int>(std::count_if(group.rows.begin(), group.rows.end(),
                                                [&](const HelpGroup::Row& row) { return row.what == what; }));
    return count;
}

TEST(Help, HasEachKeyOnceWhetherAPointerOrADeviceLeads) {
    const auto by_pointer = help_groups(facts_of(false)), by_hand = help_groups(facts_of(true));
    for (const KeyBinding& binding : key_bindings()) {
        if (!binding.what) continue;
        const int of_pointer = rows_that_say(by_pointer, binding.what),
                  of_hand = rows_that_say(by_hand, binding.what);
        EXPECT_EQ(std::max(of_pointer, of_hand), 1) << binding.what;
        const bool leads_a_device = binding.verb == WindowVerb::clutch ||
                                    binding.verb == WindowVerb::recentre ||
                                    binding.verb == WindowVerb::coarser;
        EXPECT_EQ(of_pointer, leads_a_device ? 0 : 1) << binding.what;
    }
    EXPECT_EQ(rows_that_say(by_hand, "so many fingers"), 0);
}

TEST(Help, BeginsWithWhatSomebodyNewNeeds) {
    const std::vector<HelpGroup> groups = help_groups(facts_of(false));
    ASSERT_FALSE(groups.empty());
    std::string keys;
    for (const HelpGroup::Row& row : groups[0].rows) keys += row.keys + "; ";
    EXPECT_EQ(keys, "Left button; Right button; Ctrl and drag; Home; PageUp  PageDown  <  >; T; ");
    EXPECT_NE(groups[0].rows[1].what.find("presses deeper"), std::string::npos) << "nobody guesses it";
}

TEST(Help, NamesAKeyWithAndWithoutShiftOnce) {
    for (const HelpGroup& group : help_groups(facts_of(false)))
        for (const HelpGroup::Row& row : group.rows)
            if (row.what.find("Shift ten") != std::string::npos) {
                EXPECT_EQ(row.keys, "Left  Right");
            } else if (row.what.find("redo") != std::string::npos) {
                EXPECT_EQ(row.keys, "Ctrl Z  Y  Ctrl Shift Z") << "which does something else";
            }
}

/// The box of the help before the picture, and after the wheel was turned over it.
std::pair<Image, Image> turned_at(const std::string& size, const std::string& middle) {
    const std::string open = "0.1 key ?\n0.2 move " + middle + "\n";
    const std::string clip = made_clip("globe", 1).string();
    return {played_by({clip}, open, "1", size).image,
            played_by({clip}, open + "0.3 wheel -50\n", "1", size).image};
}

TEST(Help, IsScrolledToItsEndWhereItDoesNotFit) {
    const auto [top, end] = turned_at("640x400", "300 150");
    EXPECT_GT(differences(top, end, {90, 30, 540, 300}), 4000) << "it did not move";
    // The ground of what says that there is more, in the box's last line beside the words.
    const auto blue_at = [](const Image& image) {
        return image.samples[static_cast<std::size_t>(image.channels * (318 * image.width + 120) + 2)];
    };
    EXPECT_GT(blue_at(top), 45) << "nothing says that there is more";
    EXPECT_LT(blue_at(end), 45) << "there is no more";
}

TEST(Help, IsSeenAtOnceInALargeWindow) {
    const auto [top, end] = turned_at("1280x720", "640 300");
    EXPECT_EQ(differences(top, end, {140, 110, 1140, 550}), 0) << "something was scrolled to";
}

}  // namespace
}  // namespace touchable::test
