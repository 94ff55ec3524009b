// Guesses the scene of depth pictures without a scene file (SceneGuess). Stated values (SourceDescription)
// are kept; the rest comes from files beside the pictures, from their names and from their values.

#include <cmath>
#include <iterator>
#include <numeric>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/colour_video.hpp"
#include "engine/formats/foreign_files.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/organised_cloud.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/formats/realsense_raw.hpp"
#include "engine/formats/value_evidence.hpp"
#include "engine/picture/image.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr double most_of_lengths = 1.05;                 // lower third of a picture over the upper
constexpr double assumed_near = 0.5, assumed_far = 1.5;  // metres, of depth without a scale

/// The preset by the name of depth's channel in a rendering, or else by its values.
EvidentPreset evident_in(const StoredImage& picture) {
    if (picture.beside && is_exr_depth_of_unreal(picture.beside->depth_name))
        return {preset_named("unreal"), "its channel's name is Unreal's"};
    return evident_preset(picture);
}

/// The rate that programs mean by a number: 29.97 is 30000/1001.
FrameRate stated_rate(double per_second) {
    const double whole = std::round(per_second), ntsc = whole * 1000 / 1001;
    if (std::abs(per_second - ntsc) < 0.0006 * whole && whole >= 24)
        return {1000 * static_cast<std::int64_t>(whole), 1001};
    const std::int64_t thousandths = std::llround(1000 * per_second), common = std::gcd(thousandths, 1000);
    return {thousandths / common, 1000 / common};
}

/// Whether a name has one of these words, all letters small, as a word of its own: "disp" of "disp0.pfm" and
/// "disp_occ/1.png", not of "display.png".
bool has_whole_word(const std::string& name, std::initializer_list<std::string_view> words) {
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    std::string word;
    for (const char c : name + '.') {
        if (is_letter(c)) {
            word += static_cast<char>(c | 0x20);
            continue;
        }
        if (std::ranges::count(words, std::string_view(word)) > 0) return true;
        word.clear();
    }
    return false;
}

bool is_named_disparity(const std::string& name) {
    return has_whole_word(name, {"disp", "disparity", "disparities"}) ||
           has_word(name, {"inverse_depth", "inv_depth", "invdepth", "inversedepth"});
}

/// Whether a name says distances from the camera's centre, as Hypersim's depth_meters and Replicator's
/// distance_to_camera are.
bool is_named_range(const std::string& name) {
    return has_whole_word(name, {"range", "ranges", "ray", "euclidean", "radial", "depthperspective"}) ||
           has_word(name, {"depth_meters", "distance_to_camera"});
}

/// A unit of length as a word of a name.
struct UnitInName {
    double metres;
    const char* words;
};

std::optional<UnitInName> unit_in_name(const std::string& name) {
    constexpr std::pair<std::string_view, UnitInName> units[] = {
        {"mm", {0.001, "millimetres"}}, {"millimeters", {0.001, "millimetres"}},
        {"cm", {0.01, "centimetres"}},  {"centimeters", {0.01, "centimetres"}},
        {"meters", {1, "metres"}},      {"metres", {1, "metres"}}};
    for (const auto& [word, unit] : units)
        if (has_whole_word(name, {word})) return unit;
    return {};
}

bool holds_words(const StoredImage& picture) {
    return picture.values.empty() && picture.image.bytes_per_sample == 2 && picture.bits == 16;
}

/// The stated preset, an error if it is none for pictures; null: none is stated.
Result<const SourceDescription::Preset*> known_preset(const SourceDescription& known) {
    if (known.preset.empty()) return static_cast<const SourceDescription::Preset*>(nullptr);
    if (const SourceDescription::Preset* preset = preset_named(known.preset)) return preset;
    if (video_values_named(known.preset))
        return usage_error("preset " + known.preset + " is for depth videos, not for pictures",
                           {{Setting::preset}});
    return usage_error("preset " + known.preset + " is not known: must be one of " +
                           listed(all_presets(), &SourceDescription::Preset::name),
                       {{Setting::preset}});
}

/// What arrays beside depth in its own file say of the camera.
Result<void> add_own_arrays(const fs::path& file, ReadPictures& pictures, PicturesOfCamera& place) {
    TRY_ASSIGN(const auto stack, pictures.stack_in(file));
    if (!stack) return {};
    place.own = cameras_in_arrays(stack->small_arrays());
    std::error_code ignored;
    place.own_file = fs::weakly_canonical(file, ignored);
    for (const SmallArray& array : stack->small_arrays())
        if (has_word(array.name, {"extrinsic", "pose", "c2w", "w2c"}))
            place.own_not_used.push_back(array.name + " in " + file.filename().string());
    return {};
}

void know_own_camera(const Intrinsics& camera, const fs::path& file, PicturesOfCamera& place) {
    std::error_code ignored;
    place.own.cameras = {{.intrinsics = camera}};
    place.own_file = fs::weakly_canonical(file, ignored);
}

/// Makes a scene of depth as in one picture: its camera, unit, values and rate. What is not stated is
/// guessed, and each guess is a remark.
class SceneGuess {
public:
    /// `evident`: the preset if neither a person nor a file says how depth is stored.
    SceneGuess(const SourceDescription& known, const SourceDescription::Preset* preset,
               EvidentPreset evident = {})
        : known_(known), preset_(evident.preset ? evident.preset : preset), evident_(std::move(evident)) {}

    /// Describes depth as in this picture; `coding`, if any, is kept, whatever the values are.
    Result<void> describe(const fs::path& folder, const StoredImage& depth,
                          const DepthCoding* coding = nullptr) {
        scene_.width = depth.image.width;
        scene_.height = depth.image.height;
        scene_.metres_per_unit = 1;
        scene_.depth_bits = depth.values.empty() && depth.image.bytes_per_sample == 1 ? 8 : 16;
        scene_.depth.semantics = DepthSemantics::planar;
        scene_.depth.near_is_high = true;
        described_.unstated.filters = all_unstated;
        scene_.hole_stiffness = Scene::soft_holes;
        TRY(find_camera(folder));
        if (coding) {
            scene_.depth = *coding;
        } else {
            const EstimatedValues values = estimate_values(depth);
            if (stop_requested()) return interrupted_error();
            TRY(find_unit(values));
            scene_.stored.packed = is_unpacked(depth);
            doubt_unit(values);
            set_invalid(depth, values.has_negative_none);
            find_semantics(!depth.values.empty());
        }
        if (known_.semantics) scene_.depth.semantics = *known_.semantics;
        derive_valid_range(scene_.depth);
        const auto valid = validate(described_);
        if (valid) return {};
        if (known_ == SourceDescription())
            return error_at((beside_.camera    ? beside_.file
                             : inputs_.empty() ? folder
                                               : inputs_.back())
                                .string(),
                            valid.error());
        return usage_error(
            "with the camera and the unit that were said: " + valid.error().message,
            {{Setting::intrinsics}, {Setting::field_of_view}, {Setting::depth_unit}, {Setting::preset}});
    }

    /// Describes depth in files, of which `first` was read: its camera is sought in `place`, and `name` is
    /// evidence.
    Result<void> describe_files(const StoredImage& depth, ReadPictures& pictures, const fs::path& first,
                                const fs::path& name, PicturesOfCamera place) {
        const auto files = place.frames.empty() ? std::vector{first} : place.frames;
        if (files.size() == 1) TRY(add_own_arrays(files.front(), pictures, place));
        if (const auto camera = pictures.camera_in(files)) know_own_camera(*camera, first, place);
        place_ = std::move(place);
        are_points_ = is_named_cloud(first);
        if (!are_points_) know_name(name);
        if (const auto arrays = pictures.stack_in(first); arrays && *arrays) know_array((*arrays)->array());
        if (auto described = describe(place_.folder, depth); !described)
            return error_at((place_.is_whole_folder ? place_.folder : first).string(), described.error());
        tell_of_preset();
        tell_of_jpeg(depth);
        return {};
    }

    GuessedScene made() { return {std::move(described_), std::move(inputs_)}; }
    Scene& scene() { return scene_; }
    void say(std::string guess, std::string otherwise = {}, Hints hints = {},
             RemarkKind kind = RemarkKind::other) {
        add_remark(scene_.remarks, {std::move(guess), true, std::move(otherwise), std::move(hints), kind});
    }
    void say(std::string guess, Hints hints, RemarkKind kind = RemarkKind::other) {
        say(std::move(guess), {}, std::move(hints), kind);
    }
    /// Adds what a file or a person stated, with the settings that override it.
    void tell(std::string fact, std::string otherwise = {}, Hints hints = {}) {
        add_remark(scene_.remarks, {std::move(fact), false, std::move(otherwise), std::move(hints)});
    }
    /// Tells the channels of a rendering, which may have colour in depth's own files.
    void tell_of_layers(const BesideDepth& beside, bool takes_colour) {
        if (beside.depth_name.empty()) return;  // a cloud's
        std::string said = "depth is channel " + beside.depth_name;
        if (beside.depths > 1) said += ", the first of " + std::to_string(beside.depths) + " in a file";
        if (takes_colour)
            said += ", colour is " + (beside.colour_name.empty() ? "R, G, B" : beside.colour_name) +
                    " beside it, linear light shown as sRGB";
        say(std::move(said));
    }

    void know_cameras(const GuessedCameras& cameras) { frames_ = cameras; }
    void know_list(const std::string& file) { list_ = file; }
    /// Cameras that differ from frame to frame, as FolderSource::cameras.
    const std::string& frame_cameras() const { return beside_.frame_cameras; }
    bool takes_frame_cameras() const {
        return !beside_.frame_cameras.empty() && !known_.intrinsics && !known_.fov && !frames_;
    }
    /// Takes the rate of a colour video with as many frames as depth.
    void take_rate(const ColourVideo& video) {
        scene_.rate = video.file->rate();
        tell(short_number(scene_.rate.per_second()) + " frames a second, as " + printable(video.name) +
                 " has as many frames at that rate",
             "a scene file's rate says otherwise");
    }
    /// Takes the rate that a file beside depth states; false if none does.
    bool take_stated_rate() {
        constexpr double slowest = 0.01;
        if (beside_.frames_per_second < slowest) return false;
        scene_.rate = stated_rate(beside_.frames_per_second);
        add_input(beside_.rate_file);
        tell(short_number(scene_.rate.per_second()) + " frames a second, as " +
                 printable(beside_.rate_file.filename().string()) + " says",
             "a scene file's rate says otherwise");
        return true;
    }
    /// Sets the rate by the frames' times, a file beside them, or a colour video with as many frames.
    Result<void> find_rate(const fs::path& folder, std::int64_t frames,
                           const std::optional<ColourVideo>& video) {
        TRY_ASSIGN(const auto files, depth_files(folder, *scene_.folder));
        const auto rate = rate_of(files);
        if (!rate && take_stated_rate()) return {};
        if (!rate && video && video->file->count() == frames) {
            take_rate(*video);
            return {};
        }
        if (rate) scene_.rate = *rate;
        const std::string why = unusable_times(files);
        const std::string words =
            short_number(scene_.rate.per_second()) + " frames a second" +
            (scene_.rate.own_times ? " on average, each at its own time"
             : rate                ? (files.remark.empty() ? ", by their times" : ", the mean of their times")
             : why.empty()         ? ""
                                   : ", as " + why);
        add_remark(scene_.remarks, {words, !rate, "a scene file's rate says otherwise"});
        return {};
    }

    /// If files there say that colour does not lie on depth's pixels, takes colour's camera from them, or
    /// adds a remark that colour is nevertheless taken to lie there.
    void place_colour(const fs::path& folder, const fs::path& colour, ReadPictures& pictures) {
        const fs::path here = folder.empty() ? fs::path(".") : folder;
        const auto picture = pictures.look(colour);
        std::string why;
        if (const auto file = colour_movement_in(here)) {
            add_input(*file);
            if (picture && take_colour_camera(*file, (*picture)->image)) return;
            why = file->filename().string() + " says how its camera stands";
        } else if (picture && has_camera_of_depth_) {
            const auto other =
                camera_of_colour_in(here, scene_, (*picture)->image.width, (*picture)->image.height);
            if (!other) return;
            why = other->filename().string() + " is of another camera than depth's";
            add_input(*other);
        } else {
            return;
        }
        say("colour lies on depth's pixels, though " + why, "a scene file's colour_camera says otherwise", {},
            RemarkKind::colour_place);
    }

private:
    void tell_of_preset() {
        if (evident_.preset == nullptr) return;
        say("depth is as preset " + std::string(evident_.preset->name) + " has it (" + evident_.preset->what +
                "), as " + evident_.why,
            Hints{{Setting::preset}, {Setting::depth_unit}}, RemarkKind::storage);
    }

    /// Tells what a JPEG has lost, which cannot be restored.
    void tell_of_jpeg(const StoredImage& depth) {
        if (depth.codec != "mjpeg") return;
        const DepthCoding& coding = scene_.depth;
        const double middle = coding.depth(128), step = std::abs(coding.depth(129) - middle);
        tell("depth is a JPEG, and has lost what is finer than 256 levels (" + short_number(step, 2) +
             " m at " + short_number(middle, 2) + " m); JPEG moved pixels by some of these, most of all " +
             "beside edges. Where there is a PNG of 16 bits or an array of the same, take that");
    }

    /// Takes evidence from the pictures' name, or their folder's if theirs has no letters (disp/0001.png).
    void know_name(const fs::path& path) {
        const std::string own = path.stem().string();
        const bool has_letters =
            std::ranges::any_of(own, [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); });
        const std::string name = has_letters ? own : path.parent_path().filename().string();
        is_named_ = true;
        says_disparity_ = is_named_disparity(name);
        says_range_ = is_named_range(name);
        unit_in_name_ = unit_in_name(name);
    }
    /// Takes evidence from the name of depth's array, which says more than the file's.
    void know_array(const std::string& name) {
        says_disparity_ =
            is_named_disparity(name) || (says_disparity_ && small_letters(name).find("depth") == name.npos);
        says_range_ = says_range_ || is_named_range(name);
    }
    /// Counts a file as read for the scene; the pictures' own one is so in any case.
    void add_input(const fs::path& file) {
        if (file != place_.own_file && std::ranges::find(inputs_, file) == inputs_.end())
            inputs_.push_back(file);
    }
    bool preset_is_packed() const { return preset_ && preset_->stored.packed; }
    std::uint16_t largest_code() const { return scene_.depth_bits == 8 ? 255 : 65535; }
    /// A person's camera file, scaled as one that is found; an error if it is for other pictures.
    Result<Intrinsics> named_intrinsics() {
        if (known_.file.empty()) return *known_.intrinsics;
        std::string doubt;
        const Intrinsics camera = trusted_intrinsics(*known_.intrinsics, scene_.width, scene_.height, doubt);
        const std::string name = printable(known_.file.filename().string());
        const auto is_beside = [](const std::optional<double>& at, int side) {
            return at && (*at < -0.5 || *at > side - 0.5);
        };
        if (camera.width <= 0 && (is_beside(camera.cx, scene_.width) || is_beside(camera.cy, scene_.height)))
            return input_error(
                printable(known_.file.string()) + ": is of other pictures: its principal point, " +
                    short_number(camera.cx.value_or(0)) + ", " + short_number(camera.cy.value_or(0)) +
                    ", is not in these of " + std::to_string(scene_.width) + "x" +
                    std::to_string(scene_.height) + " pixels; must say the width and height that it is of",
                {{Setting::intrinsics}});
        if (!doubt.empty()) tell("the camera is that of " + name + ", " + doubt, {}, {{Setting::intrinsics}});
        return camera;
    }

    /// Takes depth's scale from a camera's file that a person named, if it states one.
    void take_scale_of(const fs::path& file) {
        const auto said = read_camera_text(file);
        if (!said) return;
        if (said->codes_per_metre > 0) {
            beside_.codes_per_metre = said->codes_per_metre;
            beside_.scale_file = file;
        }
        if (said->metres_per_value > 0) {
            beside_.metres_per_value = said->metres_per_value;
            beside_.unit_file = file;
        }
    }

    Result<void> find_camera(const fs::path& folder) {
        place_.folder = folder;
        place_.width = scene_.width;
        place_.height = scene_.height;
        beside_ = camera_beside(place_);
        if (known_.intrinsics && !known_.file.empty()) take_scale_of(known_.file);
        if (evident_.preset && beside_.codes_per_metre > 0 && !preset_is_packed()) {
            evident_ = {};
            preset_ = nullptr;
        }
        if (beside_.camera) {
            file_ = *beside_.camera;
            if (!known_.intrinsics && !known_.fov && !frames_) add_input(beside_.file);
        }
        has_camera_of_depth_ = known_.intrinsics || known_.fov || frames_ || beside_.camera;
        if (known_.intrinsics) {
            TRY_ASSIGN(const Intrinsics named, named_intrinsics());
            take(named, "the camera that was said");
            if (!known_.file.empty()) say_middle(named, printable(known_.file.filename().string()));
            const Camera& camera = scene_.camera;
            const auto is_far = [](double at, int side) { return at < -0.5 * side || at > 1.5 * side; };
            if (is_far(camera.cx, scene_.width) || is_far(camera.cy, scene_.height))
                tell("the principal point that was said, " + short_number(camera.cx) + ", " +
                     short_number(camera.cy) + ", is far beside the picture");
        } else if (known_.fov) {
            scene_.camera = camera_of_fov(*known_.fov, scene_.width, scene_.height);
        } else if (frames_) {
            scene_.camera = frames_->median;
            tell("the camera is that of " + frames_->files + (is_still(frames_->files) ? "" : ", the median"),
                 {}, {{Setting::intrinsics}});
        } else if (beside_.camera) {
            const std::string name = printable(beside_.file.filename().string());
            take(file_.intrinsics, name);
            say_middle(file_.intrinsics, name);
            std::error_code ignored;
            const fs::path here = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, ignored);
            fs::path from_here = beside_.file.lexically_relative(here);
            if (file_.frames > 1 && file_.is_of_files)
                from_here.replace_filename('*' + from_here.extension().string());
            std::string whose = "the camera is that of " + printable(from_here.string());
            if (!file_.name.empty()) whose += " (" + printable(file_.name, 60) + ')';
            if (file_.differs)
                whose += ", the median of those of " + std::to_string(file_.frames) + " frames, which differ";
            if (!beside_.doubt.empty()) whose += ", " + beside_.doubt;
            if (file_.has_distortion) whose += "; its lens's distortion is not undone";
            tell(whose + not_understood(), {}, {{Setting::intrinsics}});
            for (const std::string& guess : beside_.guesses)
                say(guess, Hints{{Setting::intrinsics}}, RemarkKind::camera);
        } else if (preset_ && preset_->intrinsics.fx > 0) {
            take(preset_->intrinsics, "the camera of preset " + std::string(preset_->name));
        } else {
            const double fov = preset_ && preset_->fov > 0 ? preset_->fov : usual_fov;
            scene_.camera = camera_of_fov(fov, scene_.width, scene_.height);
            say(guessed_field_of_view(fov) + not_understood(),
                Hints{{Setting::field_of_view}, {Setting::intrinsics}}, RemarkKind::camera);
        }
        tell_of_unused();
        return {};
    }

    /// Of a camera's file that states focal lengths alone. A field of view is that of a whole picture.
    void say_middle(const Intrinsics& camera, const std::string& file) {
        if (camera.fx == 0 || (camera.cx && camera.cy)) return;
        say("the principal point is the middle of the picture, " + short_number(scene_.camera.cx) + ", " +
                short_number(scene_.camera.cy) + ", as " + file + " states none",
            Hints{{Setting::intrinsics, "FX,FY,CX,CY"}});
    }

    void tell_of_unused() {
        constexpr std::size_t most = 6;
        const auto& names = beside_.not_used;
        if (names.empty()) return;
        std::string told = "beside the pictures, and not used: " +
                           printable(listed(std::span(names).first(std::min(most, names.size()))), 200);
        if (names.size() > most) told += " and " + std::to_string(names.size() - most) + " more";
        tell(std::move(told));
    }

    void take(const Intrinsics& intrinsics, const std::string& whose) {
        if (intrinsics.width > 0 && intrinsics.height > 0 &&
            (intrinsics.width != scene_.width || intrinsics.height != scene_.height))
            tell(whose + " is of " + std::to_string(intrinsics.width) + "x" +
                     std::to_string(intrinsics.height) + " pixels and is scaled to these pictures",
                 {}, {{Setting::intrinsics}});
        scene_.camera = scaled_camera(intrinsics, scene_.width, scene_.height);
    }

    /// Names files that look like a camera's and are not understood.
    std::string not_understood() const {
        const std::string names = listed(beside_.not_understood);
        return names.empty() ? "" : "; not understood as a camera's file: " + printable(names, 200);
    }

    /// Sets the unit: as stated, by preset, by names or files beside depth, or by the size of the values.
    Result<void> find_unit(const EstimatedValues& values) {
        if (!values.any)
            return input_error(
                values.has_background
                    ? "has no depth: all values are 0 or a renderer's background (1e9 and beyond, 65504)"
                    : "has no depth: all values are 0 or 65535, or none is finite");
        if (known_.metres_per_code) {
            set_metric(*known_.metres_per_code);
            return {};
        }
        if (!preset_ && says_disparity_ && beside_.codes_per_metre == 0) {
            const std::string guess = "depth is disparities, as the name says";
            if (file_.baseline > 0) {
                preset_ = preset_named("middlebury");
                say(guess + "; baseline and focal length are those of " +
                        printable(beside_.file.filename().string()),
                    Hints{{Setting::preset}, {Setting::depth_unit}}, RemarkKind::storage);
            } else {
                say(guess + ", and no calib.txt beside it has their baseline",
                    "with a calib.txt that has it they have a scale",
                    {{Setting::preset, "middlebury"}, {Setting::depth_unit}}, RemarkKind::storage);
                set_relative(true, true);
                scene_.depth.invalid_code_count = 1;  // 0 is infinitely far
                return {};
            }
        }
        if (preset_ && preset_->stored.kind == StoredDepth::Kind::disparity) {
            scene_.stored = preset_->stored;
            if (scene_.stored.baseline == 0) {
                if (file_.baseline == 0)
                    return input_error("preset " + std::string(preset_->name) +
                                           " needs the calib.txt of the pictures beside them",
                                       {{Setting::preset}});
                scene_.stored.baseline = file_.baseline;
                scene_.stored.offset = file_.offset * scene_.camera.fx / file_.intrinsics.fx;
                add_input(beside_.file);
            } else if (preset_->intrinsics.fx > 0) {  // baseline x fx is what is known
                scene_.stored.baseline *= preset_->intrinsics.fx / scene_.camera.fx;
            }
            scene_.depth.kind = DepthCodingKind::inverse;
            scene_.depth.code_max = largest_code();
            scene_.depth.near = scene_.camera.fx * scene_.stored.baseline / 65536;
            scene_.depth.far = scene_.camera.fx * scene_.stored.baseline;
            return {};
        }
        if (preset_ && preset_->stored.kind == StoredDepth::Kind::relative) {
            set_relative(true, true);
            return {};
        }
        if (preset_ && preset_->metres_per_code > 0) {
            scene_.stored = preset_->stored;
            set_metric(preset_->metres_per_code);
            return {};
        }
        // Numbers of 8 bits are hardly ever lengths.
        if (const double codes = beside_.codes_per_metre; codes > 0 && !values.is_float && values.bits > 8) {
            take_unit(1 / codes, "a code is " + short_number(1000 / codes) + " mm", beside_.scale_file);
            return {};
        }
        // Integers are no metres.
        if (unit_in_name_ && values.bits > 8 && (values.is_float || unit_in_name_->metres < 1)) {
            take_unit(unit_in_name_->metres, std::string("values are ") + unit_in_name_->words, {});
            return {};
        }
        if (const double metres = beside_.metres_per_value; metres > 0 && values.is_float) {
            take_unit(metres, "a value of 1 is " + short_number(1000 * metres) + " mm", beside_.unit_file);
            return {};
        }
        guess_unit(values);
        is_unit_guessed_ = true;
        return {};
    }

    /// Takes the unit that a file states, or depth's name if that is empty.
    void take_unit(double metres, std::string fact, const fs::path& file) {
        set_metric(metres);
        if (!file.empty()) add_input(file);
        tell(std::move(fact) + ", as " + (file.empty() ? "the name" : printable(file.filename().string())) +
                 " says",
             {}, {{Setting::depth_unit}});
    }

    /// Decides whether lengths go along each pixel's ray, as the name may say, or along the camera's axis, as
    /// depth cameras record them. Floats in files may be either, as a renderer or a laser has them.
    void find_semantics(bool is_float) {
        if (known_.semantics || scene_.depth.kind != DepthCodingKind::metric) return;
        if (says_range_) {
            scene_.depth.semantics = DepthSemantics::range;
            say("depth goes along each pixel's ray, as the name says", Hints{{Setting::depth_kind, "planar"}},
                RemarkKind::axis);
            return;
        }
        if (!is_named_ || preset_ != nullptr || (!is_float && (!is_unit_guessed_ || has_camera_of_depth_)))
            return;
        const double nearer = 100 * (1 - 1 / scene_.camera.longest_ray(scene_.width, scene_.height));
        constexpr double least_felt = 5;  // per cent
        if (nearer < least_felt) return;
        say("depth goes along the camera's axis (planar); if it goes along each pixel's ray, the corners "
            "are " +
                short_number(nearer, 2) + " % nearer",
            Hints{{Setting::depth_kind, "range"}}, RemarkKind::axis);
    }

    void set_metric(double metres_per_code) {
        DepthCoding& depth = scene_.depth;
        depth.kind = DepthCodingKind::metric;
        depth.scale = metres_per_code;
        depth.code_max = largest_code();
        depth.far = depth.scale * depth.code_max;
        described_.unstated.far = true;
    }

    void set_relative(bool near_is_high, bool is_inverse) {
        DepthCoding& depth = scene_.depth;
        scene_.stored.kind = StoredDepth::Kind::relative;
        depth.kind = is_inverse ? DepthCodingKind::inverse : DepthCodingKind::linear;
        depth.near_is_high = near_is_high;
        depth.near = assumed_near;
        depth.far = assumed_far;
        depth.code_max = largest_code();
        say("depth has no scale: its nearest is taken for " + short_number(assumed_near) +
                " m and its farthest for " + short_number(assumed_far) + " m, " +
                (near_is_high ? "large" : "small") + " values near",
            "a scene file says otherwise, touchable init-scene writes one to begin with; where values are "
            "lengths, their unit",
            {{Setting::depth_unit}}, RemarkKind::scale);
    }

    void guess_unit(const EstimatedValues& values) {
        const Hints otherwise{{Setting::depth_unit}};
        const bool is_signed = values.negative > 0.01;
        if (values.is_of_bytes())
            say("values are 8 bits stored as 16, as all are multiples of " + std::to_string(values.divisor),
                otherwise, RemarkKind::unit);
        if (values.bits == 8 || values.is_of_bytes() || values.is_normalised || is_signed) {
            // Values that are larger for near pixels are 1/depth, as most networks guess it; others are
            // depth.
            const bool near_is_high = is_signed || values.lower >= values.upper;
            set_relative(near_is_high, near_is_high);
        } else if (values.is_float) {
            constexpr double most_metres = 30, least_millimetres = 600;
            const bool metres = values.median < most_metres;
            const bool may_be_centimetres = !metres && values.median < least_millimetres;
            set_metric(metres ? 1 : 0.001);
            say(std::string("values are ") + (metres ? "metres" : "millimetres") +
                    median_in_words(values, metres ? 1 : 0.001),
                may_be_centimetres ? short_number(0.01 * values.median, 3) + " m if they are centimetres"
                                   : "",
                may_be_centimetres ? Hints{{Setting::depth_unit, "0.01"}} : otherwise,
                may_be_centimetres ? RemarkKind::unclear_unit : RemarkKind::unit);
            // The lower part of a picture is mostly nearer.
            if (values.lower > most_of_lengths * values.upper && !are_points_)
                say("values are lengths, though they are larger in the lower third of the picture, as "
                    "1/depth of networks is",
                    Hints{{Setting::preset, "relative-inverse"}}, RemarkKind::direction);
        } else if (!list_.empty() || !guess_unit_of_multiples(values)) {
            const bool fine = values.median > 12000, coarse = values.median < 100;
            const double unit = fine || !list_.empty() ? 1.0 / 5000 : coarse ? 0.01 : 0.001;
            set_metric(unit);
            say_unit(values, unit);
        }
    }

    static std::string median_in_words(const EstimatedValues& values, double unit) {
        return ": their median, " + short_number(values.median) + ", would be " +
               short_number(values.median * unit, 3) + " m";
    }

    /// Tells the guessed unit of 16-bit values and others that fit, with the scene's size in each.
    void say_unit(const EstimatedValues& values, double unit) {
        const std::string millimetres = short_number(1000 * unit) + " mm";
        if (!list_.empty()) {
            say("a code is " + millimetres + ", as recordings with a " + list_ + " have it (TUM RGB-D)",
                Hints{{Setting::depth_unit}}, RemarkKind::unit);
            return;
        }
        constexpr double near_for_a_camera = 1000, far_for_a_room = 3000;  // of a median, millimetres
        constexpr double most_of_lidar = 0.5, least_sky = 0.01;            // shares of the pixels
        struct Reading {
            bool is_possible;
            const char* unit;
            const char* when;
        };
        const bool is_millimetre = unit == 0.001;
        const Reading readings[] = {
            {is_millimetre && values.largest > least_sky && values.zeros == 0, "0.01",
             "if they are centimetres and 65535 is the sky (Virtual KITTI)"},
            {is_millimetre && (values.median < near_for_a_camera || values.median > far_for_a_room ||
                               values.zeros > most_of_lidar),
             "0.00390625", "if 256 codes are a metre (KITTI, VOID, ZoeDepth)"},
            {is_millimetre && values.median < near_for_a_camera, "0.001953125",
             "if 512 codes are a metre (Taskonomy)"},
            {is_millimetre && values.median > far_for_a_room, "0.00025",
             "if 4000 codes are a metre (Matterport3D)"},
            {is_millimetre && values.median > far_for_a_room, "0.0002", "if 5000 codes are a metre (TUM)"},
            {!is_millimetre, "0.001", "if they are millimetres"},
            {unit < 0.001 || (is_millimetre && values.median > far_for_a_room), "0.0001",
             "if they are tenths of a millimetre"}};
        const auto size = [&](double metres) { return short_number(values.median * metres, 3) + " m"; };
        std::string others;
        Hints hints;
        for (const auto& [is_possible, other, when] : readings) {
            if (!is_possible) continue;
            others += (others.empty() ? "" : "; ") + size(*parsed_number(other)) + ' ' + when;
            // The preset knows that the sky is no depth.
            if (std::string_view(other) == "0.01")
                hints.push_back({Setting::preset, "vkitti"});
            else
                hints.push_back({Setting::depth_unit, other});
        }
        if (unit < 0.001) {
            const double below = 0.001 * (static_cast<int>(values.median) & 0x1fff);
            others += "; " + short_number(below, 3) + " m if the 3 highest bits are a confidence (DEPTH16)";
            hints.push_back({Setting::preset, "depth16"});
        }
        if (hints.empty()) hints = {{Setting::depth_unit}};
        const RemarkKind kind = others.empty() ? RemarkKind::unit : RemarkKind::unclear_unit;
        say("depth codes are " + (is_millimetre ? "millimetres" : millimetres) +
                median_in_words(values, unit),
            std::move(others), std::move(hints), kind);
    }

    /// Guesses the unit by the values' divisor: cameras measure whole millimetres, and files may have these
    /// times 5, 10 or 100. False if that does not settle it.
    bool guess_unit_of_multiples(const EstimatedValues& values) {
        constexpr double nearest = 250, deepest = 12'000;  // millimetres, of a median
        const int divisor = values.divisor;
        if (divisor == 1 || values.is_of_bytes()) return false;
        const std::string multiples = "all values are multiples of " + std::to_string(divisor);
        const double median = values.median / divisor;
        const bool is_usual = divisor == 5 || divisor == 10 || divisor == 100;
        if (!is_usual || median < nearest || median > deepest) {
            say(multiples + ", which tells nothing of their unit", Hints{{Setting::depth_unit}});
            return false;
        }
        set_metric(0.001 / divisor);
        say("a code is " + short_number(1.0 / divisor) + " mm, as " + multiples +
                " and their median is then " + short_number(median) + " mm",
            Hints{{Setting::depth_unit, values.median <= deepest ? "0.001" : ""}}, RemarkKind::unit);
        return true;
    }

    /// Adds a remark if the unit is doubtful, with one by which the values are in a hand's reach, if any.
    void doubt_unit(const EstimatedValues& values) {
        if (scene_.depth.kind != DepthCodingKind::metric || !scene_.stored.is_plain()) return;
        std::string otherwise = "a unit is the metres that a stored 1 stands for, such as 0.001";
        Hint hint{Setting::depth_unit};
        constexpr std::pair<const char*, const char*> usual[] = {
            {"0.0001", "tenths of a millimetre"}, {"1", "metres"}, {"0.001", "millimetres"}};
        for (const auto& [unit, name] : usual) {
            const double median = values.median * *parsed_number(unit);
            if (median < 0.1 || median > 10) continue;
            otherwise = short_number(median) + " m if values are " + name;
            hint.value = unit;
        }
        if (auto doubt =
                unit_doubt(values.median * scene_.depth.scale, std::move(otherwise), {std::move(hint)}))
            add_remark(scene_.remarks, std::move(*doubt));
    }

    /// Sets the codes that are no depth: cameras write 0. Depth without a scale has none.
    void set_invalid(const StoredImage& depth, bool has_negative_none) {
        if (scene_.stored.kind == StoredDepth::Kind::relative) return;
        const bool is_told = preset_ != nullptr || known_.metres_per_code.has_value();
        const int other = preset_ ? preset_->invalid : holds_words(depth) && !is_told ? 65535 : 0;
        DepthCoding& coding = scene_.depth;
        const int above = is_told ? 0 : none_above_all(depth).value_or(0);
        for (const int code : {0, other, above})
            if (coding.invalid_code_count == 0 || (code > 0 && code <= coding.code_max))
                coding.invalid_codes[static_cast<std::size_t>(coding.invalid_code_count++)] =
                    static_cast<std::uint16_t>(code);
        if (above > 0)
            say(std::to_string(above) + " is no depth, as many pixels have it and no other comes near it");
        if (!is_told)
            say(other > 0           ? "0 and 65535 are no depth"
                : has_negative_none ? "0 and what is below it are no depth"
                                    : "0 is no depth");
    }

    /// Takes colour's camera from ViSP's files, which are in metres; false if there is none, or depth is not.
    bool take_colour_camera(const fs::path& movement, const Image& colour) {
        if (scene_.stored.kind == StoredDepth::Kind::relative) return false;
        const auto found = visp_colour_camera(movement, beside_.file, colour.width, colour.height);
        if (!found) return false;
        scene_.colour_camera = found->camera;
        if (!validate(described_)) {
            scene_.colour_camera.reset();
            return false;
        }
        add_input(found->file);
        const bool is_unit_told = preset_ != nullptr || known_.metres_per_code.has_value();
        add_remark(scene_.remarks,
                   {"colour is brought onto depth's pixels, as " + printable(movement.filename().string()) +
                        " and " + printable(found->file.filename().string()) + " say" +
                        (is_unit_told ? "" : ", by the unit that is guessed"),
                    !is_unit_told, "a scene file's colour_camera says otherwise",
                    is_unit_told ? Hints{} : Hints{{Setting::depth_unit, ""}}});
        return true;
    }

    const SourceDescription& known_;
    const SourceDescription::Preset* preset_;
    EvidentPreset evident_;
    SceneDescription described_;
    Scene& scene_ = described_.scene;
    std::vector<fs::path> inputs_;
    PicturesOfCamera place_;
    CameraBeside beside_;
    CameraFile file_;                       // beside_'s camera, if any
    std::optional<GuessedCameras> frames_;  // cameras of frames that have one each
    bool is_named_ = false, says_disparity_ = false, says_range_ = false;  // the pictures' names
    std::optional<UnitInName> unit_in_name_;
    bool is_unit_guessed_ = false;
    std::string list_;                  // of pictures and their times; empty: there is none
    bool has_camera_of_depth_ = false;  // stated, or read
    bool are_points_ = false;           // of a cloud
};

/// The pattern if each frame's camera can be read by it; otherwise empty.
std::string usable_cameras(const fs::path& folder, FolderSource source, const std::string& pattern,
                           const Scene& scene) {
    source.cameras = pattern;
    const auto depth = depth_files(folder, source);
    const auto files = depth ? camera_files(folder, source, *depth) : depth;
    const bool is_usable = files && read_frame_cameras(*files, scene.width, scene.height);
    return is_usable ? pattern : "";
}

/// For a person: "1861 km", "0.5 m", "0.2 mm".
std::string length_in_words(double metres) {
    if (metres >= 10'000) return short_number(metres / 1000) + " km";
    return metres < 0.1 ? short_number(metres * 1000) + " mm" : short_number(metres) + " m";
}

}  // namespace

Result<GuessedScene> guess_folder(const fs::path& folder, const SourceDescription& known) {
    TRY_ASSIGN(const auto preset, known_preset(known));
    if (const auto foreign = foreign_folder(folder)) return input_error(folder.string() + ": " + *foreign);
    const auto pictures = std::make_shared<ReadPictures>(known);
    const bool is_relative = preset != nullptr && preset->stored.kind == StoredDepth::Kind::relative;
    TRY_ASSIGN(const auto chosen, choose_pictures(folder, known, is_relative, *pictures));
    const PictureGroup& depth = chosen.depth;
    const std::optional<PictureGroup>& colour = chosen.colour;
    FolderSource all;
    all.depth = depth.pattern;
    const auto files = depth_files(folder, all);
    TRY_ASSIGN(const auto told,
               telling_depth(files ? files->files : std::vector{depth.first}, *pictures, preset));
    const StoredImage& stored = *told;
    std::optional<GuessedCameras> cameras;
    if (!known.intrinsics && !known.fov) {
        TRY_ASSIGN(cameras, guess_cameras(folder, depth.pattern, stored.image.width, stored.image.height));
    }
    EvidentPreset evident;
    if (preset == nullptr && !known.metres_per_code)
        evident = cameras && holds_words(stored)
                      ? EvidentPreset{preset_named("arkitscenes"), "each frame has a .pincam file"}
                      : evident_in(stored);
    SceneGuess guess(known, preset, std::move(evident));
    if (cameras) guess.know_cameras(*cameras);
    if (is_list(depth.pattern)) guess.know_list(depth.pattern);
    PicturesOfCamera place{.folder = folder, .within = folder_of(depth), .is_whole_folder = true};
    if (files) place.frames = files->files;
    TRY(guess.describe_files(stored, *pictures, depth.first, fs::weakly_canonical(folder) / depth.pattern,
                             std::move(place)));
    Scene& scene = guess.scene();
    scene.name = fs::weakly_canonical(folder).filename().string();
    scene.folder.emplace();
    scene.folder->depth = depth.pattern;
    if (cameras && !is_still(cameras->files) && scene.stored.kind != StoredDepth::Kind::disparity)
        scene.folder->cameras = cameras->files;
    if (guess.takes_frame_cameras() && scene.stored.kind != StoredDepth::Kind::disparity)
        scene.folder->cameras = usable_cameras(folder, *scene.folder, guess.frame_cameras(), scene);
    const BesideDepth* const beside = stored.beside.get();
    TRY_ASSIGN(const auto stack, depth.count == 1 ? pictures->stack_in(depth.first)
                                                  : Result<std::shared_ptr<ImageStack>>(nullptr));
    const std::int64_t frames = stack   ? stack->count()
                                : files ? static_cast<std::int64_t>(files->count())
                                        : static_cast<std::int64_t>(depth.count);
    const auto video = !colour && frames > 1 ? colour_video_in(folder, frames) : std::nullopt;
    if (stop_requested()) return interrupted_error();
    const bool has_own_colour = !colour && !video && beside != nullptr && beside->colour;
    if (colour) scene.folder->colour = colour->pattern;
    if (video) scene.folder->colour = video->name;
    if (has_own_colour) scene.folder->colour = depth.pattern;
    scene.folder->haptic = chosen.haptic;
    for (const std::string& remark : unusable_lists(folder)) guess.say(remark);
    guess.say("depth is " + depth.pattern +
              (colour           ? ", colour is " + colour->pattern
               : video          ? ", colour is " + printable(video->name)
               : has_own_colour ? ", colour is in the same files"
                                : ", there is no colour"));
    if (!chosen.unfetched.empty())
        guess.tell("left out: " + printable(chosen.unfetched) + ", whose first " + git_lfs_words);
    if (const auto arrays = camera_arrays(folder); !arrays.empty())
        guess.tell("arrays beside the pictures, and not used: " +
                       printable(listed(arrays, &PictureGroup::pattern), 200),
                   "their numbers can be said", {{Setting::intrinsics, "FX,FY,CX,CY"}});
    if (beside != nullptr) guess.tell_of_layers(*beside, has_own_colour);
    if (!chosen.left_out_by_path.empty())
        guess.say("left out: " + printable(listed(chosen.left_out_by_path), 200),
                  "name one of these to open it");
    if (!chosen.left_out_by_pattern.empty())
        guess.say("left out: " + printable(listed(chosen.left_out_by_pattern), 200),
                  "a scene file's folder.depth names one of these to open it");
    if (colour) guess.place_colour(folder, colour->first, *pictures);
    if (video && !video->others.empty())
        guess.say("left out: " + printable(listed(video->others), 200) + ", which may be colour as well",
                  "a scene file's folder.colour names another one");
    if (depth.count > 1 || video) TRY(guess.find_rate(folder, frames, video));
    GuessedScene made = guess.made();
    pictures->keep_only({depth.first, colour ? colour->first : fs::path()});
    made.pictures = pictures;
    if (video) made.video = video->file;
    return made;
}

Result<GuessedScene> guess_scene(const fs::path& file, const StoredImage& depth,
                                 const SourceDescription& known, const DepthCoding* coding) {
    const auto preset = known_preset(known);
    if (!preset) return error_at(file.string(), preset.error());
    SceneGuess guess(known, *preset);
    if (auto described = guess.describe(file.parent_path(), depth, coding); !described)
        return error_at(file.string(), described.error());
    guess.scene().name = file.stem().string();
    return guess.made();
}

Result<SceneDescription> guess_camera(const StoredImage& first, const SourceDescription& known,
                                      std::vector<fs::path>& inputs) {
    TRY_ASSIGN(const auto preset, known_preset(known));
    SceneGuess guess(known, preset);
    TRY(guess.describe("/dev", first));  // has no camera's file
    GuessedScene guessed = guess.made();
    inputs = std::move(guessed.inputs);
    return SceneDescription(std::move(guessed));
}

Result<GuessedScene> guess_picture(const SourceFile& source, const SourceDescription& known) {
    const fs::path& file = source.path();
    TRY_ASSIGN(const auto preset, known_preset(known));
    const std::string name = file.filename().string();
    const auto pictures = std::make_shared<ReadPictures>(known, source);
    TRY_ASSIGN(const auto told, telling_depth({file}, *pictures, preset));
    const StoredImage& stored = *told;
    const bool is_open = preset == nullptr && !known.metres_per_code;
    const auto metadata = realsense_metadata_of(file);
    const bool is_of_viewer = is_open && metadata;
    SceneGuess guess(known, is_of_viewer ? preset_named("realsense") : preset,
                     is_open && !metadata ? evident_in(stored) : EvidentPreset());
    if (is_of_viewer)
        guess.tell("a code is 1 mm, as the RealSense Viewer writes it", {}, {{Setting::depth_unit}});
    PicturesOfCamera place{.folder = file.parent_path(), .within = {}, .stem = file.stem().string()};
    if (metadata) {
        TRY_ASSIGN(const auto camera, read_realsense_metadata(*metadata));
        know_own_camera(camera, *metadata, place);
    }
    TRY(guess.describe_files(stored, *pictures, file, fs::weakly_canonical(file), std::move(place)));
    guess.scene().name = file.stem().string();
    FolderSource& folder = guess.scene().folder.emplace();
    folder.depth = name;
    if (const auto colour = colour_beside(file, *pictures)) {
        folder.colour = colour->filename().string();
        guess.say("colour is " + folder.colour);
        guess.place_colour(file.parent_path(), *colour, *pictures);
    } else if (stored.beside && stored.beside->colour) {
        folder.colour = name;
    }
    if (stored.beside) guess.tell_of_layers(*stored.beside, folder.colour == name);
    TRY_ASSIGN(const auto stack, pictures->stack_in(file));
    std::optional<ColourVideo> video;
    if (stack && stack->count() > 1 && folder.colour.empty()) video = colour_video_beside(file);
    if (video) {
        folder.colour = video->name;
        guess.say("colour is " + printable(video->name));
        if (video->file->count() == stack->count()) guess.take_rate(*video);
    } else if (stack && stack->count() > 1) {
        guess.take_stated_rate();
    }
    GuessedScene made = guess.made();
    if (metadata) made.inputs.push_back(*metadata);
    made.pictures = pictures;
    if (video) made.video = video->file;
    return made;
}

std::optional<Remark> unit_doubt(double median_m, std::string otherwise, Hints hints) {
    // From an endoscope's depths to a lidar's. A unit wrong by a thousand moves a hand's reach out of this.
    constexpr double nearest = 0.01, farthest = 300;  // metres
    if (median_m >= nearest && median_m <= farthest) return std::nullopt;
    return Remark{"the median depth is " + length_in_words(median_m) + ": the unit may be wrong", false,
                  std::move(otherwise), std::move(hints), RemarkKind::unit_doubt};
}

}  // namespace touchable
