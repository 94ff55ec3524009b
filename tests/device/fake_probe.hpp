#pragma once

#include <functional>
#include <optional>

#include "device/hand.hpp"

namespace touchable {

/// A pinhole picture of whatever depth a test gives each pixel.
class FakeProbe final : public SurfaceProbe {
public:
    using Depth = std::function<std::optional<double>(double x, double y)>;

    FakeProbe(int width, int height, double focal_length, Depth depth)
        : width_(width), height_(height), focal_length_(focal_length), depth_(std::move(depth)) {}

    int width() const override { return width_; }
    int height() const override { return height_; }
    std::optional<double> depth_under(double x, double y) const override {
        if (!(x >= 0 && y >= 0 && x <= width_ - 1 && y <= height_ - 1)) return std::nullopt;
        return depth_(x, y);
    }
    glm::dvec3 unproject(double x, double y, double d) const override {
        return {d * (x - 0.5 * width_) / focal_length_, -d * (y - 0.5 * height_) / focal_length_, -d};
    }
    glm::dvec3 project(const glm::dvec3& p) const override {
        return {0.5 * width_ + focal_length_ * p.x / -p.z, 0.5 * height_ - focal_length_ * p.y / -p.z, -p.z};
    }

private:
    int width_, height_;
    double focal_length_;
    Depth depth_;
};

/// A picture of 640 x 480 pixels in millimetres, about what a depth camera gives.
inline FakeProbe camera_view(FakeProbe::Depth depth) {
    return {640, 480, 500, std::move(depth)};
}

inline FakeProbe flat_view(double depth = 800) {
    return camera_view([depth](double, double) { return depth; });
}

}  // namespace touchable
