#include "engine/formats/scene_guess.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/far_plane.hpp"
#include "engine/formats/known_camera.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/unregistered_colour.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

/// N/mm. Where a camera saw nothing no wall pushes with all that a device can (docs/scene_file.md, Holes).
constexpr double soft_holes = 0.1;
constexpr double most_of_lengths = 1.05;                 // lower in a picture, times what is above
constexpr double assumed_near = 0.5, assumed_far = 1.5;  // metres, of depth without a scale

/// As programs say it: 29.97 stands for 30000/1001.
FrameRate stated_rate(double per_second) {
    const double whole = std::round(per_second), ntsc = whole * 1000 / 1001;
    if (std::abs(per_second - ntsc) < 0.0006 * whole && whole >= 24)
        return {1000 * static_cast<std::int64_t>(whole), 1001};
    const std::int64_t thousandths = std::llround(1000 * per_second), common = std::gcd(thousandths, 1000);
    return {thousandths / common, 1000 / common};
}

}  // namespace

bool holds_words(const StoredImage& picture) {
    return picture.values.empty() && picture.image.bytes_per_sample == 2 && picture.bits == 16;
}

/// Of pictures of another size, those of a camera with the same view.
void SceneGuess::take(const Intrinsics& intrinsics, const std::string& whose) {
    if (intrinsics.width > 0 && intrinsics.height > 0 &&
        (intrinsics.width != scene_.width || intrinsics.height != scene_.height))
        tell(whose + " is of " + std::to_string(intrinsics.width) + "x" + std::to_string(intrinsics.height) +
                 " pixels and is scaled to these pictures",
             {}, {{Setting::intrinsics}});
    scene_.camera = scaled_camera(intrinsics, scene_.width, scene_.height);
}

void SceneGuess::take_fov(double degrees) {
    scene_.camera = camera_of_fov(degrees, scene_.width, scene_.height);
}

Result<void> SceneGuess::find_camera(const fs::path& folder) {
    place_.folder = folder;
    place_.width = scene_.width;
    place_.height = scene_.height;
    beside_ = camera_beside(place_);
    if (beside_.camera) {
        file_ = *beside_.camera;
        inputs_.push_back(beside_.file);
    }
    has_camera_of_depth_ = known_.intrinsics || known_.fov || frames_ || beside_.camera;
    if (known_.intrinsics) {
        take(*known_.intrinsics, "the camera that was said");
        const Camera& camera = scene_.camera;
        const auto is_far = [](double at, int side) { return at < -0.5 * side || at > 1.5 * side; };
        if (is_far(camera.cx, scene_.width) || is_far(camera.cy, scene_.height))
            add_remark(scene_.remarks, {"the principal point that was said, " + short_number(camera.cx) +
                                        ", " + short_number(camera.cy) + ", is far beside the picture"});
    } else if (known_.fov) {
        take_fov(*known_.fov);
    } else if (frames_) {
        scene_.camera = frames_->median;
        tell("the camera is that of " + frames_->files + (is_still(frames_->files) ? "" : ", the median"), {},
             {{Setting::intrinsics}});
    } else if (beside_.camera) {
        const std::string name = printable(beside_.file.filename().string());
        take(file_.intrinsics, name);
        std::error_code ignored;
        const fs::path here = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, ignored);
        std::string whose =
            "the camera is that of " + printable(beside_.file.lexically_relative(here).string());
        if (!file_.name.empty()) whose += " (" + printable(file_.name, 60) + ')';
        if (!beside_.doubt.empty()) whose += ", " + beside_.doubt;
        if (file_.has_distortion) whose += "; its lens's distortion is not undone";
        tell(whose + not_understood(), {}, {{Setting::intrinsics}});
    } else if (preset_ && preset_->intrinsics.fx > 0) {
        take(preset_->intrinsics, "the camera of preset " + std::string(preset_->name));
    } else {
        const double fov = preset_ && preset_->fov > 0 ? preset_->fov : usual_fov;
        take_fov(fov);
        say(guessed_field_of_view(fov) + not_understood(),
            Hints{{Setting::field_of_view}, {Setting::intrinsics}});
    }
    return {};
}

/// Names files that look like a camera's and are not understood.
std::string SceneGuess::not_understood() const {
    std::string names;
    for (const std::string& name : beside_.not_understood) names += (names.empty() ? "" : ", ") + name;
    return names.empty() ? "" : "; not understood as a camera's file: " + printable(names, 200);
}

void SceneGuess::set_metric(double metres_per_code) {
    DepthCoding& depth = scene_.depth;
    depth.kind = DepthCodingKind::metric;
    depth.scale = metres_per_code;
    depth.code_max = scene_.depth_bits == 8 ? 255 : 65535;
    depth.far = depth.scale * depth.code_max;
    described_.unstated.far = true;
}

void SceneGuess::set_relative(bool near_is_high, bool is_inverse) {
    DepthCoding& depth = scene_.depth;
    scene_.stored.kind = StoredDepth::Kind::relative;
    depth.kind = is_inverse ? DepthCodingKind::inverse : DepthCodingKind::linear;
    depth.near_is_high = near_is_high;
    depth.near = assumed_near;
    depth.far = assumed_far;
    depth.code_max = scene_.depth_bits == 8 ? 255 : 65535;
    say("depth has no scale: its nearest is taken for " + short_number(assumed_near) +
            " m and its farthest for " + short_number(assumed_far) + " m, " +
            (near_is_high ? "large" : "small") + " values near",
        "a scene file says otherwise, touchable init-scene writes one to begin with; where values are "
        "lengths, their unit",
        {{Setting::depth_unit}});
}

/// By the size of what is there.
Result<void> SceneGuess::find_unit(const EstimatedValues& values) {
    if (!values.any)
        return input_error(
            values.has_background
                ? "has no depth: all values are 0 or a renderer's background (1e9 and beyond, 65504)"
                : "has no depth: all values are 0 or 65535, or none is finite");
    if (known_.metres_per_code) {
        set_metric(*known_.metres_per_code);
        return {};
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
        } else if (preset_->intrinsics.fx > 0) {  // baseline x fx is what is known
            scene_.stored.baseline *= preset_->intrinsics.fx / scene_.camera.fx;
        }
        scene_.depth.kind = DepthCodingKind::inverse;
        scene_.depth.code_max = scene_.depth_bits == 8 ? 255 : 65535;
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
    if (file_.codes_per_metre > 0) {
        set_metric(1 / file_.codes_per_metre);
        return {};
    }
    guess_unit(values);
    return {};
}

/// Names a unit by which the values would be lengths that a hand reaches, if there is one.
void SceneGuess::doubt_unit(const EstimatedValues& values) {
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
    if (auto doubt = unit_doubt(values.median * scene_.depth.scale, std::move(otherwise), {std::move(hint)}))
        add_remark(scene_.remarks, std::move(*doubt));
}

/// Cameras measure in whole millimetres, and files may have these times 5, 10 or 100. Whether that settles
/// the unit.
bool SceneGuess::guess_unit_of_multiples(const EstimatedValues& values) {
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
    say("a code is " + short_number(1.0 / divisor) + " mm, as " + multiples + " and their median is then " +
            short_number(median) + " mm",
        Hints{{Setting::depth_unit, values.median <= deepest ? "0.001" : ""}});
    return true;
}

void SceneGuess::guess_unit(const EstimatedValues& values) {
    const Hints otherwise{{Setting::depth_unit}};
    const bool is_signed = values.negative > 0.01;
    if (values.is_of_bytes())
        say("values are 8 bits stored as 16, as all are multiples of " + std::to_string(values.divisor),
            otherwise);
    if (values.bits == 8 || values.is_of_bytes() || values.is_normalised || is_signed) {
        // What is larger where it is nearer is 1/depth, as most networks guess it; what grows with depth is
        // depth.
        const bool near_is_high = is_signed || values.lower >= values.upper;
        set_relative(near_is_high, near_is_high);
    } else if (values.is_float) {
        const bool metres = values.median < 30;
        set_metric(metres ? 1 : 0.001);
        say(std::string("values are ") + (metres ? "metres" : "millimetres") + ", as their median is " +
                short_number(values.median),
            otherwise);
        // What is lower in a picture is mostly nearer.
        if (values.lower > most_of_lengths * values.upper)
            say("values are lengths, though they are larger in the lower third of the picture, as 1/depth of "
                "networks is",
                "", {{Setting::preset, "relative-inverse"}});
    } else if (!list_.empty() || !guess_unit_of_multiples(values)) {
        const bool fine = values.median > 12000, coarse = values.median < 100;
        const double unit = fine || !list_.empty() ? 1.0 / 5000 : coarse ? 0.01 : 0.001;
        set_metric(unit);
        say("a code is " + short_number(1000 * unit) + " mm, as " +
                (list_.empty() ? "their median is " + short_number(values.median)
                               : "recordings with a " + list_ + " have it (TUM RGB-D)"),
            otherwise);
    }
}

/// Cameras write 0 where they see nothing. Depth without a scale has something everywhere.
void SceneGuess::set_invalid(const StoredImage& depth, bool has_negative_none) {
    if (scene_.stored.kind == StoredDepth::Kind::relative) return;
    const bool is_told = preset_ != nullptr || known_.metres_per_code.has_value();
    const int other = preset_ ? preset_->invalid : holds_words(depth) && !is_told ? 65535 : 0;
    DepthCoding& coding = scene_.depth;
    for (const int code : {0, other})
        if (coding.invalid_code_count == 0 || (code > 0 && code <= coding.code_max))
            coding.invalid_codes[static_cast<std::size_t>(coding.invalid_code_count++)] =
                static_cast<std::uint16_t>(code);
    if (!is_told)
        say(other > 0           ? "0 and 65535 are no depth"
            : has_negative_none ? "0 and what is below it are no depth"
                                : "0 is no depth");
}

Result<void> SceneGuess::describe(const fs::path& folder, const StoredImage& depth,
                                  const DepthCoding* coding) {
    scene_.width = depth.image.width;
    scene_.height = depth.image.height;
    scene_.metres_per_unit = 1;
    scene_.depth_bits = depth.values.empty() && depth.image.bytes_per_sample == 1 ? 8 : 16;
    scene_.depth.semantics = DepthSemantics::planar;
    scene_.depth.near_is_high = true;
    described_.unstated.filters = all_unstated;
    scene_.hole_stiffness = soft_holes;
    if (auto found = find_camera(folder); !found) return found;
    if (coding) {
        scene_.depth = *coding;
    } else {
        const EstimatedValues values = estimate_values(depth);
        if (stop_requested()) return Error{ErrorKind::interrupted, "interrupted while it was looked at"};
        if (auto found = find_unit(values); !found) return found;
        doubt_unit(values);
        set_invalid(depth, values.has_negative_none);
    }
    derive_valid_range(scene_.depth);
    const auto valid = validate(described_);
    if (valid) return {};
    if (known_ == SourceDescription())
        return error_at((inputs_.empty() ? folder : inputs_.back()).string(), valid.error());
    return usage_error(
        "with the camera and the unit that were said: " + valid.error().message,
        {{Setting::intrinsics}, {Setting::field_of_view}, {Setting::depth_unit}, {Setting::preset}});
}

Result<void> SceneGuess::find_rate(const fs::path& folder) {
    TRY_ASSIGN(const auto files, depth_files(folder, *scene_.folder));
    const auto rate = rate_of(files);
    constexpr double slowest = 0.01;
    if (!rate && beside_.frames_per_second >= slowest) {
        scene_.rate = stated_rate(beside_.frames_per_second);
        if (inputs_.empty() || inputs_.back() != beside_.rate_file) inputs_.push_back(beside_.rate_file);
        tell(short_number(scene_.rate.per_second()) + " frames a second, as " +
                 printable(beside_.rate_file.filename().string()) + " says",
             "a scene file's rate says otherwise");
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

/// Only of depth that has metres, as the movement has.
bool SceneGuess::take_colour_camera(const fs::path& movement, const Image& colour) {
    if (scene_.stored.kind == StoredDepth::Kind::relative) return false;
    const auto found = visp_colour_camera(movement, beside_.file, colour.width, colour.height);
    if (!found) return false;
    scene_.colour_camera = found->camera;
    if (!validate(described_)) {
        scene_.colour_camera.reset();
        return false;
    }
    inputs_.push_back(found->file);
    const bool is_unit_told = preset_ != nullptr || known_.metres_per_code.has_value();
    add_remark(scene_.remarks,
               {"colour is brought onto depth's pixels, as " + printable(movement.filename().string()) +
                    " and " + printable(found->file.filename().string()) + " say" +
                    (is_unit_told ? "" : ", by the unit that is guessed"),
                !is_unit_told, "a scene file's colour_camera says otherwise",
                is_unit_told ? Hints{} : Hints{{Setting::depth_unit, ""}}});
    return true;
}

void SceneGuess::place_colour(const fs::path& folder, const fs::path& colour, ReadPictures& pictures) {
    const fs::path here = folder.empty() ? fs::path(".") : folder;
    const auto picture = pictures.look(colour);
    std::string why;
    if (const auto file = colour_movement_in(here)) {
        inputs_.push_back(*file);
        if (picture && take_colour_camera(*file, (*picture)->image)) return;
        why = file->filename().string() + " says how its camera stands";
    } else if (picture && has_camera_of_depth_) {
        const auto other =
            camera_of_colour_in(here, scene_, (*picture)->image.width, (*picture)->image.height);
        if (!other) return;
        why = other->filename().string() + " is of another camera than depth's";
        inputs_.push_back(*other);
    } else {
        return;
    }
    say("colour lies on depth's pixels, though " + why, "a scene file's colour_camera says otherwise");
}

/// Of a rendering, which may have colour in depth's own files.
void SceneGuess::tell_of_layers(const BesideDepth& beside, bool takes_colour) {
    std::string said = "depth is channel " + beside.depth_name;
    if (beside.depths > 1) said += ", the first of " + std::to_string(beside.depths) + " in a file";
    if (takes_colour)
        said += ", colour is " + (beside.colour_name.empty() ? "R, G, B" : beside.colour_name) +
                " beside it, linear light shown as sRGB";
    say(std::move(said));
}

void SceneGuess::tell_of_preset(const EvidentPreset& evident) {
    if (evident.preset == nullptr) return;
    say("depth is as preset " + std::string(evident.preset->name) + " has it (" + evident.preset->what +
            "), as " + evident.why,
        Hints{{Setting::preset}, {Setting::depth_unit}});
}

/// What is lost, and that nothing here brings it back.
void SceneGuess::tell_of_jpeg(const StoredImage& depth) {
    if (depth.codec != "mjpeg") return;
    const DepthCoding& coding = scene_.depth;
    const double middle = coding.depth(128), step = std::abs(coding.depth(129) - middle);
    add_remark(scene_.remarks,
               {"depth is a JPEG, and has lost what is finer than 256 levels (" + short_number(step, 2) +
                " m at " + short_number(middle, 2) + " m); JPEG moved pixels by some of these, most of all " +
                "beside edges. Where there is a PNG of 16 bits or an array of the same, take that"});
}

}  // namespace touchable
