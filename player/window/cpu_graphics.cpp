#include "engine/base/try.hpp"
#include "player/draw/cpu_drawing.hpp"
#include "player/window/window_graphics.hpp"

namespace touchable {
namespace {

class CpuGraphics final : public WindowGraphics {
public:
    std::string_view painter() const override { return "cpu"; }
    std::string gpu() const override { return {}; }
    bool is_lost() const override { return false; }
    bool can_stretch() const override { return false; }
    bool thins_vertices() const override { return false; }

    Result<void> take_letters() override { return {}; }
    Result<void> begin() override { return {}; }
    Result<void> show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting, int) override {
        drawing_.show(field, pair, colour, lighting);
        return {};
    }
    Result<void> draw(const ViewCamera& camera, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                      int /*width*/, int /*height*/) override {
        TRY_ASSIGN(const auto drawn, drawing_.draw(camera, fingers, sizes));
        picture_ = drawn;
        return {};
    }
    Result<void> finish() override { return {}; }
    Result<Image> picture() const override {
        if (!picture_) return usage_error("there is no picture yet that could be kept");
        return *picture_;
    }

private:
    CpuDrawing drawing_;
    const Image* picture_ = nullptr;
};

}  // namespace

std::unique_ptr<WindowGraphics> make_cpu_graphics() {
    return std::make_unique<CpuGraphics>();
}

}  // namespace touchable
