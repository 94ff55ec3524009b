// SPDX-License-Identifier: Apache-2.0
// Guesses the scene of depth pictures without a scene file. Stated values (SourceDescription) are kept; the
// rest comes from files beside the pictures and from their names (DepthEvidence), and from their values
// (guess_values). Each guess is a remark of the scene (SceneDraft).

#include <cmath>
#include <iterator>
#include <numeric>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/colour_video.hpp"
#include "engine/formats/organised_cloud.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/formats/scene_draft.hpp"
#include "engine/formats/sidecar_text.hpp"
#include "engine/picture/image.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

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

bool is_named_disparity(const std::string& name) {
    return has_beginning(name, {"disp ", "disparity ", "disparities "}) ||
           has_word(name, {"inverse_depth", "inv_depth", "invdepth", "inversedepth"});
}

/// Whether a name says distances from the camera's centre, as Hypersim's depth_meters and Replicator's
/// distance_to_camera are.
bool is_named_range(const std::string& name) {
    return has_beginning(name, {"range ", "ranges ", "ray ", "euclidean ", "radial ", "depthperspective "}) ||
           has_word(name, {"depth_meters", "distance_to_camera"});
}

/// Whether a name says heights: not its folder's, which may tell what depth is of, and not "height", which is
/// also this program's plane of roughness.
bool is_named_heights(const std::string& name) {
    return has_beginning(name,
                         {"dem ", "dsm ", "dtm ", "heightmap", "terrain ", "elevation", "displacement"}) &&
           !has_word(name, {"depth"});
}

std::optional<UnitInName> unit_in_name(const std::string& name) {
    constexpr std::pair<std::string_view, UnitInName> units[] = {
        {"mm ", {0.001, "millimetres"}}, {"millimeters ", {0.001, "millimetres"}},
        {"cm ", {0.01, "centimetres"}},  {"centimeters ", {0.01, "centimetres"}},
        {"meters ", {1, "metres"}},      {"metres ", {1, "metres"}}};
    for (const auto& [word, unit] : units)
        if (has_beginning(name, {word})) return unit;
    return {};
}

/// The stated preset, an error if it is none for pictures; null: none is stated.
Result<const SourceDescription::Preset*> known_preset(const SourceDescription& known) {
    const SourceDescription::Preset* const preset = preset_named(known.preset);
    if (preset || known.preset.empty()) return preset;
    const std::string why =
        video_values_named(known.preset)
            ? "for depth videos, not for pictures"
            : "not known: must be one of " + listed(all_presets(), &SourceDescription::Preset::name);
    return usage_error("preset " + known.preset + " is " + why, {{Setting::preset}});
}

void set_own_camera(CameraText said, const fs::path& file, PicturesOfCamera& place) {
    std::error_code ignored;
    place.own = std::move(said);
    place.own_file = fs::weakly_canonical(file, ignored);
}

/// What arrays beside depth in its own file say of the camera.
Result<void> add_own_arrays(const fs::path& file, ReadPictures& pictures, PicturesOfCamera& place) {
    TRY_ASSIGN(const auto stack, pictures.stack_in(file));
    if (!stack) return {};
    set_own_camera(cameras_in_arrays(stack->small_arrays(), stack->count()), file, place);
    for (const SmallArray& array : stack->small_arrays())
        if (has_word(array.name, {"extrinsic", "pose", "c2w", "w2c"}))
            place.own_not_used.push_back(array.name + " in " + file.filename().string());
    return {};
}

// --- The camera

/// A person's camera file, scaled as one that is found; an error if it is for other pictures.
Result<Intrinsics> named_intrinsics(const SourceDescription& known, SceneDraft& draft) {
    const int width = draft.scene.width, height = draft.scene.height;
    std::string doubt;
    const Intrinsics camera =
        (known.file.empty() ? in_pixels : trusted_intrinsics)(*known.intrinsics, width, height, doubt);
    const auto is_beside = [](const std::optional<double>& at, int side) {
        return at && (*at < -0.5 || *at > side - 0.5);
    };
    if (!known.file.empty() && camera.width <= 0 &&
        (is_beside(camera.cx, width) || is_beside(camera.cy, height)))
        return input_error(printable(known.file.string()) + ": is of other pictures: its principal point, " +
                               short_number(camera.cx.value_or(0)) + ", " +
                               short_number(camera.cy.value_or(0)) + ", is not in these of " +
                               size_text(width, height) +
                               " pixels; must say the width and height that it is of",
                           {{Setting::intrinsics}});
    if (!doubt.empty())
        draft.tell("the camera is " +
                       (known.file.empty() ? std::string("the one that was said")
                                           : "that of " + printable(known.file.filename().string())) +
                       ", " + doubt,
                   {{Setting::intrinsics}});
    return camera;
}

/// Takes depth's scale from a camera's file that a person named, if it states one.
void take_scale_of(const fs::path& file, CameraBeside& beside) {
    const auto said = read_camera_text(file);
    if (!said) return;
    if (said->codes_per_metre > 0) beside.codes_per_metre = {said->codes_per_metre, file};
    if (said->metres_per_value > 0) beside.metres_per_value = {said->metres_per_value, file};
}

/// Sets the camera. `file`: the camera's file, which may state focal lengths alone; empty: there is none.
void take_camera(const Intrinsics& intrinsics, const std::string& whose, const std::string& file,
                 SceneDraft& draft) {
    Scene& scene = draft.scene;
    if (intrinsics.width > 0 && intrinsics.height > 0 &&
        (intrinsics.width != scene.width || intrinsics.height != scene.height))
        draft.tell(whose + " is of " + size_text(intrinsics.width, intrinsics.height) +
                       " pixels and is scaled to these pictures",
                   {{Setting::intrinsics}});
    scene.camera = scaled_camera(intrinsics, scene.width, scene.height);
    if (intrinsics.is_fov_either_way && scene.width != scene.height) {
        const std::string other = short_number(
            360 / pi * arctangent(0.5 * scene.width * scene.width / (scene.height * scene.camera.fx)));
        draft.say("the camera sees " + short_number(intrinsics.fov_x) + " degrees from left to right, as " +
                      whose + " gives one angle; if that goes from top to bottom, it sees " + other,
                  {{Setting::field_of_view, other}}, RemarkKind::camera);
    }
    // A field of view is that of a whole picture.
    if (file.empty() || intrinsics.fx == 0 || (intrinsics.cx && intrinsics.cy)) return;
    draft.say("the principal point is the middle of the picture, " + short_number(scene.camera.cx) + ", " +
                  short_number(scene.camera.cy) + ", as " + file + " states none",
              {{Setting::intrinsics, "FX,FY,CX,CY"}});
}

/// Names files that look like a camera's and are not understood.
std::string not_understood_words(const CameraBeside& beside) {
    const std::string names = listed(beside.not_understood);
    return names.empty() ? "" : "; not understood as a camera's file: " + printable(names, 200);
}

/// Takes the camera of a file beside the pictures.
void take_camera_beside(const CameraBeside& beside, const fs::path& folder, SceneDraft& draft) {
    const CameraFile& camera = *beside.camera;
    const std::string name = printable(beside.file.filename().string());
    take_camera(camera.intrinsics, name, name, draft);
    std::error_code ignored;
    const fs::path here = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, ignored);
    fs::path from_here = beside.file.lexically_relative(here);
    if (camera.frames > 1 && camera.is_of_files)
        from_here.replace_filename('*' + from_here.extension().string());
    std::string whose = "the camera is that of " + printable(from_here.string());
    if (!camera.name.empty()) whose += " (" + printable(camera.name, 60) + ')';
    if (camera.differs)
        whose += ", the median of those of " + std::to_string(camera.frames) + " frames, which differ";
    if (!beside.doubt.empty()) whose += ", " + beside.doubt;
    if (camera.has_distortion) whose += "; its lens's distortion is not undone";
    draft.tell(whose + not_understood_words(beside), {{Setting::intrinsics}});
    for (const std::string& guess : beside.guesses)
        draft.say(guess, {{Setting::intrinsics}}, RemarkKind::camera);
}

void tell_of_unused(const std::vector<std::string>& names, SceneDraft& draft) {
    constexpr std::size_t most = 6;
    if (names.empty()) return;
    std::string told = "beside the pictures, and not used: " +
                       printable(listed(std::span(names).first(std::min(most, names.size()))), 200);
    if (names.size() > most) told += " and " + std::to_string(names.size() - most) + " more";
    draft.tell(std::move(told));
}

/// Refuses what no pinhole camera sees. A remark says it instead if a person states the camera of a view, or
/// if depth's values alone show it.
Result<void> check_projection(const StoredImage& stored, const fs::path& depth, const fs::path& colour,
                              const ReadPictures& pictures, const DepthEvidence& evidence,
                              SceneDraft& draft) {
    const bool has_xmp = pictures.has_panorama(depth) || pictures.has_panorama(colour);
    const auto found = projection_of(stored, depth, colour, has_xmp, evidence.beside.camera.has_value());
    if (!found) return {};
    const std::string may_be = "the picture may be " + found->name;
    if (pictures.known().intrinsics || pictures.known().fov) {
        draft.tell(may_be + ", and is taken for that of the camera that was said");
    } else if (found->evidence.empty()) {
        std::erase_if(draft.scene.remarks, [](const Remark& each) {
            return each.kind == RemarkKind::camera || each.kind == RemarkKind::direction;
        });
        draft.say("the camera is a pinhole, though " + may_be +
                      ", as its first and last row have one depth each and its sides meet",
                  {{Setting::field_of_view}}, RemarkKind::camera, found->way + "; of a pinhole");
    } else {
        return input_error(
            depth.string() + ": is " + found->name + " (" + found->evidence +
                "; if it is none, say its camera), which no pinhole camera sees: " + found->way,
            found->hints);
    }
    return {};
}

/// Sets the camera: as stated, from a file, by preset, or 60 degrees wide.
Result<void> find_scene_camera(const DepthEvidence& evidence, const fs::path& folder, SceneDraft& draft) {
    const SourceDescription& known = evidence.known;
    const CameraBeside& beside = evidence.beside;
    const auto* const preset = evidence.preset;
    Scene& scene = draft.scene;
    if (beside.camera && !evidence.has_stated_camera()) draft.add_input(beside.file);
    if (known.intrinsics) {
        TRY_ASSIGN(const Intrinsics named, named_intrinsics(known, draft));
        take_camera(named, "the camera that was said", printable(known.file.filename().string()), draft);
        const auto is_far = [](double at, int side) { return at < -0.5 * side || at > 1.5 * side; };
        if (is_far(scene.camera.cx, scene.width) || is_far(scene.camera.cy, scene.height))
            draft.tell("the principal point that was said, " + short_number(scene.camera.cx) + ", " +
                       short_number(scene.camera.cy) + ", is far beside the picture");
    } else if (known.fov) {
        scene.camera = scaled_camera({.fov_x = *known.fov}, scene.width, scene.height);
    } else if (const auto& frames = evidence.frames) {
        scene.camera = frames->median;
        draft.tell("the camera is that of " + frames->files + (is_still(frames->files) ? "" : ", the median"),
                   {{Setting::intrinsics}});
    } else if (beside.camera) {
        take_camera_beside(beside, folder, draft);
    } else if (preset && preset->intrinsics.fx > 0) {
        take_camera(preset->intrinsics, "the camera of preset " + std::string(preset->name), "", draft);
    } else {
        const double fov = preset && preset->fov > 0 ? preset->fov : usual_fov;
        scene.camera = scaled_camera({.fov_x = fov}, scene.width, scene.height);
        draft.say(guessed_field_of_view(fov) + not_understood_words(beside),
                  {{Setting::field_of_view}, {Setting::intrinsics}}, RemarkKind::camera);
    }
    tell_of_unused(beside.not_used, draft);
    return {};
}

// --- The whole scene

/// Describes depth as in this picture; its camera is sought in `place`. `coding`, if any, is kept, whatever
/// the values are.
Result<void> describe_depth(const StoredImage& depth, PicturesOfCamera place, DepthEvidence& evidence,
                            SceneDraft& draft, const DepthCoding* coding = nullptr) {
    draft.own_file = place.own_file;
    draft.unstated.filters = all_unstated;
    // What varies from pixel to pixel in a rendering is relief.
    if (depth.is_rendered) draft.unstated.filters.median = draft.unstated.filters.temporal = false;
    Scene& scene = draft.scene;
    scene.width = place.width = depth.image.width;
    scene.height = place.height = depth.image.height;
    scene.metres_per_unit = 1;
    scene.depth_bits = depth.values.empty() && depth.image.bytes_per_sample == 1 ? 8 : 16;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.near_is_high = true;
    scene.hole_stiffness = Scene::soft_holes;
    const SourceDescription& known = evidence.known;
    CameraBeside& beside = evidence.beside = camera_beside(place);
    if (known.intrinsics && !known.file.empty()) take_scale_of(known.file, beside);
    if (beside.file.filename() == "calib_cam_to_cam.txt" && !evidence.preset && !evidence.has_unit() &&
        !evidence.says_disparity && holds_words(depth))
        // Metres of streets; millimetres, taken so, would be farther.
        if (const double median = estimate_values(depth).median / 256; median > 1 && median < 30)
            evidence.set_preset({preset_named("kitti"), "the camera's file beside it is KITTI's"});
    const bool is_evident = !evidence.why_preset.empty();
    if (is_evident && beside.codes_per_metre.value > 0 && evidence.preset->stored.packed == Packing::none)
        evidence.set_preset({});
    TRY(find_scene_camera(evidence, place.folder, draft));
    if (coding)
        scene.depth = *coding;
    else
        TRY(guess_values(depth, evidence, draft));
    if (beside.camera && beside.camera->scale_differs &&
        scene.depth.scale == 1 / beside.camera->codes_per_metre)
        draft.say("a code is " + short_number(1000 * scene.depth.scale) + " mm in all frames, though " +
                      printable(beside.file.filename().string()) + " gives some another scale",
                  {{Setting::depth_unit}}, RemarkKind::unit);
    if (known.semantics) scene.depth.semantics = *known.semantics;
    derive_valid_range(scene.depth);
    const auto valid = validate(draft);
    if (valid) return {};
    if (known == SourceDescription()) {
        const auto& where = beside.camera          ? beside.file
                            : draft.inputs.empty() ? place.folder
                                                   : draft.inputs.back();
        return error_at(where.string(), valid.error());
    }
    return usage_error(
        "with the camera and the unit that were said: " + valid.error().message,
        {{Setting::intrinsics}, {Setting::field_of_view}, {Setting::depth_unit}, {Setting::preset}});
}

/// Tells what a JPEG has lost, which cannot be restored.
void tell_of_jpeg(const StoredImage& depth, SceneDraft& draft) {
    if (depth.codec != "mjpeg") return;
    const DepthCoding& coding = draft.scene.depth;
    const double middle = coding.depth(128), step = std::abs(coding.depth(129) - middle);
    draft.tell("depth is a JPEG, and has lost what is finer than 256 levels (" + short_number(step, 2) +
               " m at " + short_number(middle, 2) + " m); JPEG moved pixels by some of these, most of all " +
               "beside edges. Where there is a PNG of 16 bits or an array of the same, take that");
}

/// Describes depth in files, of which `first` was read: its camera is sought in `place`, and `name` is
/// evidence.
Result<void> describe_files(const StoredImage& depth, ReadPictures& pictures, const fs::path& first,
                            const fs::path& name, PicturesOfCamera place, DepthEvidence& evidence,
                            SceneDraft& draft) {
    const auto files = place.frames.empty() ? std::vector{first} : place.frames;
    if (files.size() == 1) TRY(add_own_arrays(files.front(), pictures, place));
    if (const auto camera = pictures.camera_in(files))
        set_own_camera({{{.intrinsics = *camera}}}, first, place);
    evidence.are_points = is_named_cloud(first);
    if (!evidence.are_points) evidence.know_name(name);
    if (const auto arrays = pictures.stack_in(first); arrays && *arrays)
        evidence.know_array((*arrays)->array());
    const std::string where = (place.is_whole_folder ? place.folder : first).string();
    TRY(error_at(where, describe_depth(depth, std::move(place), evidence, draft)));
    if (!evidence.why_preset.empty())
        draft.say("depth is as preset " + std::string(evidence.preset->name) + " has it (" +
                      evidence.preset->what + "), as " + evidence.why_preset,
                  {{Setting::preset}, {Setting::depth_unit}}, RemarkKind::storage);
    tell_of_jpeg(depth, draft);
    return {};
}

/// Tells the channels of a rendering, which may have colour in depth's own files.
void tell_of_layers(const BesideDepth& beside, bool takes_colour, SceneDraft& draft) {
    if (beside.depth_name.empty()) return;  // a cloud's
    std::string said = "depth is channel " + beside.depth_name;
    if (beside.depths > 1) said += ", the first of " + std::to_string(beside.depths) + " in a file";
    if (takes_colour)
        said += ", colour is " + (beside.colour_name.empty() ? "R, G, B" : beside.colour_name) +
                " beside it, linear light shown as sRGB";
    draft.say(std::move(said));
}

constexpr const char* rate_otherwise = "a scene file's rate says otherwise";

void set_rate(const FrameRate& rate, const std::string& why, SceneDraft& draft) {
    draft.scene.rate = rate;
    draft.tell(short_number(rate.per_second()) + " frames a second, as " + why, {}, rate_otherwise);
}
/// Takes the rate of a colour video; false if there is none with as many frames as depth.
bool take_video_rate(const std::optional<ColourVideo>& video, std::int64_t frames, SceneDraft& draft) {
    if (!video || video->file->count() != frames) return false;
    set_rate(video->file->rate(), printable(video->name) + " has as many frames at that rate", draft);
    return true;
}
/// Takes the rate that a file beside depth states; false if none does.
bool take_stated_rate(const StatedNumber& per_second, SceneDraft& draft) {
    constexpr double slowest = 0.01;
    if (per_second.value < slowest) return false;
    draft.add_input(per_second.file);
    set_rate(stated_rate(per_second.value), printable(per_second.file.filename().string()) + " says", draft);
    return true;
}
/// Sets the rate by the frames' times, a file beside them, or a colour video with as many frames.
Result<void> find_rate(const fs::path& folder, std::int64_t frames, const std::optional<ColourVideo>& video,
                       const StatedNumber& stated, SceneDraft& draft) {
    Scene& scene = draft.scene;
    TRY_ASSIGN(const auto files, depth_files(folder, *scene.folder));
    const auto rate = rate_of(files);
    if (!rate && (take_stated_rate(stated, draft) || take_video_rate(video, frames, draft))) return {};
    if (rate) scene.rate = *rate;
    const std::string why = unusable_times(files);
    const std::string words =
        short_number(scene.rate.per_second()) + " frames a second" +
        (scene.rate.own_times ? " on average, each at its own time"
         : rate               ? (files.remark.empty() ? ", by their times" : ", the mean of their times")
         : why.empty()        ? ""
                              : ", as " + why);
    add_remark(scene.remarks, {words, !rate, rate_otherwise});
    return {};
}

/// Takes colour's camera from ViSP's files, which are in metres; false if there is none, or depth is not.
bool take_colour_camera(const fs::path& movement, const Image& colour, const DepthEvidence& evidence,
                        SceneDraft& draft) {
    Scene& scene = draft.scene;
    if (scene.stored.kind == StoredDepth::Kind::relative) return false;
    const auto found = visp_colour_camera(movement, evidence.beside.file, colour.width, colour.height);
    if (!found) return false;
    scene.colour_camera = found->camera;
    if (!validate(draft)) {
        scene.colour_camera.reset();
        return false;
    }
    draft.add_input(found->file);
    const bool is_unit_told = evidence.has_unit();
    add_remark(scene.remarks,
               {"colour is brought onto depth's pixels, as " + printable(movement.filename().string()) +
                    " and " + printable(found->file.filename().string()) + " say" +
                    (is_unit_told ? "" : ", by the unit that is guessed"),
                !is_unit_told, "a scene file's colour_camera says otherwise",
                is_unit_told ? Hints{} : Hints{{Setting::depth_unit, ""}}});
    return true;
}

/// If files there or colour's shape say that it does not lie on depth's pixels, takes colour's camera from
/// the files, or adds a remark that colour is nevertheless taken to lie there.
void place_colour(const fs::path& folder, const fs::path& colour, ReadPictures& pictures,
                  const DepthEvidence& evidence, SceneDraft& draft) {
    const fs::path here = folder.empty() ? fs::path(".") : folder;
    const auto picture = pictures.look(colour);
    std::string why;
    if (const auto file = colour_movement_in(here)) {
        draft.add_input(*file);
        if (picture && take_colour_camera(*file, (*picture)->image, evidence, draft)) return;
        why = file->filename().string() + " says how its camera stands";
    } else if (picture) {
        const Image& image = (*picture)->image;
        const auto other = evidence.has_camera()
                               ? camera_of_colour_in(here, draft.scene, image.width, image.height)
                               : std::nullopt;
        const double across = 1.0 * image.width * draft.scene.height,
                     down = 1.0 * image.height * draft.scene.width;
        if (!other && std::abs(across - down) < 0.03 * down) return;
        why = other ? other->filename().string() + " is of another camera than depth's"
                    : "it is stretched to their shape from " + size_text(image.width, image.height);
        if (other) draft.add_input(*other);
    } else {
        return;
    }
    draft.say("colour lies on depth's pixels, though " + why, {}, RemarkKind::colour_place,
              "a scene file's colour_camera says otherwise");
}

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

void DepthEvidence::know_name(const fs::path& path) {
    const std::string own = path.stem().string();
    const std::string name = words_in_name(own).empty() ? path.parent_path().filename().string() : own;
    is_named = true;
    says_disparity = is_named_disparity(name);
    says_range = is_named_range(name);
    are_heights = is_named_heights(own);
    unit = unit_in_name(name);
}

void DepthEvidence::know_array(const std::string& name) {
    const bool is_depth = has_word(name, {"depth"});
    says_disparity = is_named_disparity(name) || (says_disparity && !is_depth);
    are_heights = is_named_heights(name) || (are_heights && !is_depth);
    says_range = says_range || is_named_range(name);
}

Result<GuessedScene> guess_folder(const fs::path& folder, const SourceDescription& known) {
    TRY_ASSIGN(const auto preset, known_preset(known));
    if (const auto foreign = foreign_folder(folder)) return input_error(folder.string() + ": " + *foreign);
    const auto pictures = std::make_shared<ReadPictures>(known);
    const bool is_relative = preset != nullptr && preset->stored.kind == StoredDepth::Kind::relative;
    TRY_ASSIGN(const auto chosen, choose_pictures(folder, is_relative, *pictures));
    const PictureGroup& depth = chosen.depth;
    const std::optional<PictureGroup>& colour = chosen.colour;
    FolderSource all;
    all.depth = depth.pattern;
    const auto files = depth_files(folder, all);
    TRY_ASSIGN(const auto told,
               telling_depth(files ? files->files : std::vector{depth.first}, *pictures, preset));
    const StoredImage& stored = *told;
    DepthEvidence evidence{known, preset};
    const std::optional<GuessedCameras>& cameras = evidence.frames;
    if (!evidence.has_stated_camera())
        TRY(assign(evidence.frames,
                   guess_cameras(folder, depth.pattern, stored.image.width, stored.image.height)));
    if (!evidence.preset && !evidence.has_unit())
        evidence.set_preset(cameras && holds_words(stored)
                                ? EvidentPreset{preset_named("arkitscenes"), "each frame has a .pincam file"}
                                : evident_in(stored));
    if (is_list(depth.pattern)) evidence.list = depth.pattern;
    PicturesOfCamera place{.folder = folder, .within = folder_of(depth), .is_whole_folder = true};
    if (files) place.frames = files->files;
    SceneDraft guess;
    TRY(describe_files(stored, *pictures, depth.first, fs::weakly_canonical(folder) / depth.pattern,
                       std::move(place), evidence, guess));
    Scene& scene = guess.scene;
    scene.name = fs::weakly_canonical(folder).filename().string();
    scene.folder.emplace();
    scene.folder->depth = depth.pattern;
    if (cameras && !is_still(cameras->files) && scene.stored.kind != StoredDepth::Kind::disparity)
        scene.folder->cameras = cameras->files;
    const std::string& frame_cameras = evidence.beside.frame_cameras;
    if (!frame_cameras.empty() && !evidence.has_stated_camera() &&
        scene.stored.kind != StoredDepth::Kind::disparity)
        scene.folder->cameras = usable_cameras(folder, *scene.folder, frame_cameras, scene);
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
    auto arrays = camera_arrays(folder);
    const fs::path read = evidence.beside.file.filename();
    std::erase_if(arrays, [&](const PictureGroup& group) { return group.first.filename() == read; });
    if (!arrays.empty())
        guess.tell("arrays beside the pictures, and not used: " +
                       printable(listed(arrays, &PictureGroup::pattern), 200),
                   {{Setting::intrinsics, "FX,FY,CX,CY"}}, "their numbers can be said");
    if (beside != nullptr) tell_of_layers(*beside, has_own_colour, guess);
    if (!chosen.left_out_by_path.empty())
        guess.say("left out: " + printable(listed(chosen.left_out_by_path), 200), {}, RemarkKind::other,
                  "name one of these to open it");
    if (!chosen.left_out_by_pattern.empty())
        guess.say("left out: " + printable(listed(chosen.left_out_by_pattern), 200), {}, RemarkKind::other,
                  "a scene file's folder.depth names one of these to open it");
    if (colour) place_colour(folder, colour->first, *pictures, evidence, guess);
    TRY(check_projection(stored, depth.first, colour ? colour->first : fs::path(), *pictures, evidence,
                         guess));
    if (video && !video->others.empty())
        guess.say("left out: " + printable(listed(video->others), 200) + ", which may be colour as well", {},
                  RemarkKind::other, "a scene file's folder.colour names another one");
    if (frames > 1) TRY(find_rate(folder, frames, video, evidence.beside.frames_per_second, guess));
    pictures->keep_only({depth.first, colour ? colour->first : fs::path()});
    guess.pictures = pictures;
    if (video) guess.video = video->file;
    return GuessedScene(std::move(guess));
}

Result<GuessedScene> guess_scene(const fs::path& file, const StoredImage& depth,
                                 const SourceDescription& known, const DepthCoding* coding,
                                 double usual_unit) {
    TRY_ASSIGN(const auto preset, error_at(file.string(), known_preset(known)));
    DepthEvidence evidence{known, preset};
    evidence.usual_unit = usual_unit;
    SceneDraft guess;
    TRY(error_at(file.string(),
                 describe_depth(depth, {.folder = file.parent_path()}, evidence, guess, coding)));
    guess.scene.name = file.stem().string();
    return GuessedScene(std::move(guess));
}

Result<SceneDescription> guess_camera(const StoredImage& first, const SourceDescription& known,
                                      std::vector<fs::path>& inputs) {
    TRY_ASSIGN(const auto preset, known_preset(known));
    DepthEvidence evidence{known, preset};
    SceneDraft guess;
    TRY(describe_depth(first, {.folder = "/dev"}, evidence, guess));  // has no camera's file
    inputs = std::move(guess.inputs);
    return SceneDescription(std::move(guess));
}

Result<GuessedScene> guess_picture(const SourceFile& source, const SourceDescription& known) {
    const fs::path& file = source.path();
    TRY_ASSIGN(const auto preset, known_preset(known));
    const std::string name = file.filename().string();
    const auto pictures = std::make_shared<ReadPictures>(known, source);
    TRY_ASSIGN(const auto told, telling_depth({file}, *pictures, preset));
    const StoredImage& stored = *told;
    const auto metadata = realsense_metadata_of(file);
    DepthEvidence evidence{known, preset};
    SceneDraft guess;
    if (!evidence.has_unit() && metadata) {
        evidence.preset = preset_named("realsense");
        guess.tell("a code is 1 mm, as the RealSense Viewer writes it", {{Setting::depth_unit}});
    } else if (!evidence.preset && !evidence.has_unit()) {
        evidence.set_preset(evident_in(stored));
    }
    PicturesOfCamera place{.folder = file.parent_path(), .within = {}, .stem = file.stem().string()};
    if (metadata) {
        TRY_ASSIGN(const auto camera, read_realsense_metadata(*metadata));
        set_own_camera({{{.intrinsics = camera}}}, *metadata, place);
    }
    TRY(describe_files(stored, *pictures, file, fs::weakly_canonical(file), std::move(place), evidence,
                       guess));
    guess.scene.name = file.stem().string();
    FolderSource& folder = guess.scene.folder.emplace();
    folder.depth = name;
    if (const auto colour = colour_beside(file, *pictures)) {
        folder.colour = colour->filename().string();
        guess.say("colour is " + folder.colour);
        place_colour(file.parent_path(), *colour, *pictures, evidence, guess);
    } else if (stored.beside && stored.beside->colour) {
        folder.colour = name;
    }
    if (stored.beside) tell_of_layers(*stored.beside, folder.colour == name, guess);
    TRY(check_projection(stored, file,
                         folder.colour.empty() ? fs::path() : file.parent_path() / folder.colour, *pictures,
                         evidence, guess));
    TRY_ASSIGN(const auto stack, pictures->stack_in(file));
    std::optional<ColourVideo> video;
    if (stack && stack->count() > 1 && folder.colour.empty()) video = colour_video_beside(file);
    if (video) {
        folder.colour = video->name;
        guess.say("colour is " + printable(video->name));
    }
    if (stack && stack->count() > 1)
        TRY(find_rate(file.parent_path(), stack->count(), video, evidence.beside.frames_per_second, guess));
    if (metadata) guess.inputs.push_back(*metadata);
    guess.pictures = pictures;
    if (video) guess.video = video->file;
    return GuessedScene(std::move(guess));
}

std::optional<Remark> unit_doubt(double median_m, std::string otherwise, Hints hints) {
    // From an endoscope's depths to a lidar's. A unit wrong by a thousand moves a hand's reach out of this.
    constexpr double nearest = 0.01, farthest = 300;  // metres
    if (median_m >= nearest && median_m <= farthest) return std::nullopt;
    return Remark{"the median depth is " + length_in_words(median_m) + ": the unit may be wrong", false,
                  std::move(otherwise), std::move(hints), RemarkKind::unit_doubt};
}

}  // namespace touchable
