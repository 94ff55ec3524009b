#include "engine/surface/fallback_builder.hpp"

namespace touchable {
namespace {

class FallbackBuilder final : public SurfaceBuilder {
public:
    FallbackBuilder(std::unique_ptr<SurfaceBuilder> first, std::unique_ptr<SurfaceBuilder> second,
                    std::function<void(const std::string&)> told)
        : first_(std::move(first)), second_(std::move(second)), told_(std::move(told)) {}

    std::string_view name() const override { return (first_ ? *first_ : *second_).name(); }
    double built_share() const override { return (first_ ? *first_ : *second_).built_share(); }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (!first_) return second_->build(raw, out);
        Result<void> built = first_->build(raw, out);
        if (built.ok() || built.error().kind != ErrorKind::gpu) return built;
        told_("frame " + std::to_string(raw.number) + ": " + built.error().message + "; the " +
              std::string(second_->name()) + " builder goes on");
        first_.reset();  // frames it built keep what they need
        return second_->build(raw, out);
    }

private:
    std::unique_ptr<SurfaceBuilder> first_, second_;
    std::function<void(const std::string&)> told_;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> make_fallback_builder(std::unique_ptr<SurfaceBuilder> first,
                                                      std::unique_ptr<SurfaceBuilder> second,
                                                      std::function<void(const std::string&)> told) {
    return std::make_unique<FallbackBuilder>(std::move(first), std::move(second), std::move(told));
}

}  // namespace touchable
