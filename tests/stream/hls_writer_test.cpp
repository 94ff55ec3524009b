// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <sstream>
#include <thread>

#include "engine/clip/readers.hpp"
#include "engine/stream/hls.hpp"
#include "engine/stream/receiving.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/stream/servers.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

Scene small_hls_scene() {
    Scene scene = small_scene(32, 24, 16);
    scene.rate = {10, 1};
    return scene;
}

struct Written {
    Result<void> outcome;
    std::vector<RawFrame> frames;
    std::vector<std::string> notes;
    HlsWriter::Figures figures;
};

Written write_hls(const HlsWriter::Settings& settings, int frames, const Planes& planes,
                  const std::optional<SoundPart>& sound = {}) {
    const Scene scene = small_hls_scene();
    Written written;
    auto writer = HlsWriter::open(settings, scene, sound);
    if (!writer) {
        written.outcome = writer.error();
        return written;
    }
    for (int n = 0; n < frames && written.outcome; ++n) {
        written.frames.push_back(test_frame(scene, n, planes));
        const auto added = (*writer)->add(written.frames.back(), sent_label(n), scene.rate.time_ns(n), true);
        if (!added) written.outcome = added.error();
    }
    written.notes = (*writer)->notes();
    if (written.outcome) written.outcome = (*writer)->finish();
    written.figures = (*writer)->figures();
    return written;
}

std::vector<std::string> lines_of(const fs::path& file) {
    std::istringstream in(read_bytes(file));
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

bool has_line(const fs::path& file, const std::string& line) {
    return std::ranges::count(lines_of(file), line) == 1;
}

/// The header's name, then those of the segments.
std::vector<std::string> files_of(const fs::path& playlist) {
    std::vector<std::string> files(1);
    for (const std::string& line : lines_of(playlist)) {
        if (line.starts_with("#EXT-X-MAP:URI=\"")) files[0] = line.substr(16, line.size() - 17);
        if (!line.starts_with('#')) files.push_back(line);
    }
    return files;
}

std::vector<fs::path> all_files(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path().filename());
    return files;
}

/// A segment alone behind its header, as a player has it that begins there.
DemuxedPictures demuxed_segment(const fs::path& folder, const std::vector<std::string>& files,
                                std::size_t segment, const std::vector<RawFrame>& frames) {
    const std::string bytes = read_bytes(folder / files[0]) + read_bytes(folder / files.at(segment));
    auto pictures = demuxed(bytes, "mov", frames);
    EXPECT_EQ(pictures.damaged, 0);
    return pictures;
}

std::int64_t playlist_bytes(const fs::path& folder) {
    return static_cast<std::int64_t>(fs::file_size(folder / "colour.m3u8") +
                                     fs::file_size(folder / "touch.m3u8"));
}

TEST(HlsWriter, WritesWholeClipInSegments) {
    const TemporaryFolder folder;
    const fs::path home = folder / "web";
    const Written written = write_hls({home}, 25, {true, true, false});
    ASSERT_EQ(message(written.outcome), "");
    EXPECT_TRUE(has_line(home / "master.m3u8", "colour.m3u8"));
    EXPECT_TRUE(has_words(read_bytes(home / "master.m3u8"), ",CODECS=\"avc1."));
    EXPECT_TRUE(has_line(home / "master.m3u8",
                         "#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes\",VALUE=\"touch.m3u8\""));
    for (const std::string name : {"colour.m3u8", "touch.m3u8"}) {
        EXPECT_TRUE(has_line(home / name, "#EXT-X-TARGETDURATION:1"));
        EXPECT_TRUE(has_line(home / name, "#EXT-X-PLAYLIST-TYPE:VOD"));
        EXPECT_TRUE(has_line(home / name, "#EXT-X-ENDLIST"));
        EXPECT_TRUE(has_line(home / name, "#EXT-X-PROGRAM-DATE-TIME:2023-11-14T22:13:20.000Z"));
        EXPECT_EQ(std::ranges::count(lines_of(home / name), "#EXTINF:1.000000,"), 2);
        EXPECT_TRUE(has_line(home / name, "#EXTINF:0.500000,"));
        const auto files = files_of(home / name);
        ASSERT_EQ(files.size(), 4U);
        for (std::size_t k = 1; k < files.size(); ++k) {
            const Came came = demuxed_segment(home, files, k, written.frames).came;
            const std::size_t frames = k < 3 ? 10 : 5;
            EXPECT_EQ(came.size(), name == "colour.m3u8" ? frames : 2 * frames) << files[k];
            EXPECT_EQ(came.begin()->first.second, static_cast<std::int64_t>(k - 1) * 10);
        }
    }
    EXPECT_EQ(all_files(home).size(), 3U + 2U * 4U);
    std::int64_t bytes = 0;
    for (const auto& entry : fs::directory_iterator(home))
        if (entry.path().extension() == ".m4s") bytes += static_cast<std::int64_t>(entry.file_size());
    EXPECT_EQ(written.figures.segments, 3);
    EXPECT_EQ(written.figures.duration_ns, 5 * a_second_ns / 2);
    EXPECT_EQ(written.figures.colour_bytes + written.figures.touch_bytes, bytes);
    EXPECT_EQ(written.figures.playlist_bytes, playlist_bytes(home));
}

/// Both levels are cut at the same frames. An odd number of frames in a segment: each begins anew.
TEST(HlsWriter, HalvesFramesetsOfLowLevel) {
    const TemporaryFolder folder;
    const fs::path home = folder / "web";
    const Written written = write_hls({.folder = home, .segment_ns = 9 * a_second_ns / 10, .has_low = true},
                                      23, {true, true, false});
    ASSERT_EQ(message(written.outcome), "");
    EXPECT_TRUE(
        has_line(home / "master.m3u8",
                 "#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes.low\",VALUE=\"touch-low.m3u8\""));
    const auto master = lines_of(home / "master.m3u8");
    EXPECT_LT(std::ranges::find(master, "colour.m3u8"), std::ranges::find(master, "colour-low.m3u8"));
    EXPECT_TRUE(has_line(home / "master.m3u8", "colour-low.m3u8"));
    const auto extents = [](const fs::path& file) {
        auto lines = lines_of(file);
        std::erase_if(lines, [](const std::string& line) { return !line.starts_with("#EXTINF"); });
        return lines;
    };
    for (const std::string name : {"colour", "touch"}) {
        const auto files = files_of(home / (name + "-low.m3u8"));
        ASSERT_EQ(files.size(), 4U);
        EXPECT_EQ(extents(home / (name + "-low.m3u8")), extents(home / (name + ".m3u8")));
        for (std::size_t k = 1; k < files.size(); ++k) {
            const Came came = demuxed_segment(home, files, k, written.frames).came;
            const std::int64_t step = name == "touch" ? 2 : 1, first = static_cast<std::int64_t>(k - 1) * 9,
                               end = std::min<std::int64_t>(first + 9, 23);
            Came right;
            for (std::int64_t n = first; n < end; n += step)
                for (const PlaneRole role : {PlaneRole::colour, PlaneRole::depth, PlaneRole::haptic})
                    if ((role == PlaneRole::colour) == (name == "colour")) right[{role, n}] = 1;
            EXPECT_EQ(came, right) << files[k];
        }
    }
    std::int64_t full_bytes = 0, low_bytes = 0;
    for (const auto& entry : fs::directory_iterator(home)) {
        if (entry.path().extension() != ".m4s") continue;
        const bool is_low = entry.path().filename().string().find("-low-") != std::string::npos;
        (is_low ? low_bytes : full_bytes) += static_cast<std::int64_t>(entry.file_size());
    }
    const HlsWriter::Figures& figures = written.figures;
    EXPECT_EQ(figures.colour_bytes + figures.touch_bytes, full_bytes);
    EXPECT_EQ(figures.low_colour_bytes + figures.low_touch_bytes, low_bytes);
    EXPECT_LT(figures.low_colour_bytes, figures.colour_bytes);
    EXPECT_LT(figures.low_touch_bytes, figures.touch_bytes * 3 / 4);
    EXPECT_EQ(figures.playlist_bytes, playlist_bytes(home));
    // A run without it leaves nothing of it.
    ASSERT_EQ(message(write_hls({home}, 5, {true}).outcome), "");
    EXPECT_EQ(all_files(home).size(), 3U + 2U * 2U);
}

TEST(HlsWriter, LowLevelMayBeDepth) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_hls({.folder = folder / "web", .has_low = true}, 5, {}).outcome), "");
    EXPECT_TRUE(has_line(folder / "web/master.m3u8", "touch.m3u8"));
    EXPECT_TRUE(has_line(folder / "web/master.m3u8", "touch-low.m3u8"));
    EXPECT_TRUE(has_words(read_bytes(folder / "web/master.m3u8"), "FRAME-RATE=5.000\ntouch-low"));
}

TEST(HlsWriter, MovesItsWindow) {
    const TemporaryFolder folder;
    const fs::path home = folder / "web";
    const Scene scene = small_hls_scene();
    auto writer = must(HlsWriter::open({home, a_second_ns, 4 * a_second_ns}, scene));
    std::set<std::string> named;
    std::size_t most_files = 0;
    for (int n = 0; n < 600; ++n) {
        const RawFrame frame = test_frame(scene, n, {true, false, false, false});
        ASSERT_EQ(message(writer->add(frame, sent_label(n), scene.rate.time_ns(n), true)), "");
        if (n % 10 != 0 || n == 0) continue;
        for (const char* const name : {"colour.m3u8", "touch.m3u8"}) {
            const auto files = files_of(home / name);
            EXPECT_EQ(files.size(), 1U + static_cast<std::size_t>(std::min(n / 10, 4)));
            EXPECT_TRUE(
                has_line(home / name, "#EXT-X-MEDIA-SEQUENCE:" + std::to_string(std::max(0, n / 10 - 4))));
            for (const std::string& file : files) {
                EXPECT_TRUE(fs::exists(home / file)) << file;
                named.insert(file);
            }
        }
        most_files = std::max(most_files, all_files(home).size());
    }
    EXPECT_FALSE(has_line(home / "touch.m3u8", "#EXT-X-ENDLIST"));
    EXPECT_EQ(named.size(), 2U + 2U * 59U);  // of the last one nothing is there yet
    // 4 in the playlist, 4 s + 2 s + 10 s that they stay, of two renditions
    EXPECT_LE(most_files, 3U + 2U + 2U * 22U);
    EXPECT_GE(most_files, 3U + 2U + 2U * 16U);
    ASSERT_EQ(message(writer->finish()), "");
    EXPECT_TRUE(has_line(home / "touch.m3u8", "#EXT-X-ENDLIST"));
    EXPECT_FALSE(has_line(home / "touch.m3u8", "#EXT-X-PLAYLIST-TYPE:VOD"));
}

TEST(HlsWriter, ContinuesFormerRun) {
    const TemporaryFolder folder;
    const HlsWriter::Settings live{folder / "web", a_second_ns, 4 * a_second_ns};
    ASSERT_EQ(message(write_hls(live, 25, {true}).outcome), "");
    const auto before = files_of(folder / "web/touch.m3u8");
    ASSERT_EQ(message(write_hls(live, 25, {true}).outcome), "");
    EXPECT_TRUE(has_line(folder / "web/touch.m3u8", "#EXT-X-MEDIA-SEQUENCE:3"));
    EXPECT_TRUE(has_line(folder / "web/touch.m3u8", "#EXT-X-DISCONTINUITY"));
    for (const std::string& file : before) EXPECT_TRUE(fs::exists(folder / ("web/" + file))) << file;
    // The files of before are not needed for a whole clip: no player fetches them any more.
    ASSERT_EQ(message(write_hls({folder / "web"}, 5, {true}).outcome), "");
    EXPECT_EQ(all_files(folder / "web").size(), 3U + 2U * 2U);
}

TEST(HlsWriter, MarksBreakAfterStandstill) {
    const TemporaryFolder folder;
    const Scene scene = small_hls_scene();
    auto writer = must(HlsWriter::open({folder / "web"}, scene));
    const std::int64_t times[] = {0, 100, 200, 7000, 7100};
    for (int n = 0; n < 5; ++n)
        ASSERT_EQ(message(writer->add(test_frame(scene, n, {}), sent_label(n), times[n] * 1'000'000, true)),
                  "");
    ASSERT_EQ(message(writer->finish()), "");
    const auto lines = lines_of(folder / "web/touch.m3u8");
    const auto first = std::ranges::find(lines, "#EXTINF:0.300000,");
    ASSERT_NE(first, lines.end());
    EXPECT_EQ(first[2], "#EXT-X-DISCONTINUITY");
    EXPECT_TRUE(has_line(folder / "web/touch.m3u8", "#EXTINF:0.200000,"));
}

TEST(HlsWriter, ShowsDepthWithoutColour) {
    const TemporaryFolder folder;
    const Written written = write_hls({folder / "web"}, 5, {});
    ASSERT_EQ(message(written.outcome), "");
    EXPECT_TRUE(has_line(folder / "web/master.m3u8", "touch.m3u8"));
    EXPECT_FALSE(fs::exists(folder / "web/colour.m3u8"));
    ASSERT_EQ(written.notes.size(), 1U);
}

TEST(HlsWriter, PutsSoundWithColour) {
    const TemporaryFolder folder;
    write_sounding_film(folder / "film.mp4", tone(440, 3));
    const Written written = write_hls({.folder = folder / "web", .has_low = true}, 25, {true},
                                      SoundPart{folder / "film.mp4", 0, 3 * a_second_ns});
    ASSERT_EQ(message(written.outcome), "");
    EXPECT_TRUE(has_words(read_bytes(folder / "web/master.m3u8"), ",mp4a.40.2\""));
    for (const char* const playlist : {"web/colour.m3u8", "web/colour-low.m3u8"}) {
        const auto files = files_of(folder / playlist);
        ASSERT_EQ(files.size(), 4U);
        for (std::size_t k = 1; k < files.size(); ++k) {
            const int sounds = demuxed_segment(folder / "web", files, k, written.frames).sounds;
            EXPECT_NEAR(sounds, k < 3 ? 48'000 / 1024 : 24'000 / 1024, 6) << playlist << k;
        }
    }
}

TEST(HlsWriter, SkipsSoundOfOtherCodecs) {
    const TemporaryFolder folder;
    write_sounding_film(folder / "film.mkv", tone(440, 3));
    const Written written =
        write_hls({folder / "web"}, 5, {true}, SoundPart{folder / "film.mkv", 0, 3 * a_second_ns});
    ASSERT_EQ(message(written.outcome), "");
    ASSERT_EQ(written.notes.size(), 1U);
    EXPECT_TRUE(has_words(written.notes[0], "flac"));
    EXPECT_EQ(read_bytes(folder / "web/master.m3u8").find("mp4a"), std::string::npos);
}

TEST(HlsWriter, NeverTouchesForeignFiles) {
    for (const std::string name :
         {"holiday.jpg", "master.m3u8", "touch-low.m3u8", "touch-mid-12345678-1.m4s", "touch-12345678-1.txt",
          "colour-1234567-1.m4s", "touch-12345678-.m4s", "touch-12345678-x.m4s", "sub/a"}) {
        const TemporaryFolder folder;
        fs::create_directories((folder / name).parent_path());
        write_bytes(folder / name, "mine");
        const Written written = write_hls({folder.path()}, 5, {true});
        ASSERT_FALSE(written.outcome) << name;
        EXPECT_EQ(written.outcome.error().kind, ErrorKind::input) << name;
        EXPECT_EQ(read_bytes(folder / name), "mine");
        EXPECT_EQ(folder.file_count(), 1U) << name;
    }
}

TEST(HlsWriter, LocksItsFolder) {
    const TemporaryFolder folder;
    const Scene scene = small_hls_scene();
    const auto first = must(HlsWriter::open({folder.path()}, scene));
    EXPECT_TRUE(is_refused(HlsWriter::open({folder.path()}, scene), "another program"));
}

TEST(HlsWriter, RejectsSettingsOutOfRange) {
    const TemporaryFolder folder;
    for (const HlsWriter::Settings& settings : {HlsWriter::Settings{folder.path(), a_second_ns / 4},
                                                HlsWriter::Settings{folder.path(), 11 * a_second_ns},
                                                HlsWriter::Settings{folder.path(), a_second_ns, -1}}) {
        EXPECT_TRUE(is_refused(HlsWriter::open(settings, small_hls_scene()), "", ErrorKind::usage));
    }
}

// HTTP Live Streaming, received: as a clip and as a live source.

/// Segments of half a second, all of them there.
struct SegmentedStream {
    TemporaryFolder folder;
    std::vector<RawFrame> frames;

    SegmentedStream(int count, const Planes& planes, bool sounds = false) {
        const Scene scene = small_scene(64, 48, 16);
        std::optional<SoundPart> sound;
        if (sounds) {
            write_sounding_film(folder / "film.mp4", tone(440, 2));
            sound = SoundPart{folder / "film.mp4", 0, 2 * a_second_ns};
        }
        const auto writer = must(HlsWriter::open({folder / "web", a_second_ns / 2, 0}, scene, sound));
        frames = test_frames(scene, count, planes);
        for (const RawFrame& frame : frames)
            EXPECT_EQ(message(writer->add(frame, stream_label(frame.number), frame.time_ns, true)), "");
        EXPECT_EQ(message(writer->finish()), "");
        EXPECT_TRUE(!sounds || writer->notes().empty());
    }
    /// With another answer where `is_faulty`.
    WebServer::Answer answer(
        const WebReply& fault = {}, const std::function<bool(const std::string&)>& is_faulty =
                                        [](const std::string&) { return false; }) const {
        return [this, fault, is_faulty](const std::string& path) {
            return is_faulty(path) ? fault : reply_with_file(folder / "web", path);
        };
    }
};

TEST(SegmentedClip, ReceivesExactFrames) {
    struct Sent {
        Planes planes;
        bool sounds;
    };
    for (const auto& [planes, sounds] : {Sent{all_planes, false}, Sent{all_planes, true}, Sent{{}, false}}) {
        const SegmentedStream sent(40, planes, sounds);
        const WebServer server(sent.answer());
        expect_as_sent(must(read_clip(server.url("/master.m3u8"))), sent.frames);
    }
}

TEST(SegmentedClip, NeedsAllSegments) {
    const SegmentedStream sent(40, {true, true, false, false});
    for (const char* const segment : {"-0.m4s", "-1.m4s", "-2.m4s"}) {
        const WebServer server(sent.answer({.status = 404}, [&](const std::string& path) {
            return path.starts_with("/touch-") && path.ends_with(segment);
        }));
        EXPECT_TRUE(
            is_refused(read_clip(server.url("/master.m3u8")), "left out 1 of its segments", ErrorKind::input))
            << segment;
    }
}

/// The error names the file that did not come.
TEST(SegmentedClip, OpensInTimeOrFails) {
    const SegmentedStream sent(40, {true, true, false, false});
    for (const std::string silent : {"/master.m3u8", "/touch.m3u8", "-0.m4s"}) {
        const WebServer server(sent.answer({.is_silent = true}, [&](const std::string& path) {
            return path.ends_with(silent) && !path.starts_with("/colour");
        }));
        StreamSource source = source_of(server.url("/master.m3u8"));
        source.patience.opening = std::chrono::seconds(2);
        source.patience.frameset = std::chrono::hours(1);
        const auto clip = open_stream_clip(source);
        EXPECT_TRUE(is_refused(clip, "", ErrorKind::input)) << silent;
        EXPECT_TRUE(message(clip).starts_with(server.url("/"))) << message(clip);
        EXPECT_TRUE(message(clip).ends_with(silent + ": did not come in time")) << message(clip);
    }
}

TEST(SegmentedClip, OpensWithoutMissingColour) {
    const SegmentedStream sent(40, {true, true, false, false});
    for (const char* silent : {"/colour.m3u8", "-0.m4s"}) {
        const WebServer server(sent.answer({.is_silent = true}, [&](const std::string& path) {
            return path.ends_with(silent) && path.starts_with("/colour");
        }));
        const auto clip = must(open_clip(server.url("/master.m3u8")));
        const RawFrame frame = next_of(*clip);
        EXPECT_TRUE(same_plane(frame.depth, sent.frames[0].depth)) << silent;
        EXPECT_TRUE(frame.colour.empty()) << silent;
    }
}

TEST(SegmentedClip, NamesTooLargePlaylist) {
    const TemporaryFolder folder;
    const std::string file = folder / "b.m3u8";
    std::ofstream(file) << "#EXTM3U\n" << std::string(2 << 20, '#');
    const auto clip = open_clip(file);
    EXPECT_TRUE(message(clip).starts_with(file + ": is larger than 1 MiB; expected")) << message(clip);
}

TEST(SegmentedClip, PlaysLiveToItsEnd) {
    const SegmentedStream sent(40, {true, true, false, false});
    const WebServer server(sent.answer());
    const auto clip = must(open_live_stream(source_of(server.url("/master.m3u8"))));
    ASSERT_EQ(message(clip->next()), "");
    const auto begun = std::chrono::steady_clock::now();
    ASSERT_EQ(message(clip->begin(begun)), "");
    std::int64_t last = 0, frames = 0;
    while (true) {
        const auto frame = must(clip->next());
        if (!frame) break;
        EXPECT_GT(frame->number, last);
        last = frame->number;
        ++frames;
    }
    EXPECT_GT(frames, 5);
    EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(1'200))
        << "they are as far apart as they were taken";
    EXPECT_TRUE(has_words(clip->remarks().front(), "has come to its end"));
}

/// The rest of a long stream waits at its server.
TEST(SegmentedClip, LiveFetchesWhatItHasRoomFor) {
    const SegmentedStream sent(300, {true, true, false, false});
    std::atomic<int> fetched{0};
    const WebServer server([answer = sent.answer(), &fetched](const std::string& path) {
        fetched += path.find(".m3u8") == std::string::npos;
        return answer(path);
    });
    const auto clip = must(open_live_stream(source_of(server.url("/master.m3u8"))));
    ASSERT_EQ(message(clip->next()), "");
    for (int before = -1; before != fetched;) {
        before = fetched;
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    const auto files = std::distance(std::filesystem::recursive_directory_iterator(sent.folder / "web"), {});
    EXPECT_GT(fetched, 0);
    EXPECT_LT(fetched, files * 3 / 4) << files;
}

TEST(SegmentPace, KeepsIntervalsOfFrames) {
    constexpr std::int64_t ms = 1'000'000, step = 33 * ms, sent = labelled_from_ns;
    SegmentPace pace(100 * ms);
    for (int n = 0; n < 60; ++n) {  // two segments at once
        const auto moments = pace.add(sent + n * step, 5'000 * ms);
        EXPECT_EQ(moments.shown_ns, 5'100 * ms + n * step);
        EXPECT_EQ(moments.taken_ns, moments.shown_ns);
    }
    const std::int64_t late = 5'100 * ms + 60 * step + 400 * ms;
    EXPECT_EQ(pace.add(sent + 60 * step, late).shown_ns, late);
    EXPECT_EQ(pace.add(sent + 61 * step, late).shown_ns, late + step);
    EXPECT_EQ(pace.add(sent + 3'600'000 * ms, late + step).shown_ns, late + step) << "the clock jumped";
    EXPECT_EQ(pace.add(sent, late + 2 * step).shown_ns, late + 2 * step) << "and back";
    EXPECT_EQ(pace.add(0, late + 3 * step).shown_ns, late + 3 * step);
    EXPECT_EQ(pace.add(INT64_MAX, late + 3 * step).shown_ns, late + 3 * step);
    EXPECT_EQ(pace.add(INT64_MIN, late + 3 * step).shown_ns, late + 3 * step);
}

}  // namespace
}  // namespace touchable::test
