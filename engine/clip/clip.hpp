#pragma once

// A clip, frame by frame: what every source of frames and every file is to the rest of the program.
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
// scene, and bring it to the scene's form and size. FrameCheck is for classes that are a ClipWriter.
//
// A reader and a writer are used by one thread at a time. From any thread: ClipReader::taken_before, remarks
// and stream_figures. The functions keep no state.

#include <array>
#include <chrono>
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
    bool lossless = false;      ///< as the writer says, though the codec need not be
};

/// Whether a clip's colour is used (ClipReader::leave_out_colour).
enum class Colour { wanted, left_out };

/// What became of the framesets of a live stream.
struct StreamFigures {
    /// Datagrams of a connection, at either end.
    struct Link {
        double rtt_ms = 0;            ///< round trip time, now
        std::int64_t datagrams = 0;   ///< with a part of the stream, those that were sent again included
        std::int64_t lost = 0;        ///< known to be lost; one that is lost twice counts twice
        std::int64_t sent_again = 0;  ///< because they were lost
    };
    /// Which level of a stream in segments was read, full or low.
    struct Levels {
        double full_s = 0, low_s = 0;  ///< of the stream
        std::int64_t changes = 0;      ///< from one to the other
        bool is_low = false;           ///< now
    };

    std::int64_t whole = 0;     ///< received with all planes that are felt
    std::int64_t held = 0;      ///< replaced by the frameset before them: those below
    std::int64_t late = 0;      ///< whole only once a later one had been shown
    std::int64_t lost = 0;      ///< never whole, or overdue while nothing whole comes
    std::int64_t torn = 0;      ///< damaged
    std::int64_t repeated = 0;  ///< pictures that came twice
    std::int64_t connections = 0;
    double delay_ms = 0;             ///< that framesets wait for later ones, now
    double longest_gap_ms = 0;       ///< between two that were whole
    std::optional<Link> link{};      ///< of the newest connection, where its transport counts (SRT)
    std::optional<Levels> levels{};  ///< where the stream has two
};

/// Reads a touchable clip frame by frame.
class ClipReader {
public:
    virtual ~ClipReader() = default;
    virtual const Scene& scene() const = 0;
    /// Filters that its description leaves open, which are off in `scene`.
    virtual UnstatedFilters unstated_filters() const { return {}; }
    /// The scene as a writer is to store it: those filters stay open.
    SceneDescription described() const {
        SceneDescription described(scene());
        described.unstated.filters = unstated_filters();
        return described;
    }
    virtual const std::vector<TrackInfo>& tracks() const = 0;
    /// As the container says; nullopt where only reading would tell.
    virtual std::optional<std::int64_t> frame_count() const = 0;
    /// What a person should know beside the scene's remarks: planes resampled, far plane found in the frames,
    /// defaults assumed.
    virtual const std::vector<std::string>& notes() const = 0;
    /// The camera of each frame as it is stored, where some have another than the scene's; otherwise none.
    /// (`open_clip` gives all frames the scene's.)
    virtual std::span<const Camera> frame_cameras() const { return {}; }
    /// The next frame, whose `storage` keeps its planes; nullopt after the last. An error of kind interrupted
    /// where the thread is asked to stop meanwhile (stop_requested).
    virtual Result<std::optional<RawFrame>> next() = 0;
    /// Back to the first frame.
    virtual Result<void> rewind() = 0;
    /// Makes `next` give this frame: from 0 to the clip's last, or one further, the end. An error of kind
    /// usage beyond that. This implementation, right for every format, reads all frames before it.
    virtual Result<void> seek(std::int64_t frame);
    /// The last frame up to this one from which `seek` decodes nothing that is not wanted; 0 where every seek
    /// begins at the clip's beginning.
    virtual std::int64_t access_point(std::int64_t) const { return 0; }
    /// Colour is not needed: frames that are read from now on may come without it, where that saves decoding.
    /// What is stored of it is still counted, timed and checked for damage.
    virtual void leave_out_colour() {}

    // Of a live source.
    /// Frames come as they are taken: none is there before its time, and one that was missed is gone.
    virtual bool is_live() const { return false; }
    /// A run begins, and this is time 0 of its frames: from here on they come when they are taken, after
    /// those that `next` has given so far, and `seek` and `rewind` are refused. Once, while no other thread
    /// reads.
    virtual Result<void> begin(std::chrono::steady_clock::time_point) { return {}; }
    /// From any thread: how long before its time a frame was taken, ns, as far as that is known of the newest
    /// frames; 0 where its time is when it was taken.
    virtual std::int64_t taken_before(std::int64_t /*frame*/) const { return 0; }
    /// Of a run of it that was kept: when a frame was taken, where its number and the rate do not tell.
    virtual std::optional<std::int64_t> taken_at(std::int64_t) const { return std::nullopt; }
    /// From any thread: what a person should know of a run so far, such as that the camera was unplugged. A
    /// source that is gone has no next frame.
    virtual std::vector<std::string> remarks() const { return {}; }
    /// From any thread; nothing where the source is not a network.
    virtual std::optional<StreamFigures> stream_figures() const { return std::nullopt; }

    /// Every file that this clip is read from: first that with its pictures, or each of them, then what lies
    /// beside it, its scene file. None of them may be written to.
    const std::vector<std::filesystem::path>& inputs() const { return inputs_; }
    /// A file that was read to open it.
    void add_input(std::filesystem::path file) { inputs_.push_back(std::move(file)); }
    /// It is read from none that is on this machine.
    void forget_inputs() { inputs_.clear(); }

private:
    std::vector<std::filesystem::path> inputs_;
};

/// The file that may have the clip's sound, that with its pictures; empty where each is a file of its own.
const std::filesystem::path& sound_file_of(const ClipReader& clip);

/// All a person should know of a clip: what was guessed or remarked of its scene, then the reader's notes.
std::vector<Remark> remarks_of(const ClipReader& clip);
/// The same in words (remark_in_words).
std::vector<std::string> clip_notes(const ClipReader& clip);

/// Writes a clip frame by frame, in whatever form: Matroska, MP4, a folder of pictures.
class ClipWriter {
public:
    virtual ~ClipWriter() = default;
    /// Every frame has the planes of the first one, and the next number. Times come from the scene's rate.
    /// Its planes need last no longer than the call.
    virtual Result<void> write(const RawFrame& frame) = 0;
    /// The colour of the frame that was written last as readers will get it, where its coding changes values
    /// and ClipStorage::gives_colour asked for it; empty otherwise. Until the next `write`.
    virtual PlaneView stored_colour() const { return {}; }
    /// The disk has little more room than it takes to complete the clip. Writing goes on, as far as it goes.
    virtual bool is_full() const { return false; }
    /// Completes the clip, which has no name yet, and gives where it can be opened until `finish`. May be
    /// left out.
    virtual Result<std::filesystem::path> complete() = 0;
    /// Gives the complete clip its name; without this nothing is left behind.
    virtual Result<void> finish() = 0;
};

enum class PlaneRole { depth, colour, haptic, height };

inline constexpr std::array all_roles{PlaneRole::depth, PlaneRole::colour, PlaneRole::haptic,
                                      PlaneRole::height};

std::string_view role_name(PlaneRole role);
std::optional<PlaneRole> role_named(std::string_view name);

PlaneView& plane_of(RawFrame& frame, PlaneRole role);
const PlaneView& plane_of(const RawFrame& frame, PlaneRole role);

/// How its pictures are stored as PNG: those of haptic have few materials, each a colour.
PngColours png_colours(PlaneRole role);

/// Where a folder has the pictures of a role.
std::string& pattern_of(FolderSource& source, PlaneRole role);
const std::string& pattern_of(const FolderSource& source, PlaneRole role);

/// Of colour, haptic and height: numbers of their own.
const PictureNumbers& numbers_of(const FolderSource& source, PlaneRole role);

/// Samples and what keeps them alive.
struct Plane {
    PlaneView view;
    std::shared_ptr<const void> storage;
    int bits = 0;  ///< of a grey sample as stored, which may be fewer than its bytes have; 0: all of them
};
/// `bits`: of a grey sample as stored.
Plane plane_from(Image image, int bits = 0);

/// Puts a plane into its place; the frame's storage keeps it alive beside those added before.
void add_plane(RawFrame& frame, PlaneRole role, Plane plane);

/// Refuses samples of a kind the role does not have, and values beyond what the scene says: depth beyond
/// depth_bits, height beyond its code_max. Says nothing about the size. Messages begin with `where`.
Result<void> check_plane(PlaneRole role, const PlaneView& plane, const Scene& scene, std::string_view where);

/// A checked plane of the scene's size: grey colour becomes RGB, grey haptic stiffness (take_grey_haptic),
/// and planes other than depth are resampled to the nearest sample (but colour of a colour_camera, which has
/// to be of that camera's size). Refuses a depth plane of another size, and samples of too few bits for the
/// codes that the scene speaks of.
Result<Plane> fit_plane(PlaneRole role, Plane plane, const Scene& scene, std::string_view where);

/// Grey haptic pictures are stiffness alone. Makes `scene` say that whatever their green and blue are,
/// friction is that of its default_properties, and gives what a person should know.
std::string take_grey_haptic(Scene& scene);

// Each gives what a person should know:
/// of a plane that `fit_plane` resamples;
std::string resampling_note(PlaneRole role, int width, int height, const Scene& scene);
/// of touch planes that a clip does not have; nothing where it has a haptic plane;
std::optional<std::string> default_touch_note(bool has_haptic, const Scene& scene);
/// of a frame in which no pixel of depth is valid; nothing where one is;
std::optional<std::string> no_depth_note(const RawFrame& frame, const DepthCoding& coding);
/// of all planes of a clip, once its first frame is there. `scene` is made to say what grey haptic pictures
/// mean.
std::vector<std::string> describe_planes(const std::vector<TrackInfo>& tracks, const RawFrame& first,
                                         Scene& scene);

/// Of each column (or row) of a picture of `to` the one that its sample is taken from: the nearest to where
/// its middle lies in a picture of `from`.
std::vector<int> nearest_samples(int from, int to);

/// The scene of its pictures at another size. Focal lengths scale; the principal point lies so that samples
/// taken by `nearest_samples` unproject to where they were: exactly, where `from` is a whole multiple of
/// `to`, otherwise up to half a pixel of the larger picture beside it, and on average at their place.
Scene resized_scene(Scene scene, int width, int height);

/// A frame at the size of that scene. Of depth, haptic and height each pixel is a sample as it was, never a
/// mixture: what lies between the two sides of a silhouette is nothing. Colour is the mean of what a pixel
/// covers.
RawFrame resized_frame(const RawFrame& frame, int width, int height);

/// What a writer may count on (ClipWriter::write): frames in order, with depth, all with the planes of the
/// first one, of the scene's size and of samples that the scene allows.
class FrameCheck {
public:
    /// An error of kind internal where a caller breaks that, of kind input where a sample does.
    Result<void> check(const RawFrame& frame, const Scene& scene);
    /// That passed.
    std::int64_t frames() const { return frames_; }
    /// Of the plane in each of them; 0 where there is none.
    int bytes_per_sample(PlaneRole role) const {
        return shapes_[static_cast<std::size_t>(role)].bytes_per_sample;
    }

private:
    /// What stays the same from frame to frame; all zero for a plane that is not there.
    struct Shape {
        int width = 0, height = 0, bytes_per_sample = 0, channels = 0;
        bool operator==(const Shape&) const = default;
    };

    std::array<Shape, all_roles.size()> shapes_;
    std::int64_t frames_ = 0;
};

}  // namespace touchable
