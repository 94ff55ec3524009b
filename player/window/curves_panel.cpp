#include "player/window/curves_panel.hpp"

#include <imgui.h>

#include <algorithm>

#include "engine/base/number_words.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/window/panel_rows.hpp"

namespace touchable {
namespace {

constexpr float curve_height = 30;

struct DrawnCurve {
    const Curve& curve;
    ImU32 colour;
};

/// Lines over each other from 0 to `most`, or a bar for each value; the newest value in words on the right.
void draw_curves(const char* label, std::initializer_list<DrawnCurve> curves, float most, bool bars,
                 const char* words, float scale) {
    const float tall = curve_height * scale, down = (tall - ImGui::GetFrameHeight()) / 2;
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + down);
    draw_label(label, scale);
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - down);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float wide = value_column(scale);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(at, ImVec2(at.x + wide, at.y + tall), ImGui::GetColorU32(ImGuiCol_FrameBg), 4 * scale);
    std::array<ImVec2, Curve::most> points;
    for (const DrawnCurve& drawn : curves) {
        for (std::size_t k = 0; k < Curve::most; ++k) {
            const float share = std::clamp(drawn.curve[k] / most, 0.0F, 1.0F);
            points[k] = ImVec2(at.x + wide * (static_cast<float>(k) + 0.5F) / Curve::most,
                               at.y + tall - 1 - share * (tall - 3));
        }
        if (!bars) {
            list.AddPolyline(points.data(), static_cast<int>(points.size()), drawn.colour, 0, 1.5F * scale);
            continue;
        }
        for (std::size_t k = 0; k < Curve::most; ++k)
            if (drawn.curve[k] > 0)
                list.AddLine(ImVec2(points[k].x, at.y + tall - 1), points[k], drawn.colour, 2 * scale);
    }
    ImGui::Dummy(ImVec2(wide, tall));
    draw_value(words, at.x + wide, at.y + (tall - ImGui::GetFontSize()) / 2);
}

}  // namespace

float Curve::greatest() const {
    return *std::max_element(values_.begin(), values_.end());
}

void CurvesPanel::remember(const CurveValues& values) {
    fingers_ = std::min(values.forces.size(), forces_.size());
    for (std::size_t k = 0; k < forces_.size(); ++k)
        forces_[k].add(k < values.forces.size() ? values.forces[k] : 0);
    picture_ms_.add(values.picture_ms);
    tick_us_.add(values.tick_us);
    // Another session counts from 0 again.
    late_ticks_.add(static_cast<double>(std::max<std::int64_t>(values.late_ticks - all_late_, 0)));
    dropped_frames_.add(static_cast<double>(std::max<std::int64_t>(values.dropped_frames - all_dropped_, 0)));
    all_late_ = values.late_ticks;
    all_dropped_ = values.dropped_frames;
}

void CurvesPanel::draw(double most_newtons, float scale) {
    const ImU32 usual = ImGui::GetColorU32(ImGuiCol_PlotLines);
    const ImU32 bad = IM_COL32(240, 150, 90, 255);
    const auto colour = [](std::size_t finger) { return readable_finger_colour(finger); };
    float newtons = 0;
    for (const Curve& curve : forces_) newtons = std::max(newtons, curve.newest());
    draw_curves("force",
                {{forces_[4], colour(4)},
                 {forces_[3], colour(3)},
                 {forces_[2], colour(2)},
                 {forces_[1], colour(1)},
                 {forces_[0], colour(0)}},
                static_cast<float>(most_newtons), false,
                formatted("%.1f N", static_cast<double>(newtons)).c_str(), scale);
    explain_row("Newtons on each finger, in its colour.");
    draw_curves("picture", {{picture_ms_, usual}}, std::max(50.0F, picture_ms_.greatest()), false,
                formatted("%.0f ms", static_cast<double>(picture_ms_.newest())).c_str(), scale);
    explain_row("How long a picture takes to draw. At 33 ms there are 30 a second.");
    draw_curves("tick", {{tick_us_, usual}}, std::max(50.0F, tick_us_.greatest()), false,
                formatted("%.0f \xC2\xB5s", static_cast<double>(tick_us_.newest())).c_str(), scale);
    explain_row(
        "How long a force takes to compute. There are 1000 a second: below 1000 \xC2\xB5s all is well.");
    draw_curves("late ticks", {{late_ticks_, bad}}, std::max(2.0F, late_ticks_.greatest()), true,
                formatted("%lld", static_cast<long long>(all_late_)).c_str(), scale);
    explain_row("Forces that came a millisecond or more too late.");
    draw_curves("left out", {{dropped_frames_, bad}}, std::max(2.0F, dropped_frames_.greatest()), true,
                formatted("%lld", static_cast<long long>(all_dropped_)).c_str(), scale);
    explain_row("Frames of the clip that this machine had no time for.");
}

}  // namespace touchable
