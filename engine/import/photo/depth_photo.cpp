#include "engine/import/photo/depth_photo.hpp"

#include <cmath>
#include <utility>

#include "engine/clip/far_plane.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/import/guess/depth_values.hpp"
#include "engine/import/guess/known_camera.hpp"
#include "engine/import/guess/number_words.hpp"
#include "engine/trigonometry.hpp"
#include "engine/video/codecs.hpp"

namespace touchable {
namespace {

constexpr double film_diagonal = 43.2666;                  // mm, of 36 x 24
constexpr double unscaled_near = 0.5, unscaled_far = 1.5;  // metres, of depth without a scale

class DepthPhotoReader final : public ClipReader {
public:
    DepthPhotoReader(const std::filesystem::path& file, DepthPhoto photo)
        : path_(file), file_(file.string()), photo_(std::move(photo)) {
        add_input(file);
    }
    Result<void> open(const std::optional<SceneDescription>& replacement, const SourceDescription& known);

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return described_.unstated.filters; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return 1; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override {
        if (std::exchange(given_, true)) return std::optional<RawFrame>{};
        return std::optional(frame_);
    }
    Result<void> rewind() override {
        given_ = false;
        return {};
    }

private:
    Error refuse(const std::string& what) const { return input_error(file_ + ": " + what); }
    void guess(std::string what, Hints otherwise) {
        add_remark(described_.scene.remarks, {std::move(what), true, {}, std::move(otherwise)});
    }
    void stand_up();
    Result<void> describe(const SourceDescription& known);
    void find_camera(const SourceDescription& known);
    Result<void> settle_depth(DepthValues& values);
    Result<void> add(PlaneRole role, Image image, int bits);
    void note_what_is_there();
    Result<void> find_far();

    std::filesystem::path path_;
    std::string file_;
    DepthPhoto photo_;
    SceneDescription described_;
    Scene scene_;
    std::vector<TrackInfo> infos_;
    std::vector<std::string> notes_;
    RawFrame frame_;
    bool given_ = false;
};

Result<void> DepthPhotoReader::open(const std::optional<SceneDescription>& replacement,
                                    const SourceDescription& known) {
    if (known.metres_per_code || !known.preset.empty())
        return usage_error(file_ +
                               ": says itself what its depths are, so a unit or a preset says nothing of it: "
                               "leave them out",
                           {{Setting::depth_unit}, {Setting::preset}});
    for (const auto& [role, stored] :
         {std::pair{PlaneRole::depth, &photo_.depth}, std::pair{PlaneRole::colour, &photo_.colour}}) {
        infos_.push_back({std::string(role_name(role)), stored->codec, stored->pixel_format,
                          stored->image.width, stored->image.height});
        if (auto note = lossy_note(role, stored->codec)) notes_.push_back(std::move(*note));
    }
    stand_up();
    if (replacement) {
        described_ = *replacement;
    } else {
        for (Remark& remark : photo_.remarks) add_remark(described_.scene.remarks, std::move(remark));
        if (auto described = describe(known); !described) return described;
    }
    auto scene = settle(described_, {});
    if (!scene) return refuse(scene.error().message);
    scene_ = std::move(*scene);
    DepthValues values(described_);
    if (auto settled = settle_depth(values); !settled) return settled;
    if (auto added = add(PlaneRole::depth, std::move(photo_.depth.image), photo_.depth.bits); !added)
        return added;
    if (auto added = add(PlaneRole::colour, std::move(photo_.colour.image), 0); !added) return added;
    note_what_is_there();
    return values.leaves_far_open() ? find_far() : Result<void>{};
}

void DepthPhotoReader::stand_up() {
    photo_.depth.image = upright(photo_.depth.image, photo_.depth_turn);
    photo_.colour.image = upright(photo_.colour.image, photo_.colour_turn);
    if (photo_.colour_turn == Orientation{}) return;
    notes_.push_back("the picture is turned upright, as its orientation says");
}

/// A scene of what the file says, and of what it does not.
Result<void> DepthPhotoReader::describe(const SourceDescription& known) {
    const Image& depth = photo_.depth.image;
    Scene& scene = described_.scene;
    scene.name = path_.stem().string();
    described_.unstated.filters = all_unstated;
    scene.width = depth.width;
    scene.height = depth.height;
    scene.depth_bits = photo_.depth.bits;
    scene.metres_per_unit = photo_.metres_per_unit;
    scene.depth = photo_.coding;
    if (!photo_.has_scale) {
        scene.stored.kind = StoredDepth::Kind::relative;
        scene.metres_per_unit = 1;
        scene.depth.near = unscaled_near;
        scene.depth.far = unscaled_far;
        guess("depth has no scale: its nearest is taken for " + short_number(unscaled_near) +
                  " m and its farthest for " + short_number(unscaled_far) + " m",
              {});
    }
    find_camera(known);
    derive_valid_range(scene.depth);
    const bool is_said = known.intrinsics || known.fov;
    if (auto valid = validate(scene); !valid)
        return is_said ? usage_error(file_ + ": with the camera that was said: " + valid.error().message,
                                     {{Setting::intrinsics}, {Setting::field_of_view}})
                       : refuse(valid.error().message);
    return {};
}

void DepthPhotoReader::find_camera(const SourceDescription& known) {
    Scene& scene = described_.scene;
    const Hints otherwise{{Setting::field_of_view}, {Setting::intrinsics}};
    const int width = scene.width, height = scene.height;
    const Image& colour = photo_.colour.image;
    if (known.intrinsics) {
        scene.camera = scaled_camera(*known.intrinsics, width, height);
    } else if (known.fov) {
        scene.camera = camera_of_fov(*known.fov, width, height);
    } else if (photo_.camera) {
        scene.camera = scaled_camera(*photo_.camera, width, height);
    } else if (photo_.film_focal_length > 0) {
        const double w = colour.width, h = colour.height;
        const double focal_length = photo_.film_focal_length / film_diagonal * std::sqrt(w * w + h * h);
        scene.camera = scaled_camera(
            {focal_length, focal_length, std::nullopt, std::nullopt, colour.width, colour.height}, width,
            height);
        guess("the camera sees " + short_number(360 / pi * arctangent(0.5 * width / scene.camera.fx)) +
                  " degrees from left to right, by its focal length, " +
                  short_number(photo_.film_focal_length) + " mm in terms of 35 mm film",
              otherwise);
    } else {
        scene.camera = camera_of_fov(usual_fov, width, height);
        guess("the camera sees " + short_number(usual_fov) + " degrees from left to right", otherwise);
    }
}

/// Codes of what is stored, where that is not codes already.
Result<void> DepthPhotoReader::settle_depth(DepthValues& values) {
    if (!values.needs_looks(photo_.depth)) {
        photo_.depth.image = values.codes(std::move(photo_.depth));
        return {};
    }
    values.look(photo_.depth);
    auto said = values.settle(scene_);
    if (!said) return refuse(said.error().message);
    notes_.push_back(std::move(*said));
    photo_.depth.image = values.codes(std::move(photo_.depth));
    photo_.depth.bits = 16;
    return {};
}

Result<void> DepthPhotoReader::add(PlaneRole role, Image image, int bits) {
    if (role != PlaneRole::depth && (image.width != scene_.width || image.height != scene_.height))
        notes_.push_back(resampling_note(role, image.width, image.height, scene_));
    auto plane = fit_plane(role, plane_from(std::move(image), bits), scene_,
                           file_ + ": " + std::string(role_name(role)));
    if (!plane) return plane.error();
    add_plane(frame_, role, std::move(*plane));
    return {};
}

void DepthPhotoReader::note_what_is_there() {
    if (auto note = default_touch_note(false, scene_)) notes_.push_back(std::move(*note));
    if (auto note = no_depth_note(frame_, scene_.depth)) notes_.push_back(std::move(*note));
}

Result<void> DepthPhotoReader::find_far() {
    FarPlaneEstimator estimator(scene_.depth);
    estimator.add(frame_.depth);
    auto note = estimator.settle(scene_);
    if (!note) return refuse(note.error().message);
    notes_.push_back(std::move(*note));
    return {};
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_depth_photo(const std::filesystem::path& file, DepthPhoto photo,
                                                     const std::optional<SceneDescription>& described,
                                                     const SourceDescription& known) {
    auto reader = std::make_unique<DepthPhotoReader>(file, std::move(photo));
    if (auto opened = reader->open(described, known); !opened) return opened.error();
    return std::unique_ptr<ClipReader>(std::move(reader));
}

}  // namespace touchable
