// SPDX-License-Identifier: Apache-2.0
#pragma once

// The boxes of an MP4 file that FFmpeg does not show or write.
//
// A box is a length, a type and a content, and may hold boxes: boxes_in and content_at find them in bytes,
// first_box and movie_head_of in a file. gather_fragments and plain_file turn a fragmented file into a plain
// one; read_scene_stream finds the track of a scene (initial object descriptor, object descriptors, BIFS),
// and with_scene_stream puts one into a file that is written.
//
// Boxes refer to the bytes that they were found in, which must outlive them. The lengths that a box claims
// are checked against the bytes that exist. Errors do not name the file: the caller does (error_at).
// Threads: any may call functions, which keep no state; one uses a ByteSource.

#include <initializer_list>
#include <map>
#include <span>
#include <utility>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/mpeg4/bifs.hpp"

namespace touchable::mpeg4 {

using Bytes = std::vector<std::uint8_t>;
using BytesView = std::span<const std::uint8_t>;

/// A box of an MP4 file (ISO/IEC 14496-12): a length, four letters, and a content.
struct Box {
    std::string type;
    BytesView content;  ///< part of the bytes that were parsed

    /// Position of a box in a file: its head, its content, and its end.
    struct Place {
        std::string type;
        std::uint64_t at = 0, content = 0, end = 0;
    };
};

/// Splits bytes into boxes. An error if one is longer than the bytes left, or there are more than 65536.
Result<std::vector<Box>> boxes_in(BytesView bytes);
/// The first box of a type; null: none.
const Box* box_named(std::span<const Box> boxes, std::string_view type);
/// Content of a box inside boxes, by types from the outermost to its own; empty: no such box.
BytesView content_at(BytesView bytes, std::initializer_list<std::string_view> path);

/// The same boxes, with another content of the box at this path.
Bytes with_content(BytesView boxes, std::span<const std::string_view> path, BytesView content);

/// The box that begins at `at`, in a file or box that ends at `end`; nullopt if it would end later.
Result<std::optional<Box::Place>> box_at(ByteSource& file, std::uint64_t at, std::uint64_t end);
/// The first box of a type between two places; nullopt: none, or none before one that is cut.
Result<std::optional<Box::Place>> first_box(ByteSource& file, std::string_view type, std::uint64_t at,
                                            std::uint64_t end);
/// Bytes of a file. An error if some are missing.
Result<Bytes> bytes_at(ByteSource& file, std::uint64_t at, std::uint64_t count);
/// The content of the file's movie box, without long tables of where samples are; empty: no such box. An
/// error if more than 16 MiB would be left.
Result<Bytes> movie_head_of(ByteSource& file);

/// An integer of so many bytes, the highest first; bytes beyond the end count as zero.
std::uint64_t number_at(BytesView bytes, std::size_t at, int count);
/// The number after the version and the two times at the beginning of boxes such as mvhd, tkhd and mdhd.
std::uint32_t number_behind_times(BytesView content);
void put_number(Bytes& to, std::uint64_t value, int count);
void put_bytes(Bytes& to, BytesView bytes);
/// Numbers one after another, each with how many bytes it has.
Bytes packed_numbers(std::initializer_list<std::pair<std::uint64_t, int>> numbers);
/// Appends a whole box.
void put_box(Bytes& to, std::string_view type, BytesView content);
Bytes box_of(std::string_view type, BytesView content);

/// The pictures of a fragmented MP4 file (ISO/IEC 14496-12, 8.8), as a plain file would have them. A
/// fragmented file lists its samples part by part, each in a moof box of its own, so that it can be read
/// while it is written, and up to where it was cut.
struct GatheredMovie {
    Bytes head;              ///< put before the file's own bytes, all of which are samples then
    std::uint64_t size = 0;  ///< of the file
    bool is_cut = false;     ///< it ends in the middle of a box
};
/// Gathers all fragments with complete samples; nullopt if the movie box announces no fragments (mvex).
Result<std::optional<GatheredMovie>> gather_fragments(ByteSource& file);

/// Returns the plain file.
std::unique_ptr<ByteSource> plain_file(const GatheredMovie& movie, std::unique_ptr<ByteSource> file);

/// A scene, and the tracks of its pictures, as an MP4 file carries them (ISO/IEC 14496-14): its initial
/// object descriptor (box iods) names two tracks of MPEG-4 Systems, one of BIFS (handler sdsm) and one of
/// object descriptors (odsm), which say which track each number in the scene means.
struct SceneStream {
    BifsConfig config;
    Bytes scene;                                     ///< one access unit
    std::map<std::uint16_t, std::uint32_t> objects;  ///< object descriptor -> track_ID
};

/// The bytes of a file from `at` on, `count` of them.
using ReadBytes = std::function<Result<Bytes>(std::uint64_t at, std::uint64_t count)>;

/// Reads the scene of a movie box; nullopt: none. `read` reads the samples.
Result<std::optional<SceneStream>> read_scene_stream(BytesView moov, const ReadBytes& read);

/// Where the first sample of a track is, and how many the track has.
struct FirstSample {
    std::uint64_t at = 0, bytes = 0, count = 0;
};
/// Finds it in a movie box. An error if that has no such track, or the track has no sample.
Result<FirstSample> first_sample_of(BytesView moov, std::uint32_t track);

/// Returns what replaces a movie box at `at`, so that its file has a scene: a box with the samples of both
/// tracks (mdat), and the movie box with iods and those tracks. Other samples stay where they are, so it must
/// be the file's last box. Tracks of pictures other than `shown` are marked as auxiliary to it (handler auxv,
/// reference vdep): ordinary players ignore them. All objects of the scene are enabled.
Result<Bytes> with_scene_stream(BytesView moov, const SceneStream& stream, std::uint32_t shown,
                                std::uint64_t at);
/// Returns a movie box without a scene whose tracks of pictures are marked so.
Result<Bytes> with_auxiliary_tracks(BytesView moov, std::uint32_t shown);

}  // namespace touchable::mpeg4
