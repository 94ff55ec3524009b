// What a brush did is there again in the next window, however the last one ended.
#include "player/control/kept_brush.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "player/window/text_files.hpp"
#include "tests/materials/drawn_segments.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;
using Paint = MaterialBrush::Paint;

class BrushOfAClip : public ::testing::Test {
protected:
    static SegmentStore segments() { return stored({{"aaaabbcc", "aaaabbcc"}, {"aaaabbcc", "aaaabbcc"}}); }
    Result<KeptBrush> begin() { return KeptBrush::begin(segments(), files_); }
    KeptBrush begun() {
        auto brush = begin();
        EXPECT_TRUE(brush.ok()) << brush.error().message;
        return std::move(*brush);
    }
    void put(const fs::path& file, const std::string& text) {
        TextFiles writing;
        writing.write(file, text);
        writing.finish();
        for (const auto& [name, written] : writing.take())
            EXPECT_TRUE(written.ok()) << written.error().message;
    }
    /// As the window does.
    void edit(KeptBrush& brush, const MaterialBrush::Edit& edit) {
        const auto done = brush.brush().edit(edit);
        ASSERT_TRUE(done.ok()) << done.error().message;
        put(files_.history(), brush.history());
    }
    void save(KeptBrush& brush) {
        const std::string text = brush.save();
        put(files_.history(), brush.history());
        put(files_.saved(), text);
    }
    static std::string material(const KeptBrush& brush, int x) {
        const auto painted = brush.brush().painted();
        return painted->by_label.at(painted->segments->label_at(0, x, 0)).material;
    }

    const TemporaryFolder folder_;
    BrushFiles files_{.clip = folder_ / "clip.mkv", .history_folder = folder_ / "state/touchable"};
};

TEST_F(BrushOfAClip, HasWhatWasDoneBeforeTheProgramWasKilled) {
    {
        KeptBrush brush = begun();
        EXPECT_FALSE(brush.is_painted());
        edit(brush, Paint{{0, 0, 0}, "foam"});
        edit(brush, SegmentCut{0, {{1, 0}, {1, 1}}});
        edit(brush, Paint{{0, 0, 0}, "brick"});
    }
    KeptBrush again = begun();
    EXPECT_TRUE(again.is_painted());
    EXPECT_NE(again.begun_with().find("3 changes of last time are here again"), std::string::npos)
        << again.begun_with();
    EXPECT_EQ(material(again, 0), "brick");
    EXPECT_EQ(material(again, 3), "foam");
    ASSERT_TRUE(again.brush().undo().ok());
    EXPECT_EQ(material(again, 0), "foam");
    ASSERT_TRUE(again.brush().undo().ok());
    put(files_.history(), again.history());
    const KeptBrush once_more = begun();
    EXPECT_NE(once_more.begun_with().find("1 change of last time is"), std::string::npos);
    EXPECT_EQ(once_more.brush().edits(), 3U) << "what was undone can be done again";
}

TEST_F(BrushOfAClip, IsSavedBesideItsClipAndGoesOnFromThere) {
    KeptBrush brush = begun();
    edit(brush, Paint{{0, 0, 0}, "foam"});
    save(brush);
    EXPECT_TRUE(fs::exists(folder_ / "clip.mkv.materials.json"));
    edit(brush, Paint{{4, 0, 0}, "glass"});
    KeptBrush again = begun();
    EXPECT_EQ(material(again, 4), "glass");
    EXPECT_EQ(again.brush().done(), 2U) << "undo goes on beyond what was saved";
    // Without a history, what is saved.
    fs::remove(files_.history());
    const KeptBrush saved = begun();
    EXPECT_EQ(material(saved, 0), "foam");
    EXPECT_NE(material(saved, 4), "glass");
    EXPECT_TRUE(saved.is_painted());
    EXPECT_NE(saved.begun_with().find("clip.mkv.materials.json"), std::string::npos) << saved.begun_with();
}

TEST_F(BrushOfAClip, IsBegunByTheFileThatIsGiven) {
    put(folder_ / "given.json", R"({"touchable_segments": 1, "segments":
        [{"name": "table", "material": "cork", "at": [0, 0, 0]}]})");
    files_.segments = folder_ / "given.json";
    EXPECT_EQ(material(begun(), 0), "cork");
    EXPECT_EQ(files_.saved(), folder_ / "given.json");
    put(folder_ / "given.json", R"({"touchable_segments": 1, "segments":
        [{"name": "table", "material": "cork", "at": [0, 9, 0]}]})");
    const auto refused = begin();
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("outside"), std::string::npos) << refused.error().message;
}

TEST_F(BrushOfAClip, AHistoryThatDoesNotFitIsSetAside) {
    KeptBrush brush = begun();
    edit(brush, Paint{{0, 0, 0}, "foam"});
    const std::string history = brush.history();
    const fs::path file = files_.history(), aside = file.string() + ".broken";
    const auto expect_aside = [&](const std::string& text, const std::string& why) {
        put(file, text);
        const KeptBrush again = begun();
        EXPECT_EQ(again.brush().edits(), 0U);
        EXPECT_NE(again.begun_with().find("set aside as " + aside.filename().string()), std::string::npos)
            << again.begun_with();
        EXPECT_NE(again.begun_with().find(why), std::string::npos) << again.begun_with();
        EXPECT_FALSE(fs::exists(file));
        EXPECT_EQ(file_contents(aside), text);
    };
    expect_aside("{", "no history");
    expect_aside("[1]", "no history");
    expect_aside(R"({"saved": [], "changes": "{}"})", "touchable_brush");
    std::string other = history;
    other.replace(other.find("paint"), 5, "faint");
    expect_aside(other, "edits[0]");
    // Somebody else has said something of the segments meanwhile.
    put(files_.saved(), R"({"touchable_segments": 1, "otherwise": "wood", "segments": []})");
    expect_aside(history, "other materials than");
    EXPECT_EQ(material(begun(), 0), "wood");
}

TEST_F(BrushOfAClip, ClipsHaveAHistoryEach) {
    BrushFiles folder = files_, with_slash = files_, other = files_;
    folder.clip = folder_ / "pictures";
    with_slash.clip = folder_ / "pictures/";
    other.clip = folder_ / "other.mkv";
    EXPECT_EQ(folder.history(), with_slash.history());
    EXPECT_EQ(with_slash.saved(), folder_ / "pictures.materials.json");
    EXPECT_NE(files_.history(), other.history());
    other.history_folder.clear();
    EXPECT_TRUE(other.history().empty());
}

TEST(TextFiles, SayWhatCouldNotBeWritten) {
    const TemporaryFolder folder;
    TextFiles files;
    std::ofstream(folder / "file") << "x";
    files.write(folder / "file/below.json", "a");
    files.write(folder / "new/folder/a.json", "b");
    files.write(folder / "file", "c", [](const fs::path&) { return input_error("it is dear to me"); });
    files.finish();
    const auto done = files.take();
    ASSERT_EQ(done.size(), 3U);
    ASSERT_FALSE(done[0].second.ok());
    EXPECT_TRUE(done[1].second.ok());
    EXPECT_EQ(done[2].second.error().message, "it is dear to me");
    EXPECT_EQ(file_contents(folder / "new/folder/a.json"), "b");
    EXPECT_EQ(file_contents(folder / "file"), "x");
    EXPECT_TRUE(files.take().empty());
    files.write(folder / "later", "d");
    files.finish();
    EXPECT_EQ(file_contents(folder / "later"), "d");
}

}  // namespace
}  // namespace touchable::test
