// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/sound.hpp"
#include "engine/scene/frames.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/convert_command.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/terminal.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

namespace {

/// Result of a conversion, for the report.
struct Converted {
    std::vector<std::string> notes;  ///< remarks on the source clip
    Scene scene;                     ///< scene of the output
    std::vector<TrackInfo> tracks;   ///< tracks of the output
    std::int64_t frames = 0;
    PlaneLosses losses;
    bool own_times = false;                 ///< frames of the source have
    std::string sound;                      ///< what happened to the sound; empty: no sound
    std::optional<ForceComparison> forces;  ///< if values of touch planes were lost
};

/// `may_be_exact`: the command has --exact-colour.
std::string loss_in_words(PlaneRole role, const PlaneLoss& loss, bool resized, bool may_be_exact) {
    if (loss.changed == 0 && !resized) return "every value kept";
    const std::string share =
        formatted("%.3g %% of the values differ, by %d at most, RMS %.3g",
                  100.0 * static_cast<double>(loss.changed) / static_cast<double>(loss.samples), loss.largest,
                  loss.rms());
    if (role == PlaneRole::colour)
        return (resized ? "averaged: " : "as good as the eye can tell: ") + share +
               (resized || !may_be_exact ? "" : " (--exact-colour keeps every value)");
    std::string words = "LOST: of the pixels before, " + share + "; ";
    if (role != PlaneRole::depth) return words.substr(0, words.size() - 2);
    if (loss.is_recoded) words = "LOST: stored as other codes; ";
    words += formatted("depths by %.3g mm at most, RMS %.3g mm", 1000 * loss.largest_metres,
                       1000 * loss.rms_metres());
    if (loss.appeared + loss.disappeared > 0)
        words += formatted("; %lld pixels lost their depth, %lld without one have one now",
                           static_cast<long long>(loss.disappeared), static_cast<long long>(loss.appeared));
    return words;
}

bool are_floats(ClipForm form) {
    return form == ClipForm::floats || form == ClipForm::float_still;
}

std::string forces_in_words(const ForceComparison& forces) {
    if (forces.both == 0) return "a standard stroke never touches both: what it feels cannot be compared";
    return formatted(
        "on a standard stroke %.2g degrees off on average, 95 %% at most %.2g; %.2g N, at most %.2g of %.2g "
        "N (mean)",
        forces.direction_degrees.mean, forces.direction_degrees.p95, forces.difference_n.mean,
        forces.difference_n.max, forces.mean_a_n);
}

std::string line(const std::string& name, const std::string& words) {
    return "  " + name + std::string(name.size() < 8 ? 8 - name.size() : 1, ' ') + words + "\n";
}

/// Names a still's additional files.
std::string files_beside(const ConvertOptions& options, const Converted& done) {
    const bool is_text = options.form == ClipForm::scene_text;
    const auto opens_it = is_text ? options.out : still_files(options.out)[1];
    std::string words = opens_it.string() + " describes it, and is what opens it";
    for (const TrackInfo& track : done.tracks)
        if (is_text || track.role != "depth")
            words += "; " + options.out.stem().string() + "_" + track.role + ".png is its " + track.role;
    return words;
}

/// Names the files of a glTF scene.
std::string files_of_scene(const ConvertOptions& options, const Converted& done) {
    const std::string stem = options.out.stem().string();
    const bool has_colour =
        std::ranges::any_of(done.tracks, [](const TrackInfo& track) { return track.role == "colour"; });
    std::string words = stem + ".bin";
    if (done.frames > 1) words += ", " + stem + ".mp4";
    if (done.frames > 1 || !has_colour) words += ", " + stem + ".png";
    if (done.frames == 1)
        for (const TrackInfo& track : done.tracks) words += ", " + stem + "_" + track.role + ".png";
    return words + " lie beside it and belong to it";
}

namespace fs = std::filesystem;

/// Checks an existing output folder: an empty one is filled, one written by a conversion may be replaced.
Result<void> check_folder(const ConvertOptions& options, const std::vector<NamedFile>& inputs) {
    std::error_code failure;
    if (!fs::exists(fs::symlink_status(options.out, failure))) return {};
    if (!fs::is_directory(options.out, failure))
        return usage_error("OUT " + options.out.string() +
                           " is there already and no folder; give another name");
    if (fs::is_empty(options.out, failure)) return {};
    std::vector<NamedFile> there;
    for (const auto& entry : fs::directory_iterator(options.out, failure))
        there.push_back({"OUT", entry.path()});
    TRY(check_outputs({there, Existing::replace}, inputs));
    if (options.existing == Existing::keep)
        return usage_error("OUT " + options.out.string() +
                           " is there already; give another name, or --overwrite");
    if (!is_image_folder(options.out))
        return usage_error("OUT " + options.out.string() +
                           " holds other files than a clip's pictures, which --overwrite would not spare; "
                           "give another name");
    return {};
}

bool is_mpeg4_still(ClipForm form) {
    return form == ClipForm::scene_text || form == ClipForm::mp4_still;
}

/// An MPEG-4 scene of pictures holds one frame.
Result<void> check_frames(const ConvertOptions& options, const ClipReader& clip) {
    const auto frames = clip.frame_count();
    if (!is_mpeg4_still(options.form) || options.from || frames == 1) return {};
    return usage_error("OUT " + options.out.string() + " is a scene of one frame, but the clip has " +
                       (frames ? std::to_string(*frames) : "more, as far as it tells") +
                       ": --from says which one; NAME.mp4" + (options.still ? " without --still" : "") +
                       " holds them all");
}

std::vector<fs::path> files_of_one_frame(const ConvertOptions& options) {
    if (options.form == ClipForm::mp4_still) return {options.out};
    return options.form == ClipForm::scene_text ? described_still_files(options.out)
                                                : still_files(options.out);
}

/// The frames whose time begins before the stated end. Other programs round their times, so a time within
/// half of the shortest frame counts as the frame's own.
ClipPart part_of(const ConvertOptions& options, const ClipReader& clip) {
    const FrameRate& rate = clip.scene().rate;
    ClipPart part{.every = options.every, .crop = options.crop};
    constexpr std::int64_t near_ns = shortest_frame_ns / 2;
    if (options.from)
        part.first =
            options.from->time_ns ? rate.frame_at(*options.from->time_ns + near_ns) : options.from->frame;
    if (options.to)
        part.last = options.to->time_ns ? rate.frame_at(*options.to->time_ns - near_ns) : options.to->frame;
    const auto frames = clip.frame_count();
    if (options.to && options.to->time_ns && frames && *part.last >= *frames) part.last.reset();
    if (is_one_frame(options.form)) part.last = part.first;
    return part;
}

/// Whether part_of selects a single frame.
bool is_one_of(const ConvertOptions& options, const ClipReader& clip) {
    const ClipPart part = part_of(options, clip);
    const auto frames = clip.frame_count();
    if (!part.last && !frames) return false;
    const std::int64_t last = part.last ? *part.last : *frames - 1;
    return part.first + part.every > last;
}

/// The files of the page, which lie where the program finds them; none if it was built without.
std::vector<fs::path> page_files() {
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_from_program(TOUCHABLE_WEB_FROM_PROGRAM), ignored))
        if (entry.is_regular_file(ignored)) files.push_back(entry.path());
    return files;
}

Result<void> check_places(const ConvertOptions& options, const ClipReader& reader) {
    const std::vector<NamedFile> inputs = inputs_of(options.clip, reader);
    if (options.form == ClipForm::folder) return check_folder(options, inputs);
    std::vector<NamedFile> outputs;
    if (options.form == ClipForm::archive || options.form == ClipForm::lerobot)
        outputs.push_back({"OUT", options.out});
    if (options.form == ClipForm::web) outputs.push_back({"OUT", options.out / packed_clip_name});
    if (options.form == ClipForm::lerobot) outputs.push_back({"OUT", lerobot_info_file(options.out)});
    if (is_one_frame(options.form) || are_floats(options.form))
        for (const fs::path& file : files_of_one_frame(options)) outputs.push_back({"OUT", file});
    if (options.form == ClipForm::gltf)
        for (const fs::path& file : gltf_clip_files(options.out, is_one_of(options, reader)))
            outputs.push_back({"OUT", file});
    return check_outputs({outputs, options.existing}, inputs);
}

/// Replaces the hidden temporary name of the output by its final name in a message.
Error as_named(Error error, const ConvertOptions& options, const fs::path& written) {
    const bool is_file = options.form == ClipForm::archive || options.form == ClipForm::mp4_still ||
                         options.form == ClipForm::lerobot;
    const fs::path folder = options.out.has_parent_path() ? options.out.parent_path() : fs::path(".");
    error.message = shown_as(error.message, is_file ? written : written.parent_path(),
                             is_file || options.form == ClipForm::folder ? options.out : folder);
    return error;
}

/// Hashes of a frame's planes, small enough to keep for every frame. Indexed by PlaneRole.
using FrameMark = std::array<std::uint64_t, all_roles.size()>;

/// 0 for an absent plane.
std::uint64_t mark_of(const PlaneView& plane) {
    if (plane.empty()) return 0;
    ByteHash hash;
    for (const int part : {plane.width, plane.height, plane.bytes_per_sample, plane.channels})
        hash.add(&part, sizeof part);
    for (int y = 0; y < plane.height; ++y) hash.add(plane.row(y), plane.row_bytes());
    return hash.value();
}

FrameMark mark_of(const RawFrame& frame) {
    FrameMark mark{};
    for (const PlaneRole role : all_roles)
        mark[static_cast<std::size_t>(role)] = mark_of(plane_of(frame, role));
    return mark;
}

/// Tracks to copy without recoding: not planes made by `content`, aligned or filled depth, or planes replaced
/// by a map.
ClipStorage::Copied tracks_to_copy(const ClipReader& clip, const ConvertOptions& options) {
    const StillMaps& maps = options.clip.maps;
    const auto is_other = [&](PlaneRole role) {
        return (role == PlaneRole::depth &&
                (options.clip.alignment == DepthAlignment::on || options.clip.fill_from_motion)) ||
               (role == PlaneRole::haptic && maps.haptic) || (role == PlaneRole::height && maps.height) ||
               std::ranges::find(options.made, role) != options.made.end();
    };
    ClipStorage::Copied copied{clip.inputs().front(), {}};
    for (const TrackInfo& track : clip.tracks())
        if (const auto role = role_named(track.role); role && !is_other(*role)) copied.roles.push_back(*role);
    return copied;
}

std::string report_of_conversion(const ConvertOptions& options, const Converted& done) {
    const Scene& scene = done.scene;
    const bool resized = options.size.has_value();
    std::string text = one_line(options.out.string()) + ": " + counted(done.frames, "frame") + ", " +
                       size_text(scene.width, scene.height);
    if (!is_one_frame(options.form))
        text += formatted(
            scene.rate.own_times ? ", each at its own time, %.6g frames/s on average" : ", %.6g frames/s",
            scene.rate.per_second());
    text += "\n";
    for (const TrackInfo& track : done.tracks) {
        const auto role = role_named(track.role);
        if (!role) continue;
        const bool is_still = done.frames > 1 && scene.folder && options.form == ClipForm::folder &&
                              ((*role == PlaneRole::colour && touchable::is_still(scene.folder->colour)) ||
                               (*role == PlaneRole::haptic && touchable::is_still(scene.folder->haptic)) ||
                               (*role == PlaneRole::height && touchable::is_still(scene.folder->height)));
        text += line(track.role,
                     (are_floats(options.form)
                          ? "metres as floats of 32 bits, NaN where there is no surface"
                          : loss_in_words(*role, done.losses[static_cast<std::size_t>(*role)], resized,
                                          !options.content && options.form != ClipForm::web)) +
                         " (" + track.codec + (is_still ? ", one picture for all frames)" : ")"));
    }
    if (options.form == ClipForm::floats && done.own_times)
        text += line("times", "LOST: an array has one rate, that of their mean");
    if (!done.sound.empty()) text += line("sound", done.sound);
    if (done.forces) text += line("force", forces_in_words(*done.forces));
    if ((is_one_frame(options.form) || are_floats(options.form)) && options.form != ClipForm::mp4_still)
        text += line("scene", files_beside(options, done));
    if (options.form == ClipForm::lerobot)
        text +=
            line("scene", lerobot_info_file(options.out).string() +
                              " says what its codes are, for the features of a data set's meta/info.json; "
                              "colour, haptic, height and sound are not in it");
    if (options.form == ClipForm::gltf) text += line("scene", files_of_scene(options, done));
    if (options.form == ClipForm::web)
        text += line("page", page_files().empty()
                                 ? "left out: this program was built without it (./run web builds it)"
                                 : "index.html; put the folder on any web server, or python3 -m http.server "
                                   "--directory " +
                                       shell_word(options.out.string()));
    for (const std::string& note : done.notes) text += line("note", note);
    return text;
}

/// One finger's goals and forces.
struct Stroke {
    ForceTable forces;
    double metres_per_scene_unit = 0;
};

constexpr const char* wandering = "wander:seed=1";
constexpr std::int64_t standard_stroke_ticks = 3000;  // milliseconds

/// Repeats one finger's recorded goals.
class GoalsAgain final : public Hand {
public:
    explicit GoalsAgain(const ForceTable& before) : before_(before) {}
    int fingers() const override { return 1; }
    void goals_at(std::int64_t tick, const SurfaceProbe&, std::span<glm::dvec3> goals) override {
        goals[0] = before_.at(static_cast<std::size_t>(tick), 0).goal;
    }

private:
    const ForceTable& before_;
};

class ForcesInHand final : public TouchSink {
public:
    Result<void> consume(const TouchTick& tick) override {
        table.samples.push_back({tick.goals[0], tick.forces[0].force, tick.contacts[0].touching});
        return {};
    }
    ForceTable table{1, {}};
};

/// The stroke of a finger that wanders over a clip, always along the same path; or a repeat of `before`'s
/// goals at its scale. The clip has the filters it states, or those chosen from its first frames.
Result<Stroke> stroke(std::unique_ptr<ClipReader> reader, const Stroke* before = nullptr) {
    reader->leave_out_colour();
    Scene scene = reader->scene();
    TRY(settle_filters(reader, reader->unstated_filters(), scene));
    auto builder = make_cpu_builder(scene);
    SurfaceFeed feed(std::move(reader), std::move(builder), scene);
    feed.leave_out_hash();
    TRY_ASSIGN(const auto first, feed.pair_at(0));
    Workspace workspace = clip_workspace(scene, *first.prev.frame);
    if (before) workspace.metres_per_scene_unit = before->metres_per_scene_unit;

    std::unique_ptr<Hand> hand;
    if (before) {
        hand = std::make_unique<GoalsAgain>(before->forces);
    } else {
        const HeightField field(scene, first);
        TRY_ASSIGN(hand, make_hand(wandering, 1, workspace, FieldProbe(field)));
    }
    TouchSessionSettings settings;
    settings.ticks = standard_stroke_ticks;
    settings.touch.metres_per_scene_unit = workspace.metres_per_scene_unit;
    TRY_ASSIGN(const auto solver, TouchSolver::create(scene, settings.touch));
    ForcesInHand forces;
    Progress progress("tick", standard_stroke_ticks);
    std::array<TouchSink*, 2> sinks{&forces, &progress};
    TRY(TouchSession(feed, *hand, solver, settings).run(sinks));
    return Stroke{std::move(forces.table), workspace.metres_per_scene_unit};
}

class Conversion {
public:
    explicit Conversion(const ConvertOptions& options) : options_(options) {}
    /// `at_work`: set to what memory is needed for, once known.
    Result<void> run(std::string& at_work) {
        TRY_ASSIGN(auto clip, open());
        at_work = frames_in_words(clip->scene());
        TRY(check_frames(options_, *clip));
        TRY(check_places(options_, *clip));
        if (options_.content) {
            if (!clip->inputs().empty()) copied_ = tracks_to_copy(*clip, options_);  // a stream has no file
            TRY_ASSIGN(clip, options_.content(std::move(clip)));
        }
        std::error_code ignored;
        is_stream_ = !clip->frame_count() && !fs::is_regular_file(options_.clip.file, ignored);
        part_ = part_of(options_, *clip);
        from_ns_ = clip->scene().rate.time_ns(part_.first);
        TRY_ASSIGN(auto part, part_of_clip(std::move(clip), part_));
        if (options_.form == ClipForm::web) {
            settled_ = part->scene();
            TRY_ASSIGN(const auto chosen, settle_filters(part, part->unstated_filters(), *settled_));
            if (!options_.filtered) error_bars_to_ = error_bars_to(chosen, settled_->filter);
        }
        source_ = std::move(part);
        if (options_.form == ClipForm::lerobot) {
            const Scene& scene = source_->scene();
            codes_.emplace(options_.size ? resized_scene(scene, options_.size->width, options_.size->height)
                                         : scene);
        }
        TRY(check_loss());
        TRY(open_writer());
        TRY(write());
        TRY(finish());
        return broke_off_ ? *broke_off_ : Result<void>();
    }

private:
    Result<std::unique_ptr<ClipReader>> open() {
        if (!options_.filtered) return options_.clip.open();
        TRY_ASSIGN(auto opened, open_filtered(options_.clip, Colour::wanted));
        error_bars_to_ = error_bars_to(opened.chosen, opened.scene.filter);
        return std::move(opened.reader);
    }

    Result<void> finish() {
        // A stream cannot be received again: a stop does not end its completion.
        const StopScope keeps = is_stream_ ? StopScope::after_stop() : StopScope(StopScope::never);
        // Complete only after the whole clip was read.
        done_.notes = remarks_with_options(remarks_of(*source_));
        std::ranges::copy(source_->remarks(), std::back_inserter(done_.notes));  // on how it came
        TRY_ASSIGN(const auto written, writer_->complete());
        if (auto checked = check(written); !checked) return as_named(checked.error(), options_, written);
        TRY(writer_->finish());
        std::cout << report_of_conversion(options_, done_);
        return {};
    }

    /// The source for a consumer that must see all frames (a stroke): each frame read is also written, so
    /// that the source is read once.
    class Source final : public ReaderAround {
    public:
        explicit Source(Conversion& conversion) : ReaderAround(conversion.source_), conversion_(conversion) {}
        void leave_out_colour() override {}  // it is written
        Result<std::optional<RawFrame>> next() override { return conversion_.next(); }

    private:
        Conversion& conversion_;
    };

    bool is_resized() const {
        const Scene& scene = source_->scene();
        const auto& size = options_.size;
        return size && (size->width != scene.width || size->height != scene.height);
    }

    bool is_recoded() const { return codes_ && !codes_->are_kept(); }
    /// A video for LeRobot contains no scene, and its description beside it has no name yet.
    Result<std::unique_ptr<ClipReader>> reopened(const fs::path& written) const {
        if (!codes_) return open_clip(written);
        SceneDescription described(codes_->scene());
        described.scene.folder.reset();
        described.scene.video =
            VideoSource{written.filename().string(), "", VideoLayout::alone, VideoValues::grey};
        return open_video_clip(written.parent_path(), described);
    }

    /// Refuses unstated losses: dropped planes, recoding or resizing need --allow-lossy.
    Result<void> check_loss() const {
        const auto& tracks = source_->tracks();
        const bool drops_touch =
            (codes_ || are_floats(options_.form)) && std::ranges::any_of(tracks, [](const TrackInfo& track) {
                return track.role == role_name(PlaneRole::haptic) ||
                       track.role == role_name(PlaneRole::height);
            });
        if (drops_touch && !options_.allow_lossy)
            return usage_error(
                (codes_ ? "--lerobot" : options_.out.string()) +
                std::string(" leaves out haptic and height pictures, for which it has no room; say "
                            "--allow-lossy as well"));
        if (const double far = codes_ ? codes_->scene().depth.far * codes_->scene().metres_per_unit : 0;
            !(far < lerobot_horizon))
            return usage_error("--lerobot: depth may be " + short_number(far) +
                               " m deep: must be less than " + short_number(lerobot_horizon) +
                               " m; a scene file with a smaller far (touchable init-scene) says so");
        if (is_recoded() && !options_.allow_lossy)
            return usage_error(
                "--lerobot changes what is touched: depth becomes 4095 steps, " +
                short_number(1000 * codes_->step_at_a_metre(), 2) +
                " mm wide at 1 m; say --allow-lossy as well, and the report tells what is lost");
        if (!is_resized() || options_.allow_lossy) return {};
        const Scene& scene = source_->scene();
        const auto& size = options_.size;
        return usage_error("--size " + size_text(size->width, size->height) +
                           " changes what is touched: the pictures are " +
                           size_text(scene.width, scene.height) +
                           "; say --allow-lossy as well, and the report tells what is lost");
    }

    /// Printed before anything is written.
    void say_what_mpeg4_cannot(const Scene& scene) const {
        const bool is_still = is_mpeg4_still(options_.form);
        if (!is_still && !(options_.form == ClipForm::archive && is_mp4_name(options_.out))) return;
        if (options_.storage.fragmented) {
            std::cout << one_line(options_.out.string())
                      << ": has no MPEG-4 scene in fragments. touchable reads it from the file's tags; other "
                         "programs do not."
                      << std::endl;
            return;
        }
        mpeg4::ClipNodes::Streams streams;
        for (const TrackInfo& track : source_->tracks())
            streams.haptic = streams.haptic || track.role == "haptic";
        const auto textures = is_still ? mpeg4::Textures::pictures : mpeg4::Textures::tracks;
        const std::string all = listed(mpeg4::unsaid_by_nodes(scene, streams, textures), {}, "; ");
        if (!all.empty())
            std::cout << one_line(options_.out.string()) << ": its MPEG-4 scene cannot say: " << all
                      << ". touchable reads that from "
                      << (is_still ? "a WorldInfo in the scene" : "the file's tags")
                      << "; other programs do not." << std::endl;
    }

    Result<void> open_writer() {
        SceneDescription described = source_->described();
        if (options_.size)
            described.scene = resized_scene(described.scene, options_.size->width, options_.size->height);
        if (codes_) described = codes_->scene();
        if (settled_) {
            described.scene.filter = settled_->filter;
            described.unstated.filters = {};
            described.error_bars_to = error_bars_to_;
        }
        done_.scene = described.scene;
        done_.own_times = described.scene.rate.own_times != nullptr;
        say_what_mpeg4_cannot(described.scene);
        TRY_ASSIGN(writer_, [&]() -> Result<std::unique_ptr<ClipWriter>> {
            const auto sound = chosen_sound();
            switch (options_.form) {
                case ClipForm::folder:
                    return create_image_folder(options_.out, described, options_.existing);
                case ClipForm::still:
                    return create_still(options_.out, described, options_.existing);
                case ClipForm::scene_text:
                    return create_scene_text(options_.out, described, options_.existing);
                case ClipForm::mp4_still:
                    return create_mp4_stills(options_.out, described, options_.existing);
                case ClipForm::web:
                    return create_packed_clip(options_.out, described, page_files(), options_.existing);
                case ClipForm::floats:
                case ClipForm::float_still:
                    return create_float_depth(options_.out, described, options_.existing);
                case ClipForm::lerobot:
                    return create_lerobot_video(options_.out, described.scene, options_.existing);
                case ClipForm::archive:
                case ClipForm::gltf:
                    break;
            }
            ClipStorage storage = options_.storage;
            storage.gives_colour = true;
            storage.copied = copied_;
            if (options_.form == ClipForm::gltf)
                return create_gltf_clip(options_.out, described, is_of_one_frame(), storage,
                                        options_.existing, sound);
            return create_clip(options_.out, described, storage, options_.existing, sound);
        }());
        return {};
    }

    bool is_of_one_frame() const { return source_->frame_count() == 1; }

    /// The clip's sound to keep; also fills in the report on it.
    std::optional<SoundPart> chosen_sound() {
        const fs::path file = sound_file_of(*source_);
        const auto sound = sound_of(file);
        if (!sound) return std::nullopt;
        const bool is_gltf = options_.form == ClipForm::gltf, is_mp4 = is_mp4_name(options_.out) || is_gltf,
                   is_fragmented = options_.storage.fragmented;
        // A glTF scene of one frame holds pictures.
        const bool is_video = options_.form == ClipForm::archive || (is_gltf && !is_of_one_frame());
        const bool fits = is_fragmented ? sound->storable_in_fragments
                          : is_mp4      ? sound->storable_in_mp4
                                        : sound->storable;
        if (!is_video || !fits) {
            done_.sound = "LOST: " + sound->codec +
                          (codes_          ? ", which LeRobot keeps elsewhere"
                           : !is_video     ? ", which pictures cannot hold"
                           : is_fragmented ? ", which an MP4 file in fragments cannot hold"
                           : is_mp4        ? ", which an MP4 file cannot hold"
                                           : ", which a clip cannot hold");
            return std::nullopt;
        }
        done_.sound = "kept as it is (" + sound->codec + ")";
        const FrameRate& rate = source_->scene().rate;
        const std::int64_t frames = source_->frame_count().value_or(std::int64_t{1} << 32);
        return SoundPart{file, from_ns_, from_ns_ + rate.time_ns(frames)};
    }

    RawFrame as_written(const RawFrame& frame) const {
        const RawFrame sized =
            options_.size ? resized_frame(frame, options_.size->width, options_.size->height) : frame;
        return codes_ ? codes_->of(sized) : sized;
    }

    /// The source's next frame; writes it if not yet written. A stream that breaks off, or that a person
    /// stops, ends there.
    Result<std::optional<RawFrame>> next() {
        if (broke_off_) return std::optional<RawFrame>();
        auto frame =
            stop_requested() ? Result<std::optional<RawFrame>>(interrupted_error()) : source_->next();
        if (const auto kind = frame ? ErrorKind::internal : frame.error().kind;
            is_stream_ && done_.frames > 0 && (kind == ErrorKind::interrupted || kind == ErrorKind::input)) {
            broke_off_ = frame.error();
            if (kind == ErrorKind::interrupted) broke_off_->message = "interrupted";
            broke_off_->message +=
                "; " + options_.out.string() + " has what came, " + counted(done_.frames, "frame");
            return std::optional<RawFrame>();
        }
        if (!frame || !*frame) return frame;
        if ((*frame)->number == done_.frames) TRY(write_frame(**frame));
        return frame;
    }

    /// Marks the frame as readers will get it: colour as coded, all other planes unchanged.
    Result<void> write_frame(const RawFrame& frame) {
        const StopScope whole = is_stream_ ? StopScope::after_stop() : StopScope(StopScope::never);
        progress_->at(++done_.frames);
        RawFrame stored = as_written(frame);
        TRY(writer_->write(stored));
        if (const PlaneView colour = writer_->stored_colour(); !colour.empty()) stored.colour = colour;
        if (is_recoded())
            add_recoded_loss(frame, source_->scene(), stored, done_.scene, done_.losses);
        else
            add_loss(frame, stored, done_.scene, done_.losses);
        marks_.push_back(mark_of(stored));
        return {};
    }

    Result<void> write() {
        progress_.emplace("converting frame", source_->frame_count().value_or(0));
        if (is_resized() || is_recoded()) TRY(assign(stroke_, stroke(std::make_unique<Source>(*this))));
        while (true) {
            TRY_ASSIGN(const auto frame, next());
            if (!frame) break;
        }
        progress_.reset();
        return {};
    }

    /// Compares the output with the marks of the frames written.
    Result<void> compare(ClipReader& written) {
        Progress progress("comparing frame", done_.frames);
        for (std::int64_t number = 0; number < done_.frames; ++number) {
            if (stop_requested()) return interrupted_error();
            progress.at(number + 1);
            TRY_ASSIGN(const auto now, written.next());
            if (!now || mark_of(*now) != marks_[static_cast<std::size_t>(number)])
                return internal_error(options_.out.string() + ": not written: frame " +
                                      std::to_string(number) + " comes back otherwise than it was");
        }
        return {};
    }

    Result<void> check(const fs::path& written) {
        TRY_ASSIGN(auto reader, reopened(written));
        done_.scene = reader->scene();
        done_.tracks = reader->tracks();
        if (are_floats(options_.form)) return {};  // they may come back as other codes, as near as floats are
        TRY(compare(*reader));
        const auto lost = [&](PlaneRole role) {
            return done_.losses[static_cast<std::size_t>(role)].changed > 0;
        };
        if (!lost(PlaneRole::depth) && !lost(PlaneRole::haptic) && !lost(PlaneRole::height)) return {};
        TRY(reader->rewind());
        TRY_ASSIGN(const auto repeated, stroke(std::move(reader), &*stroke_));
        TRY_ASSIGN(done_.forces, compare_forces(stroke_->forces, repeated.forces));
        return {};
    }

    const ConvertOptions& options_;
    ClipPart part_;
    std::int64_t from_ns_ = 0;  // start of the part in the clip
    bool is_stream_ = false;
    std::optional<Error> broke_off_;  // why a stream of which frames are kept ended early
    std::shared_ptr<ClipReader> source_;
    std::unique_ptr<ClipWriter> writer_;
    std::optional<ClipStorage::Copied> copied_;  // for a clip whose content is changed
    std::optional<Progress> progress_;
    std::vector<FrameMark> marks_;       // of the frames as readers will get them
    std::optional<Stroke> stroke_;       // over the source, if its size or codes change
    std::optional<LeRobotCodes> codes_;  // for a video for LeRobot
    std::optional<Scene> settled_;       // for a page: with all filters
    double error_bars_to_ = 0;           // of that scene
    Converted done_;
};

}  // namespace

Result<void> run_convert(const ConvertOptions& options) {
    std::string at_work = "the frames of " + options.clip.file.string();
    return within_memory(at_work, [&] { return Conversion(options).run(at_work); });
}

}  // namespace touchable
