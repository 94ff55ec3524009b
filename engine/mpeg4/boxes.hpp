#pragma once

// The boxes of an MP4 file, as far as FFmpeg does not show or write them.
//
// A box is a length, a type and a content, and may hold boxes: boxes_in and content_at find them in bytes,
// first_box and movie_head_of in a file. gather_fragments and plain_file make a fragmented file a plain one;
// read_scene_stream finds the track of a scene (initial object descriptor, object descriptors, BIFS), and
// with_scene_stream puts one into a file that is written.
//
// Boxes in bytes refer to these bytes, which outlive them. What a box claims is checked against the bytes
// that there are. Errors are lines that follow the file's name (error_at). Functions keep no state; a
// ByteSource is one thread's.

#include <map>
#include <span>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/mpeg4/bifs.hpp"

namespace touchable::mpeg4 {

using Bytes = std::vector<std::uint8_t>;
using BytesView = std::span<const std::uint8_t>;

/// A box of an MP4 file (ISO/IEC 14496-12): a length, four letters, and what is in it.
struct Box {
    std::string type;
    BytesView content;  ///< of the bytes that were parsed

    /// Where a box of a file is: from its head, by what is in it, to the next one.
    struct Place {
        std::string type;
        std::uint64_t at = 0, content = 0, end = 0;
    };
};

/// The boxes that these bytes are, one after the other. An error where one is longer than what is left, or
/// there are more than 65536.
Result<std::vector<Box>> boxes_in(BytesView bytes);
/// The first of a type; null where there is none.
const Box* box_named(std::span<const Box> boxes, std::string_view type);
/// The box in a box in these bytes, by types from the outermost to itself; empty where there is none.
BytesView content_at(BytesView bytes, std::initializer_list<std::string_view> path);

/// The same boxes, but that the one at this path has another content.
Bytes with_content(BytesView boxes, std::span<const std::string_view> path, BytesView content);

/// The box that begins there, of a file or of a box that ends at `end`; nothing where it would end later.
Result<std::optional<Box::Place>> box_at(ByteSource& file, std::uint64_t at, std::uint64_t end);
/// The first of a type between two places; nothing where there is none before one that is cut.
Result<std::optional<Box::Place>> first_box(ByteSource& file, std::string_view type, std::uint64_t at,
                                            std::uint64_t end);
/// Bytes of a file. An error where they are not all there.
Result<Bytes> bytes_at(ByteSource& file, std::uint64_t at, std::uint64_t count);
/// The content of the file's movie box, without what is long and says nothing but where samples are; empty
/// where there is no such box. An error where 16 MiB would be left.
Result<Bytes> movie_head_of(ByteSource& file);

/// A whole number of so many bytes, the highest first; beyond their end there are zeros.
std::uint64_t number_at(BytesView bytes, std::size_t at, int count);
/// Of a box that begins with a version and two times, such as mvhd, tkhd and mdhd, the number behind them.
std::uint32_t number_behind_times(BytesView content);
void put_number(Bytes& to, std::uint64_t value, int count);
void put_bytes(Bytes& to, BytesView bytes);
/// A whole box, at the end.
void put_box(Bytes& to, std::string_view type, BytesView content);
Bytes box_of(std::string_view type, BytesView content);

/// The pictures of a fragmented MP4 file (ISO/IEC 14496-12, 8.8), as a plain file would have them. It tells
/// of its samples stretch by stretch, each in a box moof of its own, so that it can be read while it is
/// written, and up to where it was cut.
struct GatheredMovie {
    Bytes head;              ///< what stands before the file's own bytes, all of which are samples then
    std::uint64_t size = 0;  ///< of the file
    bool is_cut = false;     ///< it ends in the middle of a box
};
/// Of all fragments whose samples are there; nothing where the file's movie box speaks of none (mvex).
Result<std::optional<GatheredMovie>> gather_fragments(ByteSource& file);

/// The plain file.
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

/// What a movie box says; nothing where it has no scene. Samples are read by `read`.
Result<std::optional<SceneStream>> read_scene_stream(BytesView moov, const ReadBytes& read);

/// Where the first sample of a track is, and how many the track has.
struct FirstSample {
    std::uint64_t at = 0, bytes = 0, count = 0;
};
/// By a movie box. An error where it has no such track, or that has no sample.
Result<FirstSample> first_sample_of(BytesView moov, std::uint32_t track);

/// What stands in place of a movie box at `at`, so that its file has a scene: a box with the samples of both
/// tracks (mdat), and the movie box with iods and those tracks. Other samples stay where they are, so it must
/// be the file's last box. Beside `shown`, tracks of pictures are marked as auxiliary to it (handler auxv,
/// reference vdep): ordinary players leave them alone. All that are objects of the scene are enabled.
Result<Bytes> with_scene_stream(BytesView moov, const SceneStream& stream, std::uint32_t shown,
                                std::uint64_t at);
/// A movie box whose tracks of pictures are marked so, and that has no scene.
Result<Bytes> with_auxiliary_tracks(BytesView moov, std::uint32_t shown);

}  // namespace touchable::mpeg4
