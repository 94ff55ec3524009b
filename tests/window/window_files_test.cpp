// Files that a window reads and writes: each once, whole or up to where a disk is full, and never one in
// place of another.
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "engine/picture/sound.hpp"
#include "player/run/run_files.hpp"
#include "tests/video/film_reader.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

/// How often each file of a folder was opened since.
class OpenedFiles {
public:
    explicit OpenedFiles(const std::filesystem::path& folder) : watch_(inotify_init1(IN_NONBLOCK)) {
        EXPECT_GE(inotify_add_watch(watch_, folder.c_str(), IN_OPEN), 0);
    }
    ~OpenedFiles() { close(watch_); }
    OpenedFiles(const OpenedFiles&) = delete;
    OpenedFiles& operator=(const OpenedFiles&) = delete;
    std::map<std::string, int> times() const {
        std::map<std::string, int> times;
        alignas(inotify_event) std::array<char, 65536> events{};
        for (ssize_t size; (size = ::read(watch_, events.data(), events.size())) > 0;)
            for (ssize_t at = 0; at < size;) {
                const auto* const event = reinterpret_cast<const inotify_event*>(events.data() + at);
                if (event->len > 0) ++times[event->name];
                at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
            }
        return times;
    }

private:
    const int watch_;
};

/// Neither to know which files may be written, nor for other settings; kept ones are refused here at first.
TEST(WindowFiles, OpensEachFrameOnceWhateverIsWrittenAndFelt) {
    const TemporaryFolder folder;
    const std::string pictures = (folder / "pictures").string();
    ASSERT_EQ(run_touchable({"convert", made_clip("globe", 30).string(), pictures + "/"}).code, 0);
    std::ofstream(folder / "play.json") << R"({"a": {"temporal": "on"}})";
    const OpenedFiles opened(pictures);
    shot_of(pictures, "0 speed 0.25\n0.3 median 5\n0.8 metric pixel\n1.3 filters auto\n", "2",
            {"--record", (folder / "hand.touch").string(), "--settings", (folder / "play.json").string()});
    const auto times = opened.times();
    EXPECT_TRUE(times.contains("scene.json") && times.contains("depth_000003.png"));
    for (const auto& [file, count] : times) EXPECT_EQ(count, 1) << file;
    const auto recording = read_recording(folder / "hand.touch");
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_GT(recording->size(), 1U) << "nothing was changed";
}

TEST(WindowFiles, ADiskThatIsFullIsSaidAtOnceAndWhatIsThereIsKept) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string(), sound = (folder / "heard.wav").string();
    const Outcome played = run_on_full_disk(
        {"play", made_clip("globe", 30).string(), "--headless", "--size", "320x240", "--seconds", "2",
         "--painter", "cpu", "--builder", "cpu", "--record", record, "--sound", sound},
        100);
    EXPECT_EQ(played.code, 3) << played.err;
    for (const std::string& file : {"--record " + record, "--sound " + sound}) {
        const std::size_t at_once = played.err.find("touchable: warning: " + file + ": cannot be written: ");
        const std::size_t in_the_end = played.err.find("touchable: --record " + record + ": cannot be");
        EXPECT_LT(at_once, in_the_end) << played.err;
        EXPECT_NE(in_the_end, std::string::npos) << played.err;
    }
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_GT(recording->front().ticks.size(), 100U);
    const auto again = run_touchable({"touch", "--replay", record});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.out.find("as recorded, to the bit"), std::string::npos) << again.out;
    const std::string wav = file_contents(sound);
    ASSERT_GT(wav.size(), 60'000U);
    std::uint32_t samples = 0;
    std::memcpy(&samples, wav.data() + 40, sizeof samples);
    EXPECT_EQ(samples, wav.size() - 44) << "what the header says is what is there";
}

TEST(WindowFiles, AFilmIsKeptUpToWhereItsDiskBecameFull) {
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << "0 loop\n0 overlay depth\n0.3 size 640x480\n0.6 overlay normals\n";
    const std::string film = (folder / "film.mp4").string(), record = (folder / "hand.touch").string();
    const Outcome played =
        run_on_full_disk({"play", made_clip("globe", 30).string(), "--headless", "--size", "640x480",
                          "--seconds", "4", "--painter", "cpu", "--builder", "cpu", "--script",
                          (folder / "script").string(), "--video", film, "--record", record},
                         250);
    EXPECT_EQ(played.code, 3) << played.err;
    const std::string full = film + ": the film cannot be written: the disk is full";
    const std::size_t at_once = played.err.find("touchable: warning: " + full + "\n");
    const std::size_t in_the_end = played.err.find(full + "; it is kept up to there\n");
    EXPECT_LT(at_once, in_the_end) << played.err;
    EXPECT_NE(in_the_end, std::string::npos) << played.err;
    EXPECT_GE(seen_in_film(film).size(), 2U) << "pictures that were complete";
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_GT(recording->front().ticks.size(), 100U) << "the other output, up to where it is full";
}

TEST(WindowFiles, IsRefusedWhereItCouldNotEnd) {
    const auto endless = run_touchable({"play", made_clip("globe", 30).string(), "--headless"});
    EXPECT_EQ(endless.code, 2);
    EXPECT_TRUE(endless.one_line_of_error()) << endless.err;
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << "0.1 quit\n";
    const std::string film = (folder / "FILM.MP4").string();
    const auto ends = run_touchable({"play", made_clip("globe", 30).string(), "--headless", "--size",
                                     "320x240", "--script", (folder / "script").string(), "--video", film});
    EXPECT_EQ(ends.code, 0) << ends.err;
    EXPECT_FALSE(seen_in_film(film).empty());
    const auto none = run_touchable({"play", "nowhere.mkv", "--headless", "--seconds", "1"});
    EXPECT_EQ(none.code, 3);
    EXPECT_TRUE(none.one_line_of_error()) << none.err;
}

TEST(WindowFiles, InterruptedBeforeItsFirstPictureSaysThatNothingIsWritten) {
    const TemporaryFolder folder;
    const auto ended = run_interrupted_at_once({"play", made_clip("globe", 30).string(), "--headless",
                                                "--seconds", "9", "--video", (folder / "film.mkv").string()});
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_TRUE(ended.one_line_of_error()) << ended.err;
    EXPECT_EQ(ended.err.find("is written"), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("; written"), std::string::npos) << ended.err;
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(WindowFiles, NeverWritesOverWhatItShows) {
    const TemporaryFolder folder;
    std::filesystem::copy(made_clip("globe", 30), folder / "globe.mkv");
    const std::string clip = (folder / "globe.mkv").string(), before = file_contents(clip);
    const std::string other_spelling = (folder / ".").string() + "/globe.mkv";
    const auto recorded = run_touchable(
        {"play", clip, "--headless", "--seconds", "0.2", "--record", other_spelling, "--overwrite"});
    EXPECT_EQ(recorded.code, 2) << recorded.err;
    EXPECT_TRUE(recorded.one_line_of_error());
    const auto kept =
        run_touchable({"play", clip, "--headless", "--seconds", "0.2", "--settings", other_spelling});
    EXPECT_EQ(kept.code, 2) << kept.err;
    std::ofstream(folder / "script") << "0 open " << clip << "\n0 screenshot " << (folder / "a.png").string()
                                     << "\n";
    std::filesystem::create_symlink(clip, folder / "a.png");
    const auto drawn = run_touchable({"play", made_clip("globe", 1).string(), "--headless", "--seconds",
                                      "0.2", "--script", (folder / "script").string(), "--overwrite"});
    EXPECT_EQ(drawn.code, 2) << drawn.err;
    EXPECT_EQ(file_contents(clip), before);
}

TEST(WindowFiles, FilmShowsWhatTheWindowDidAndSoundsAsIt) {
    const TemporaryFolder folder;
    const std::string film = (folder / "film.mkv").string();
    // The other size, and the panel in the right half from then on; a while after the press, for the finger
    // comes later where ticks are skipped, and at the other size the pointer is beside the globe.
    const Played shot =
        shot_of(made_clip("globe", 1), "0 move 160 130\n0.2 press left\n1.3 size 640x480\n1.3 panel\n", "1.8",
                {"--video", film});
    EXPECT_NE(shot.outcome.out.find("film "), std::string::npos) << shot.outcome.out;
    const auto seen = seen_in_film(film);
    ASSERT_GE(seen.size(), 30U);
    double lasted_s = 0;
    ASSERT_EQ(std::sscanf(shot.outcome.out.c_str(), "pictures %*d in %lf s", &lasted_s), 1)
        << shot.outcome.out;
    EXPECT_LE(seen.size(), 30 * lasted_s + 5) << "longer than the window was there";
    EXPECT_NEAR(seen.back().seconds, static_cast<double>(seen.size() - 1) / 30, 0.01);
    EXPECT_EQ(seen.front().width, 320);
    EXPECT_EQ(seen.back().width, 320);
    const auto light_in = [](const SeenPicture& picture, int x0, int x1) {
        double sum = 0;
        for (int y = 20; y < 200; ++y)
            for (int x = x0; x < x1; ++x) sum += picture.at(x, y) - 16;
        return sum / (180 * (x1 - x0));
    };
    EXPECT_GT(light_in(seen.front(), 100, 220), 30) << "black";
    EXPECT_GT(light_in(seen.back(), 100, 180), 20) << "black";
    EXPECT_GT(std::abs(light_in(seen.front(), 210, 310) - light_in(seen.back(), 210, 310)), 3) << "no panel";
    auto track = SoundTrack::open(film);
    ASSERT_TRUE(track && *track);
    // All of it: where the machine stood still, the finger pressed later.
    std::vector<StereoSample> heard(static_cast<std::size_t>(48'000 * (lasted_s + 1)));
    (*track)->read(heard);
    const auto is_silent = [](const StereoSample& sample) { return sample.left == 0 && sample.right == 0; };
    const auto first = std::find_if_not(heard.begin(), heard.end(), is_silent) - heard.begin();
    EXPECT_GE(first, 0.2 * 48'000) << "before the finger pressed";
    EXPECT_LT(first, std::ssize(heard)) << "no tap";
    const auto refused = run_touchable({"play", made_clip("globe", 1).string(), "--headless", "--seconds",
                                        "0.2", "--video", (folder / "film.avi").string()});
    EXPECT_EQ(refused.code, 2);
    EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
}

}  // namespace
}  // namespace touchable::test
