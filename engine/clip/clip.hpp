// SPDX-License-Identifier: Apache-2.0
#pragma once

// A clip, frame by frame: the interface of every source of frames and every file.
//
//     TRY_ASSIGN(auto clip, open_clip(...));  // engine/formats, engine/stream or engine/camera
//     while (true) {
//         TRY_ASSIGN(auto frame, clip->next());
//         if (!frame) break;                  // after the last one
//         ...                                 // planes: frame->depth, colour, haptic, height
//     }
//
// ClipReader reads, ClipWriter writes; both check what they are given, and an error names file, track and
// frame. Planes have roles (PlaneRole): functions here find a frame's plane by its role, check it against the
// scene, and bring it to the scene's form and size; PlaneLoss measures what that or a codec loses. FrameCheck
// is for implementations of ClipWriter.
//
// Threads: one at a time uses a reader or a writer; any may call ClipReader::taken_before, remarks and
// stream_figures. The functions keep no state.

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

struct TrackInfo {
    std::string role;           ///< "depth", "colour", "haptic", "height"
    std::string codec;          ///< as FFmpeg names it, or "t3dz", "t3d2"
    std::string pixel_format;   ///< FFmpeg's, or how samples are split
    int width = 0, height = 0;  ///< as stored, before resampling to the depth plane's size
    bool lossless = false;      ///< stated by the writer; the codec alone may be lossy
};

enum class PlaneRole { depth, colour, haptic, height };

inline constexpr std::array all_roles{PlaneRole::depth, PlaneRole::colour, PlaneRole::haptic,
                                      PlaneRole::height};

std::string_view role_name(PlaneRole role);
std::optional<PlaneRole> role_named(std::string_view name);

/// A note for the user.
struct ClipNote : std::string {
    ClipNote(std::string words) : std::string(std::move(words)) {}
    /// "haptic is " and these words.
    ClipNote(PlaneRole of, const std::string& words)
        : std::string(std::string(role_name(of)) + " is " + words), plane(of) {}
    std::optional<PlaneRole> plane{};  ///< the note is on this plane, and gone once another replaces it
};

/// Whether a clip's colour is used (ClipReader::leave_out_colour).
enum class Colour { wanted, left_out };

/// Statistics of a live stream's framesets.
struct StreamFigures {
    /// Datagrams of a connection, at either end.
    struct Link {
        double rtt_ms = 0;            ///< round trip time, now
        std::int64_t datagrams = 0;   ///< with stream data, retransmissions included
        std::int64_t lost = 0;        ///< known to be lost; one lost twice counts twice
        std::int64_t sent_again = 0;  ///< retransmissions
    };
    /// How long each level of a segmented stream was read, full or low.
    struct Levels {
        double full_s = 0, low_s = 0;  ///< seconds of the stream
        std::int64_t changes = 0;      ///< switches between the levels
        bool is_low = false;           ///< current level
    };

    std::int64_t whole = 0;     ///< received with all planes that are felt
    std::int64_t held = 0;      ///< replaced by the frameset before: late, lost or torn
    std::int64_t late = 0;      ///< whole only after a later one was shown
    std::int64_t lost = 0;      ///< never whole, or overdue while no whole one comes
    std::int64_t torn = 0;      ///< damaged
    std::int64_t repeated = 0;  ///< pictures that came twice
    std::int64_t connections = 0;
    double delay_ms = 0;             ///< current wait of framesets for later ones
    double longest_gap_ms = 0;       ///< between two whole framesets
    std::optional<Link> link{};      ///< newest connection, if its transport counts (SRT)
    std::optional<Levels> levels{};  ///< if the stream has two
    std::string reconnects{};        ///< why it is connecting again, as a remark; empty: it is connected
};

/// Reads a touchable clip frame by frame.
class ClipReader {
public:
    virtual ~ClipReader() = default;
    virtual const Scene& scene() const = 0;
    /// Filters that the clip's description leaves unstated; they are off in `scene`.
    virtual UnstatedFilters unstated_filters() const { return {}; }
    /// The scene as a writer is to store it: with `unstated_filters` still unstated.
    SceneDescription described() const {
        SceneDescription described(scene());
        described.unstated.filters = unstated_filters();
        return described;
    }
    virtual const std::vector<TrackInfo>& tracks() const = 0;
    /// As the container states it; nullopt if only reading would tell.
    virtual std::optional<std::int64_t> frame_count() const = 0;
    /// Notes for the user beside the scene's remarks: planes resampled, far plane found in the frames,
    /// defaults assumed.
    virtual const std::vector<ClipNote>& notes() const = 0;
    /// The stored camera of each frame, if some differ from the scene's; otherwise empty. (`open_clip` gives
    /// all frames the scene's.)
    virtual std::span<const Camera> frame_cameras() const { return {}; }
    /// The next frame, whose `storage` keeps its planes; nullopt after the last. An error of kind interrupted
    /// if the thread is to stop meanwhile (stop_requested).
    virtual Result<std::optional<RawFrame>> next() = 0;
    /// Goes back to the first frame.
    virtual Result<void> rewind() = 0;
    /// Makes `next` return this frame: 0 to the clip's last, or one further, the end. An error of kind usage
    /// beyond that. This default works for every format: it reads all frames before.
    virtual Result<void> seek(std::int64_t frame);
    /// The last frame at or before this one that `seek` reaches without decoding others; 0 if every seek
    /// begins at the clip's beginning.
    virtual std::int64_t access_point(std::int64_t) const { return 0; }
    /// Colour is not needed: later frames may come without it if that saves decoding. Stored colour is still
    /// counted, timed and checked for damage.
    virtual void leave_out_colour() {}

    // Live sources.
    /// Whether frames come as they are taken: none is available before its time, and a missed one is lost.
    virtual bool is_live() const { return false; }
    /// Begins a run, with this as time 0 of its frames: from now on frames come when they are taken, numbered
    /// after those given so far; `seek` and `rewind` are refused. Once, while no other thread reads.
    virtual Result<void> begin(std::chrono::steady_clock::time_point) { return {}; }
    /// From any thread: ns from when a frame was taken to its time, if known (newest frames only); 0 if its
    /// time is when it was taken.
    virtual std::int64_t taken_before(std::int64_t /*frame*/) const { return 0; }
    /// In a kept recording of a live run: when a frame was taken, ns; nullopt if its number and the rate
    /// tell.
    virtual std::optional<std::int64_t> taken_at(std::int64_t) const { return std::nullopt; }
    /// From any thread: remarks for the user on the run so far, such as that the camera was unplugged. A
    /// source that is gone has no next frame.
    virtual std::vector<std::string> remarks() const { return {}; }
    /// From any thread; nullopt if the source is not a network stream.
    virtual std::optional<StreamFigures> stream_figures() const { return std::nullopt; }

    /// Every file that this clip is read from: first its picture file or files, then those beside them, such
    /// as the scene file. None of them may be written to.
    const std::vector<std::filesystem::path>& inputs() const { return inputs_; }
    /// For messages: the first of these; a stream has none.
    std::string name() const { return inputs_.empty() ? "the stream" : inputs_.front().string(); }
    /// Adds a file that was read to open the clip.
    void add_input(std::filesystem::path file) { inputs_.push_back(std::move(file)); }
    /// The clip is read from no file on this machine.
    void forget_inputs() { inputs_.clear(); }

private:
    std::vector<std::filesystem::path> inputs_;
};

/// The file that may have the clip's sound: its picture file; empty for a folder of pictures.
const std::filesystem::path& sound_file_of(const ClipReader& clip);

/// All remarks for the user: what was guessed or remarked on the scene, then the reader's notes.
std::vector<Remark> remarks_of(const ClipReader& clip);

/// Writes a clip frame by frame, in any form: Matroska, MP4, a folder of pictures.
class ClipWriter {
public:
    virtual ~ClipWriter() = default;
    /// Every frame must have the planes of the first one, and the next number. Times come from the scene's
    /// rate. The planes need to last only for the call.
    virtual Result<void> write(const RawFrame& frame) = 0;
    /// Colour of the frame written last as readers will get it, if its coding is lossy and
    /// ClipStorage::gives_colour is set; empty otherwise. Valid until the next `write`.
    virtual PlaneView stored_colour() const { return {}; }
    /// Whether the disk has little more room than completing the clip takes. Writing goes on as far as it
    /// can.
    virtual bool is_full() const { return false; }
    /// Completes the clip, which has no name yet; returns where it can be opened until `finish`. Optional.
    virtual Result<std::filesystem::path> complete() = 0;
    /// Gives the complete clip its name; without this call no file is left.
    virtual Result<void> finish() = 0;
};

PlaneView& plane_of(RawFrame& frame, PlaneRole role);
const PlaneView& plane_of(const RawFrame& frame, PlaneRole role);
/// The planes that a frame has, with their roles.
std::vector<std::pair<PlaneRole, PlaneView>> planes_of(const RawFrame& frame);

/// How a role's pictures are stored as PNG: haptic has few materials, each a colour.
PngColours png_colours(PlaneRole role);

/// The name pattern of a role's pictures in a folder.
std::string& pattern_of(FolderSource& source, PlaneRole role);
const std::string& pattern_of(const FolderSource& source, PlaneRole role);

/// The picture numbers of colour, haptic or height.
const PictureNumbers& numbers_of(const FolderSource& source, PlaneRole role);

/// Samples and what keeps them alive.
struct Plane {
    PlaneView view;
    std::shared_ptr<const void> storage;
    int bits = 0;  ///< bits of a grey sample as stored, if fewer than its bytes have; 0: all
};
/// `bits`: of a grey sample as stored.
Plane plane_from(Image image, int bits = 0);

/// Puts a plane into its place; the frame's storage keeps it alive beside those added before.
void add_plane(RawFrame& frame, PlaneRole role, Plane plane);

/// Refuses samples of a kind the role does not have, and values beyond the scene's limits: depth beyond
/// depth_bits, height beyond its code_max. Does not check the size. Messages begin with `where`.
Result<void> check_plane(PlaneRole role, const PlaneView& plane, const Scene& scene, std::string_view where);

/// A checked plane of the scene's size: grey colour becomes RGB, grey haptic stiffness (take_grey_haptic),
/// and planes other than depth are resampled to the nearest sample (except colour of a colour_camera, which
/// must have that camera's size). Refuses a depth plane of another size, and samples of too few bits for the
/// scene's codes.
Result<Plane> fit_plane(PlaneRole role, Plane plane, const Scene& scene, std::string_view where);

/// Grey haptic pictures are stiffness alone. Sets the frictions of `scene` to its default_properties for any
/// green and blue, and returns a note for the user.
ClipNote take_grey_haptic(Scene& scene);

// Each returns a note for the user:
/// on a plane that `fit_plane` resamples;
ClipNote resampling_note(PlaneRole role, int width, int height, const Scene& scene);
/// on touch planes that a clip lacks; nullopt if it has a haptic plane;
std::optional<ClipNote> default_touch_note(bool has_haptic, const Scene& scene);
/// on a frame in which no pixel of depth is valid; nullopt if one is;
std::optional<std::string> no_depth_note(const RawFrame& frame, const DepthCoding& coding);
/// on all planes of a clip, once its first frame is read. Sets in `scene` what grey haptic pictures mean.
std::vector<ClipNote> describe_planes(const std::vector<TrackInfo>& tracks, const RawFrame& first,
                                      Scene& scene);

/// For each column (or row) of a picture of `to`: the column of a picture of `from` that its sample is taken
/// from, the nearest to its middle.
std::vector<int> nearest_samples(int from, int to);

/// The scene of its pictures at another size. Focal lengths scale; the principal point is placed so that
/// samples taken by `nearest_samples` unproject to where they were: exactly if the old size is a whole
/// multiple of the new one, otherwise up to half a pixel of the larger picture off, and on average at their
/// place.
Scene resized_scene(Scene scene, int width, int height);

/// A frame at the size of that scene. A pixel of depth, haptic or height is one stored sample, never a
/// mixture: there is no surface between the two sides of a silhouette. Colour is the mean of the pixels
/// covered.
RawFrame resized_frame(const RawFrame& frame, int width, int height);

/// Loss of one plane: compares each original pixel with the nearest pixel of the output.
struct PlaneLoss {
    std::int64_t samples = 0, changed = 0;
    int largest = 0;     ///< largest difference of a stored value
    double squares = 0;  ///< sum of squared differences
    // Depth only.
    bool is_recoded = false;                        ///< the coding differs: depths are compared
    std::int64_t pixels = 0;                        ///< pixels with a depth in both
    double largest_metres = 0, squares_metres = 0;  ///< over `pixels`
    std::int64_t appeared = 0, disappeared = 0;     ///< pixels that gained a depth; that lost it

    double rms() const { return samples > 0 ? std::sqrt(squares / static_cast<double>(samples)) : 0; }
    double rms_metres() const {
        return pixels > 0 ? std::sqrt(squares_metres / static_cast<double>(pixels)) : 0;
    }
};

/// Indexed by PlaneRole.
using PlaneLosses = std::array<PlaneLoss, all_roles.size()>;

/// Adds the loss between two frames with the same coding (`scene`); sizes may differ.
void add_loss(const RawFrame& before, const RawFrame& now, const Scene& scene, PlaneLosses& losses);

/// As add_loss, for depth alone, between two scenes with different codings and the same unit.
void add_recoded_loss(const RawFrame& before, const Scene& scene, const RawFrame& now, const Scene& recoded,
                      PlaneLosses& losses);

/// Checks what a writer relies on (ClipWriter::write): frames in order, with depth, all with the planes of
/// the first one, of the scene's size and of samples that the scene allows.
class FrameCheck {
public:
    /// An error of kind internal if a caller breaks these rules, of kind input if a sample does.
    Result<void> check(const RawFrame& frame, const Scene& scene);
    /// Frames that passed.
    std::int64_t frames() const { return frames_; }
    /// Of that plane in every frame; 0 if there is none.
    int bytes_per_sample(PlaneRole role) const {
        const PlaneView& form = forms_[static_cast<std::size_t>(role)];
        return form.empty() ? 0 : form.bytes_per_sample;
    }

private:
    std::array<PlaneView, all_roles.size()> forms_;  // of the first frame, whose samples may be gone
    std::int64_t frames_ = 0;
};

}  // namespace touchable
