// The brush of the window: what it does for a clip, and what becomes of that when the clip goes.
#include "player/window/window_brush.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "tests/temporary_folder.hpp"
#include "tests/window/two_surfaces.hpp"

namespace touchable::test {
namespace {

class BrushOfAWindow : public ::testing::Test {
protected:
    void SetUp() override {
        options_.session.builder.name = "cpu";
        options_.brush_history = folder_ / "state";
        first_ = open("first.mkv", 30);
        second_ = open("second.mkv", 4);
        ASSERT_TRUE(first_ && second_);
        brush_.go_to(*first_);
    }
    std::unique_ptr<OpenedClip> open(const char* name, int frames) {
        ClipChoice choice;
        choice.file = folder_ / name;
        write_two_surfaces(choice.file, frames);
        auto opened = OpenedClip::open(options_, choice, {}, *sound_);
        EXPECT_TRUE(opened) << opened.error().message;
        if (!opened || !(*opened)->begin()) return nullptr;
        return std::move(*opened);
    }
    void ask(const std::string& words) {
        auto command = parse_window_command(words);
        ASSERT_TRUE(command) << command.error().message;
        brush_.take(*command);
    }
    std::string said() {
        std::string words;
        const auto news = brush_.take_news();
        for (const auto& remark : news.remarks) words += remark.words + '\n';
        has_begun_ = has_begun_ || news.has_begun;
        return words;
    }
    /// Turns of a window; all that the brush says, a line each.
    std::string until_done() {
        std::string all;
        for (int k = 0; k < 20'000; ++k) {
            brush_.go_on({});
            all += said();
            if (!brush_.is_at_work()) return all;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        ADD_FAILURE() << "it is at work for ever: " << brush_.words();
        return all;
    }
    std::string material_at(int x) const {
        const auto felt = brush_.felt();
        return felt ? felt->by_label.at(felt->segments->label_at(0, x, 32)).material : "as the clip says";
    }

    const TemporaryFolder folder_;
    PlayOptions options_;
    std::unique_ptr<WindowSound> sound_ = std::move(*WindowSound::create(false, {}, Existing::keep));
    std::unique_ptr<OpenedClip> first_, second_;
    WindowBrush brush_{options_};
    bool has_begun_ = false;
};

TEST_F(BrushOfAWindow, DoesOneCommandAfterTheOther) {
    EXPECT_FALSE(brush_.is_at_work());
    ASSERT_NO_FATAL_FAILURE(ask("material foam"));
    EXPECT_TRUE(brush_.is_at_work());
    EXPECT_FALSE(brush_.is_changing()) << "it reads";
    until_done();
    EXPECT_TRUE(has_begun_);
    for (const char* words : {"paint 20,32", "material glass", "paint 70,32,29", "paint 20,32,30", "undo"})
        ASSERT_NO_FATAL_FAILURE(ask(words));
    EXPECT_TRUE(brush_.is_changing());
    const std::string all = until_done();
    EXPECT_FALSE(brush_.is_changing());
    EXPECT_NE(all.find("is foam"), std::string::npos) << all;
    EXPECT_NE(all.find("beyond the clip"), std::string::npos) << all;
    EXPECT_NE(all.find("undone"), std::string::npos) << all;
    EXPECT_EQ(material_at(20), "foam");
    EXPECT_TRUE(brush_.facts().can_redo);
    ASSERT_NO_FATAL_FAILURE(ask("tool touch"));
    EXPECT_EQ(material_at(20), "foam") << "a person painted it";
}

TEST_F(BrushOfAWindow, LetsGoOfAClipAndHasItsChangesAgain) {
    ASSERT_NO_FATAL_FAILURE(ask("material foam"));
    until_done();
    ASSERT_NO_FATAL_FAILURE(ask("paint 20,32"));
    until_done();
    ASSERT_NO_FATAL_FAILURE(ask("cut 46,20 95,20"));
    brush_.go_on({});
    EXPECT_TRUE(brush_.is_changing());
    brush_.go_to(*second_);  // by somebody who does not wait for it
    EXPECT_FALSE(brush_.is_at_work());
    EXPECT_FALSE(brush_.is_held());
    EXPECT_EQ(brush_.felt(), nullptr);
    EXPECT_FALSE(brush_.facts().is_there);
    ASSERT_NO_FATAL_FAILURE(ask("tool paint"));
    EXPECT_EQ(until_done().find("of last time"), std::string::npos) << "that is another clip's";
    brush_.go_to(*first_);
    ASSERT_NO_FATAL_FAILURE(ask("tool paint"));
    const std::string all = until_done();
    EXPECT_NE(all.find("1 change of last time is here again"), std::string::npos) << all;
    EXPECT_EQ(material_at(20), "foam");
}

TEST_F(BrushOfAWindow, SaysWhichClipIsSavedAndThatOneIsNot) {
    options_.names.saved = [](const std::string& clip, const std::string& file) {
        return "SAVED " + clip + " " + file;
    };
    ASSERT_NO_FATAL_FAILURE(ask("material foam"));
    ASSERT_NO_FATAL_FAILURE(ask("save-materials"));
    std::string all = until_done();
    brush_.go_to(*second_);
    for (int k = 0; k < 20'000 && all.find("SAVED") == std::string::npos;
         ++k) {  // a busy disk takes its time
        brush_.go_on({});
        all += said();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(brush_.finish());
    all += said();
    const std::string first = (folder_ / "first.mkv").string();
    EXPECT_NE(all.find("SAVED " + first + " " + first + ".materials.json"), std::string::npos) << all;
    // Of segments that nobody has read yet.
    ASSERT_NO_FATAL_FAILURE(ask("save-materials"));
    brush_.go_on({});
    const auto unsaved = brush_.finish();
    ASSERT_FALSE(unsaved);
    EXPECT_NE(unsaved.error().message.find("not saved"), std::string::npos) << unsaved.error().message;
}

/// What was clicked at a clip that ended before it was seen keeps no script waiting.
TEST_F(BrushOfAWindow, HasNothingToDoWhereNothingIsShownAnyMore) {
    auto third = open("third.mkv", 4);
    ASSERT_TRUE(third && third->finish());
    brush_.go_to(*third);
    ASSERT_NO_FATAL_FAILURE(ask("material foam"));
    until_done();
    InputEvent click{.kind = InputEvent::Kind::pressed};
    click.word = "left";
    EXPECT_TRUE(brush_.take(click, {10, 10}, false, {.width = 96, .height = 64}));
    until_done();
    brush_.go_to(*first_);
}

}  // namespace
}  // namespace touchable::test
