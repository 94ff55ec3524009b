#include "engine/formats/depth_photo.hpp"

#include <cmath>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/trigonometry.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/known_camera.hpp"
#include "engine/formats/stored_clip.hpp"

namespace touchable {
namespace {

constexpr double film_diagonal = 43.2666;                  // mm, of 36 x 24
constexpr double unscaled_near = 0.5, unscaled_far = 1.5;  // metres, of depth without a scale

/// Both pictures, each of which is given away once.
class PhotoPictures final : public FrameSource {
public:
    PhotoPictures(std::string file, DepthPhoto photo) : file_(std::move(file)), photo_(std::move(photo)) {}
    std::string where(PlaneRole role, std::int64_t) const override {
        return file_ + ": " + std::string(role_name(role));
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t) override {
        return TrackPicture{std::move(role == PlaneRole::depth ? photo_.depth : photo_.colour)};
    }

private:
    std::string file_;
    DepthPhoto photo_;
};

/// Makes the scene of what a photograph's file says.
class PhotoScene {
public:
    PhotoScene(const std::filesystem::path& file, const DepthPhoto& photo) : file_(file), photo_(photo) {}
    Result<SceneDescription> describe(const SourceDescription& known);

private:
    void guess(std::string what, Hints otherwise) {
        add_remark(described_.scene.remarks, {std::move(what), true, {}, std::move(otherwise)});
    }
    void find_camera(const SourceDescription& known);

    const std::filesystem::path& file_;
    const DepthPhoto& photo_;
    SceneDescription described_;
};

/// And of what it does not.
Result<SceneDescription> PhotoScene::describe(const SourceDescription& known) {
    const Image& depth = photo_.depth.image;
    Scene& scene = described_.scene;
    scene.remarks = joined_remarks({}, photo_.remarks);
    scene.name = file_.stem().string();
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
        return is_said
                   ? usage_error(file_.string() + ": with the camera that was said: " + valid.error().message,
                                 {{Setting::intrinsics}, {Setting::field_of_view}})
                   : error_at(file_.string(), valid.error());
    return described_;
}

void PhotoScene::find_camera(const SourceDescription& known) {
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
        guess(guessed_field_of_view(usual_fov), otherwise);
    }
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_depth_photo(const std::filesystem::path& file, DepthPhoto photo,
                                                     const std::optional<SceneDescription>& described,
                                                     const SourceDescription& known) {
    if (known.metres_per_code || !known.preset.empty())
        return usage_error(file.string() +
                               ": says itself what its depths are, so a unit or a preset says nothing of it: "
                               "leave them out",
                           {{Setting::depth_unit}, {Setting::preset}});
    photo.depth.image = upright(photo.depth.image, photo.depth_turn);
    photo.colour.image = upright(photo.colour.image, photo.colour_turn);
    TRY_ASSIGN(auto scene,
               described ? Result<SceneDescription>(*described) : PhotoScene(file, photo).describe(known));
    StoredClip clip{file.string(), std::move(scene)};
    if (photo.colour_turn != Orientation{})
        clip.notes.emplace_back("the picture is turned upright, as its orientation says");
    clip.count = 1;
    clip.roles = {PlaneRole::depth, PlaneRole::colour};
    clip.inputs = {file};
    clip.pictures = std::make_unique<PhotoPictures>(file.string(), std::move(photo));
    return open_stored_clip(std::move(clip));
}

}  // namespace touchable
