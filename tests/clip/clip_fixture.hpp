// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip_notes.hpp"
#include "tests/must.hpp"
#include "tests/sweep.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {

/// What a person says of a clip, one thing: stated(&SourceDescription::fov, 60).
template <class Member, class Value>
SourceDescription stated(Member SourceDescription::*member, Value&& value) {
    SourceDescription known;
    known.*member = std::forward<Value>(value);
    return known;
}

inline std::string read_bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}
inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Some file systems flush a file that is cut and rewritten.
inline void write_anew(const std::filesystem::path& file, const std::string& bytes) {
    std::filesystem::remove(file);
    write_bytes(file, bytes);
}

inline Scene small_scene(int width, int height, int depth_bits = 8) {
    Scene scene;
    scene.name = "small";
    scene.width = width;
    scene.height = height;
    scene.camera = {50, 50, width / 2.0, height / 2.0};
    scene.depth.near = 10;
    scene.depth.far = 200;
    scene.depth_bits = depth_bits;
    scene.depth.code_max = static_cast<std::uint16_t>((1 << depth_bits) - 1);
    derive_valid_range(scene.depth);
    return scene;
}

inline Scene scene_with_heights(int width, int height, int depth_bits, int height_bits) {
    Scene scene = small_scene(width, height, depth_bits);
    scene.height_coding = {1.5, HeightUnits::levels, static_cast<std::uint16_t>((1 << height_bits) - 1)};
    return scene;
}

/// Which planes a test clip has beside depth, and how its values lie.
struct Planes {
    bool colour = false, haptic = false, height = false;
    bool noisy = true;  ///< uniform over the whole range; else a ramp
};
inline constexpr Planes all_planes{true, true, true};

using Samples = std::vector<std::uint8_t>;

/// A plane in rows padded by some bytes, so that strides matter.
inline PlaneView test_plane(Samples& memory, int width, int height, int bytes, int channels, int largest,
                            std::uint64_t seed, bool noisy) {
    Random numbers(seed);
    const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(width) * bytes * channels + 6;
    memory.assign(static_cast<std::size_t>(stride * height), 0xEE);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width * channels; ++x) {
            const int value =
                noisy ? numbers.below(largest + 1) : (x + y + static_cast<int>(seed)) % (largest + 1);
            std::uint8_t* at = memory.data() + stride * y + x * bytes;
            if (bytes == 1) *at = static_cast<std::uint8_t>(value);
            const auto word = static_cast<std::uint16_t>(value);
            if (bytes == 2) std::memcpy(at, &word, 2);
        }
    return {memory.data(), stride, width, height, bytes, channels};
}

inline RawFrame test_frame(const Scene& scene, std::int64_t number, const Planes& planes) {
    struct Memory {
        Samples depth, colour, haptic, height;
    };
    auto memory = std::make_shared<Memory>();
    RawFrame frame;
    frame.number = number;
    frame.time_ns = scene.rate.time_ns(number);
    const auto seed = static_cast<std::uint64_t>(number) * 17 + 3;
    const auto plane = [&](Samples& samples, int bytes, int channels, int largest, std::uint64_t salt) {
        return test_plane(samples, scene.width, scene.height, bytes, channels, largest, seed + salt,
                          planes.noisy);
    };
    frame.depth = plane(memory->depth, scene.depth_bits > 8 ? 2 : 1, 1, (1 << scene.depth_bits) - 1, 1);
    if (planes.colour) frame.colour = plane(memory->colour, 1, 3, 255, 2);
    if (planes.haptic) frame.haptic = plane(memory->haptic, 1, 3, 255, 3);
    const int highest = scene.height_coding.code_max;
    if (planes.height) frame.height = plane(memory->height, highest > 255 ? 2 : 1, 1, highest, 4);
    frame.storage = std::move(memory);
    return frame;
}

inline std::vector<RawFrame> test_frames(const Scene& scene, int count, const Planes& planes) {
    std::vector<RawFrame> frames;
    for (int n = 0; n < count; ++n) frames.push_back(test_frame(scene, n, planes));
    return frames;
}

/// From one to several milliseconds apart, at no whole ones.
inline std::vector<std::int64_t> uneven_times(int frames) {
    std::vector<std::int64_t> times_ns;
    for (std::int64_t n = 0; n < frames; ++n)
        times_ns.push_back(1'000'001 * n + 300'000'000 * (n / 7) + n * n * 777);
    return times_ns;
}

/// Colour too comes back as it was.
inline const ClipStorage exact_clip{Archive::fast, true};

/// A whole clip of such frames, by a writer that was just created.
inline Result<void> write_all(Result<std::unique_ptr<ClipWriter>> writer,
                              const std::vector<RawFrame>& frames) {
    if (!writer) return writer.error();
    for (const RawFrame& frame : frames)
        if (auto written = (*writer)->write(frame); !written) return written;
    return (*writer)->finish();
}

inline Result<void> write_clip(const std::filesystem::path& file, const SceneDescription& described,
                               int frames, const Planes& planes, const ClipStorage& storage = exact_clip,
                               const std::optional<SoundPart>& sound = {}) {
    return write_all(create_clip(file, described, storage, Existing::replace, sound),
                     test_frames(described.scene, frames, planes));
}

inline bool same_plane(const PlaneView& a, const PlaneView& b) {
    if (a.empty() || b.empty()) return a.empty() && b.empty();
    if (a.width != b.width || a.height != b.height || a.channels != b.channels ||
        a.bytes_per_sample != b.bytes_per_sample)
        return false;
    for (int y = 0; y < a.height; ++y)
        if (std::memcmp(a.row(y), b.row(y),
                        static_cast<std::size_t>(a.width * a.channels * a.bytes_per_sample)) != 0)
            return false;
    return true;
}

/// Of planes of the same form.
inline double mean_difference(const PlaneView& a, const PlaneView& b) {
    double sum = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x)
            for (int c = 0; c < a.channels; ++c) sum += std::abs(a.sample(x, y, c) - b.sample(x, y, c));
    return sum / (a.width * a.height * a.channels);
}

inline bool same_frame(const RawFrame& a, const RawFrame& b) {
    return a.number == b.number && a.time_ns == b.time_ns && same_plane(a.depth, b.depth) &&
           same_plane(a.colour, b.colour) && same_plane(a.haptic, b.haptic) && same_plane(a.height, b.height);
}

inline ::testing::AssertionResult same_frames(const std::vector<RawFrame>& a,
                                              const std::vector<RawFrame>& b) {
    if (a.size() != b.size()) return ::testing::AssertionFailure() << a.size() << " frames, not " << b.size();
    for (std::size_t n = 0; n < a.size(); ++n)
        if (!same_frame(a[n], b[n])) return ::testing::AssertionFailure() << "frame " << n << " differs";
    return ::testing::AssertionSuccess();
}

/// All frames, which stay alive after the reader; or the first error.
inline Result<std::vector<RawFrame>> read_all(ClipReader& reader) {
    std::vector<RawFrame> frames;
    while (true) {
        auto frame = reader.next();
        if (!frame) return frame.error();
        if (!*frame) return frames;
        frames.push_back(std::move(**frame));
    }
}

/// A clip of a test's own: what each has beside its `next`.
class OwnClip : public ClipReader {
public:
    /// `count`: of its frames, where it is known.
    explicit OwnClip(const Scene& scene, std::optional<std::int64_t> count = {})
        : scene_(scene), count_(count) {}
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return count_; }
    const std::vector<ClipNote>& notes() const override { return notes_; }
    Result<void> rewind() override {
        number_ = 0;
        return {};
    }

    Scene scene_;
    const std::optional<std::int64_t> count_;
    std::vector<TrackInfo> tracks_;
    std::vector<ClipNote> notes_;
    std::int64_t number_ = 0;  ///< of the next frame
};

/// With another scene than its own, by a scene file.
inline Result<std::unique_ptr<ClipReader>> open_as(const std::filesystem::path& clip,
                                                   const SceneDescription& described) {
    const auto file = clip.parent_path() / "scene.json";
    write_bytes(file, scene_to_json(described));
    return open_clip(clip, file);
}

/// Frames of a clip, or the error that came first.
inline Result<std::vector<RawFrame>> read_clip(const std::filesystem::path& file) {
    auto reader = open_clip(file);
    if (!reader) return reader.error();
    return read_all(**reader);
}

/// Remarks that have another kind once a scene file has kept their words; an unclear unit is then a unit.
inline std::string lost_kinds(const std::vector<Remark>& remarks) {
    std::string lost;
    for (const Remark& remark : remarks) {
        const bool is_unclear = remark.kind == RemarkKind::unclear_unit;
        if (remark_of_text(remark_text(remark)).kind != (is_unclear ? RemarkKind::unit : remark.kind))
            lost += remark.what + '\n';
    }
    return lost;
}

inline ::testing::AssertionResult has_words(const std::string& text, const std::string& words) {
    const bool has = text.find(words) != std::string::npos;
    return (has ? ::testing::AssertionSuccess() : ::testing::AssertionFailure())
           << '"' << words << "\" in: " << text;
}
/// Whether something that a person should know of a clip has these words.
inline ::testing::AssertionResult is_noted(const ClipReader& clip, const std::string& words) {
    EXPECT_EQ(lost_kinds(clip.scene().remarks), "");
    std::string all;
    for (const std::string& note : clip_notes(clip)) all += note + '\n';
    return has_words(all, words);
}

/// The error's message; "" without an error.
template <class T>
std::string message(const Result<T>& result) {
    return result ? "" : result.error().message;
}

/// Whether it is an error with these words, and of this kind.
template <class T>
::testing::AssertionResult is_refused(const Result<T>& result, const std::string& words,
                                      std::optional<ErrorKind> kind = {}) {
    if (result) return ::testing::AssertionFailure() << "no error";
    if (kind && result.error().kind != *kind)
        return ::testing::AssertionFailure() << "another kind of error: " << message(result);
    return has_words(message(result), words);
}

/// Whether it is an error of one line about this file.
template <class T>
::testing::AssertionResult is_one_line_about(const std::filesystem::path& file, const Result<T>& result) {
    const std::string why = message(result);
    const bool is_so = why.starts_with(file.string() + ": ") && why.find('\n') == std::string::npos;
    return (is_so ? ::testing::AssertionSuccess() : ::testing::AssertionFailure()) << why;
}

/// The next frame, which must come.
inline RawFrame next_of(ClipReader& reader) {
    auto frame = must(reader.next());
    if (!frame) throw std::runtime_error("no frame comes any more");
    return std::move(*frame);
}

/// The file has exactly these frames, and this scene.
inline void expect_clip(const std::filesystem::path& file, const Scene& scene,
                        const std::vector<RawFrame>& frames, bool says_lossless = true) {
    auto reader = must(open_clip(file));
    EXPECT_EQ(reader->frame_count(), std::ssize(frames));
    Scene found = reader->scene();
    found.folder.reset();
    EXPECT_EQ(scene_to_json(found), scene_to_json(scene));
    for (const TrackInfo& track : reader->tracks())
        EXPECT_TRUE(track.lossless || !says_lossless) << track.role;
    const auto read = must(read_all(*reader));
    reader.reset();  // the frames' storage keeps their planes
    EXPECT_TRUE(same_frames(read, frames))
        << scene.width << 'x' << scene.height << ", " << scene.depth_bits << " bits";
}

/// A clip of test frames has them once it is written.
inline void expect_round_trip(const std::filesystem::path& file, const Scene& scene, int frames,
                              const Planes& planes, const ClipStorage& storage = exact_clip) {
    ASSERT_EQ(message(write_clip(file, scene, frames, planes, storage)), "");
    expect_clip(file, scene, test_frames(scene, frames, planes));
}

/// A seek leads to `from`: that frame comes, then the next.
inline void expect_seek_to(ClipReader& reader, int from, const std::vector<RawFrame>& frames) {
    ASSERT_EQ(message(reader.seek(from)), "") << from;
    for (int n = from; n < std::min(from + 2, static_cast<int>(frames.size())); ++n)
        EXPECT_TRUE(same_frame(next_of(reader), frames[static_cast<std::size_t>(n)])) << from << ' ' << n;
}

}  // namespace touchable::test
