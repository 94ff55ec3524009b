#include "player/window/window_panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "player/view/colour_ramp.hpp"
#include "player/view/finger_marks.hpp"
#include "player/window/invitation.hpp"
#include "player/window/panel_rows.hpp"

namespace touchable {
namespace {

constexpr ImGuiWindowFlags fixed_window = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                          ImGuiWindowFlags_NoSavedSettings |
                                          ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;
constexpr float margin = 12, bar_height = 48;

template <class... Values>
std::string in_words(const char* format, Values... values) {
    char words[160];
    std::snprintf(words, sizeof words, format, values...);
    return words;
}

std::string clock_words(double seconds) {
    const auto tenths = static_cast<long>(std::floor(std::max(seconds, 0.0) * 10 + 0.5));
    return in_words("%ld:%02ld.%ld", tenths / 600, tenths / 10 % 60, tenths % 10);
}

ImU32 colour_of_finger(std::size_t finger) {
    return finger_colour(finger) | 0xFF000000U;
}

/// Play or pause, drawn: no typeface is sure to have the signs.
bool play_button(bool playing, float side) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const bool pressed = ImGui::Button("##play", ImVec2(side, side));
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text);
    const float u = side / 10;
    if (playing) {
        list.AddRectFilled(ImVec2(at.x + 3 * u, at.y + 2.7F * u), ImVec2(at.x + 4.4F * u, at.y + 7.3F * u),
                           ink);
        list.AddRectFilled(ImVec2(at.x + 5.6F * u, at.y + 2.7F * u), ImVec2(at.x + 7 * u, at.y + 7.3F * u),
                           ink);
    } else {
        list.AddTriangleFilled(ImVec2(at.x + 3.5F * u, at.y + 2.5F * u),
                               ImVec2(at.x + 7.5F * u, at.y + 5 * u),
                               ImVec2(at.x + 3.5F * u, at.y + 7.5F * u), ink);
    }
    return pressed;
}

/// A key's name as keyboards print it.
std::string printed(std::string key) {
    if (key[0] >= 'a' && key[0] <= 'z') key[0] = static_cast<char>(key[0] - 'a' + 'A');
    return key;
}

/// Of the bar below, for all that there is to press.
bool has_room(float width, float scale) {
    return width > 760 * scale;
}

bool begin_fixed(const char* name, ImVec2 at, ImVec2 pivot, ImVec2 size, ImGuiWindowFlags more = 0) {
    ImGui::SetNextWindowPos(at, ImGuiCond_Always, pivot);
    if (size.x > 0 || size.y > 0) ImGui::SetNextWindowSize(size, ImGuiCond_Always);
    const bool fits = size.x > 0 && size.y > 0;
    return ImGui::Begin(name, nullptr, fixed_window | more | (fits ? 0 : ImGuiWindowFlags_AlwaysAutoResize));
}

}  // namespace

void WindowPanel::note_box() {
    const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    boxes_.push_back({at.x, at.y, at.x + size.x, at.y + size.y});
}

bool WindowPanel::covers(double x, double y) const {
    return std::any_of(boxes_.begin(), boxes_.end(), [x, y](const Box& box) {
        return x >= static_cast<double>(box.x0) && x < static_cast<double>(box.x1) &&
               y >= static_cast<double>(box.y0) && y < static_cast<double>(box.y1);
    });
}

void WindowPanel::remember(const PanelFacts& facts, double frame_ms, double tick_us) {
    force_.add(facts.forces.empty() ? 0 : *std::max_element(facts.forces.begin(), facts.forces.end()));
    frame_ms_.add(frame_ms);
    tick_us_.add(tick_us);
}

void WindowPanel::draw(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked) {
    const auto w = static_cast<float>(width), h = static_cast<float>(height);
    boxes_.clear();
    if (facts.invited_s) draw_invitation(*facts.invited_s, w, h);
    if (facts.is_kiosk) {
        draw_force(facts, h);
        if (facts.scale) draw_scale(*facts.scale, w, h);
        return;
    }
    draw_playback(facts, w, h, asked);
    if (!help_shown || facts.message_is_bad) draw_message(facts, w);
    if (help_shown) return draw_help(w, h);  // which needs the room
    draw_force(facts, h);
    draw_place(facts, h);
    if (facts.scale && (!shown || has_room(w, scale_))) draw_scale(*facts.scale, w, h);
    if (shown) draw_side(facts, w, h, asked);
}

void WindowPanel::draw_playback(const PanelFacts& facts, float width, float height,
                                std::vector<WindowCommand>& asked) {
    const float m = margin * scale_, side = 30 * scale_;
    begin_fixed("playback", ImVec2(m, height - m), ImVec2(0, 1), ImVec2(width - 2 * m, bar_height * scale_));
    note_box();
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(8 * scale_, (side - ImGui::GetFontSize()) / 2));
    if (play_button(facts.playing && !facts.at_end, side)) asked.push_back({WindowVerb::play_pause});
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    const std::string frame = in_words(" frame %lld", static_cast<long long>(facts.frame));
    ImGui::TextUnformatted(
        (clock_words(facts.seconds) +
         (facts.playing && !facts.at_end ? " / " + clock_words(facts.clip_seconds) : frame))
            .c_str());
    ImGui::SameLine();
    const std::string speed = in_words("%g\xC3\x97", facts.speed);
    const bool roomy = has_room(width, scale_);
    const float right = (roomy ? 286 : 96) * scale_;
    ImGui::SetNextItemWidth(std::max(60 * scale_, ImGui::GetContentRegionAvail().x - right));
    float at = dragging_ ? dragged_seconds_ : static_cast<float>(facts.seconds);
    const auto end = static_cast<float>(std::max(facts.clip_seconds, 0.001));
    if (ImGui::SliderFloat("##seek", &at, 0, end, "", ImGuiSliderFlags_NoInput)) {
        dragged_seconds_ = at;
        asked.push_back({WindowVerb::seek_to, static_cast<double>(std::clamp(at, 0.0F, end))});
    }
    dragging_ = ImGui::IsItemActive();
    ImGui::SameLine();
    if (ImGui::Button((speed + "##speed").c_str(), ImVec2(46 * scale_, 0)))
        asked.push_back({WindowVerb::speed, facts.speed >= 4 ? 0.25 : facts.speed * 2});
    ImGui::SameLine();
    if (roomy) {
        ImGui::PushStyleColor(ImGuiCol_Text,
                              ImGui::GetStyle().Colors[facts.looping ? ImGuiCol_SliderGrab : ImGuiCol_Text]);
        if (ImGui::Button("loop")) asked.push_back({WindowVerb::loop});
        ImGui::PopStyleColor();
        ImGui::SameLine();
        if (ImGui::Button((facts.overlay + "##overlay").c_str(), ImVec2(132 * scale_, 0)))
            asked.push_back({WindowVerb::overlay});
        ImGui::SameLine();
    }
    if (ImGui::Button("?", ImVec2(side, 0))) asked.push_back({WindowVerb::help});
    ImGui::PopStyleVar();
    ImGui::End();
}

/// A bar for each finger, as high as its force.
void WindowPanel::draw_force(const PanelFacts& facts, float height) {
    const float m = margin * scale_;
    const float bar = 12 * scale_, gap = 6 * scale_, tall = std::min(150 * scale_, height * 0.3F);
    begin_fixed("force", ImVec2(m, m), ImVec2(0, 0), ImVec2(0, 0), ImGuiWindowFlags_NoInputs);
    double most = 0;
    for (const double force : facts.forces) most = std::max(most, force);
    if (facts.force_on)
        ImGui::TextUnformatted(in_words("%.1f N", most).c_str());
    else
        ImGui::TextColored(ImVec4(0.95F, 0.65F, 0.35F, 1), "force off");
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    for (std::size_t k = 0; k < facts.forces.size(); ++k) {
        const float x = at.x + static_cast<float>(k) * (bar + gap);
        const auto share = static_cast<float>(std::clamp(facts.forces[k] / facts.most_newtons, 0.0, 1.0));
        list.AddRectFilled(ImVec2(x, at.y), ImVec2(x + bar, at.y + tall), IM_COL32(255, 255, 255, 28),
                           bar / 3);
        if (share > 0.005F)
            list.AddRectFilled(ImVec2(x, at.y + tall * (1 - share)), ImVec2(x + bar, at.y + tall),
                               colour_of_finger(k), bar / 3);
    }
    const auto fingers = static_cast<float>(std::max<std::size_t>(facts.forces.size(), 1));
    ImGui::Dummy(ImVec2(std::max(56 * scale_, fingers * (bar + gap)), tall));
    ImGui::TextDisabled("%g N", facts.most_newtons);
    ImGui::End();
}

void WindowPanel::draw_place(const PanelFacts& facts, float height) {
    if (facts.place.lines.empty()) return;
    const float m = margin * scale_;
    begin_fixed("place", ImVec2(m, height - 2 * m - bar_height * scale_), ImVec2(0, 1), ImVec2(0, 0),
                ImGuiWindowFlags_NoInputs);
    for (const std::string& line : facts.place.lines) ImGui::TextUnformatted(line.c_str());
    ImGui::End();
}

/// What the finger and the clip do now. `roomy`: the bar below has room for the rest of it.
void WindowPanel::draw_finger(const PanelFacts& facts, bool roomy, std::vector<WindowCommand>& asked) {
    draw_label("fingers", scale_);
    const std::vector<const char*> counts{"1", "2", "3", "4", "5"};
    const int count = draw_words("fingers", counts, static_cast<int>(facts.forces.size()) - 1, true);
    if (count >= 0) asked.push_back({WindowVerb::fingers, static_cast<double>(count + 1)});
    draw_label("pressed in", scale_);
    auto depth = static_cast<float>(facts.pressed_mm);
    if (draw_slider("##depth", depth, -6, 12, in_words("%.1f mm", facts.pressed_mm), scale_))
        asked.push_back({WindowVerb::deeper, static_cast<double>(depth) - facts.pressed_mm});
    draw_label("speed", scale_);
    auto speed = static_cast<float>(facts.speed);
    if (draw_slider("##rate", speed, 0.1F, 4, in_words("%.2f\xC3\x97", facts.speed), scale_,
                    ImGuiSliderFlags_Logarithmic))
        asked.push_back({WindowVerb::speed, static_cast<double>(speed)});
    if (!roomy) {
        draw_label("colours", scale_);
        if (ImGui::Button((facts.overlay + "##colours").c_str(), ImVec2(-1, 0)))
            asked.push_back({WindowVerb::overlay});
    }
    const float half = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    if (ImGui::Button(facts.force_on ? "force off" : "force on", ImVec2(half, 0)))
        asked.push_back({WindowVerb::force});
    ImGui::SameLine();
    if (ImGui::Button("clip's own view", ImVec2(-1, 0))) asked.push_back({WindowVerb::home});
}

/// How the machine keeps up.
void WindowPanel::draw_curves(const PanelFacts& facts) {
    const struct {
        const char* name;
        const Curve& curve;
        float most;
    } curves[] = {{"force, N", force_, static_cast<float>(facts.most_newtons)},
                  {"picture, ms", frame_ms_, 50},
                  {"tick, \xC2\xB5s", tick_us_, 50}};
    for (const auto& [name, curve, most] : curves) {
        draw_label(name, scale_);
        ImGui::PlotLines((std::string("##") + name).c_str(), curve.values().data(),
                         static_cast<int>(curve.values().size()), curve.begin(), nullptr, 0, most,
                         ImVec2(ImGui::GetContentRegionAvail().x, 26 * scale_));
    }
    for (const std::string& line : facts.figures) draw_remark(line);
}

void WindowPanel::draw_side(const PanelFacts& facts, float width, float height,
                            std::vector<WindowCommand>& asked) {
    const float m = margin * scale_, wide = side_width(width);
    ImGui::SetNextWindowPos(ImVec2(width - m, m), ImGuiCond_Always, ImVec2(1, 0));
    ImGui::SetNextWindowSize(ImVec2(wide, height - 3 * m - bar_height * scale_));
    // What does not fit is scrolled to.
    ImGui::Begin("panel", nullptr, fixed_window & ~ImGuiWindowFlags_NoScrollbar);
    note_box();
    const ImGuiStyle& style = ImGui::GetStyle();
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(style.FramePadding.x, 2 * scale_));
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(style.ItemSpacing.x, 4 * scale_));
    const float reset_width = 56 * scale_, room = ImGui::GetContentRegionAvail().x - reset_width;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::PushClipRect(at, ImVec2(at.x + room - style.ItemSpacing.x, at.y + ImGui::GetFrameHeight()), true);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(facts.clip.c_str());
    ImGui::PopClipRect();
    ImGui::SameLine(style.WindowPadding.x + room);
    if (ImGui::Button("reset", ImVec2(-1, 0))) asked.push_back({WindowVerb::reset});
    draw_finger(facts, has_room(width, scale_), asked);
    draw_heading("What is felt");
    felt_.draw(facts.felt, asked);
    draw_heading("How it goes");
    draw_curves(facts);
    ImGui::PopStyleVar(2);
    ImGui::End();
}

void WindowPanel::draw_help(float width, float height) {
    begin_fixed("help", ImVec2(width / 2, height / 2 - bar_height * scale_ / 2), ImVec2(0.5F, 0.5F),
                ImVec2(0, 0), ImGuiWindowFlags_NoInputs);
    // All of it also in a small window.
    ImGui::SetWindowFontScale(std::clamp(height / (540 * scale_), 0.6F, 1.0F));
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, ImVec2(6 * scale_, 1 * scale_));
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        const auto row = [](const std::string& key, const char* what) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            ImGui::TextColored(ImGui::GetStyle().Colors[ImGuiCol_SliderGrab], "%s", key.c_str());
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(what);
        };
        row("Mouse", "moves the finger; hold the left button to press");
        row("Wheel", "presses deeper or less; so does dragging with the right button");
        row("Middle button", "drag: turn; with Shift: move; double click: look at that place");
        const auto keys = key_bindings();
        for (std::size_t k = 0; k < keys.size();) {
            std::string names;
            const char* const what = keys[k].what;
            do {
                const std::string name = (keys[k].shift ? "Shift " : "") + printed(keys[k].key);
                names += (names.empty() ? "" : "  ") + name;
                ++k;
            } while (k < keys.size() && !keys[k].what);
            row(names, what);
        }
        ImGui::EndTable();
    }
    ImGui::PopStyleVar();
    ImGui::End();
}

/// What the surface's colours mean: a ramp with its ends, or a list.
void WindowPanel::draw_scale(const OverlayScale& scale, float width, float height) {
    const float m = margin * scale_, wide = 200 * scale_, tall = 12 * scale_;
    const float right = shown ? side_width(width) + 2 * m : m;
    begin_fixed("scale", ImVec2(width - right, height - 2 * m - bar_height * scale_), ImVec2(1, 1),
                ImVec2(0, 0), ImGuiWindowFlags_NoInputs);
    ImGui::TextUnformatted((scale.name + (scale.unit.empty() ? "" : ", " + scale.unit)).c_str());
    ImDrawList& list = *ImGui::GetWindowDrawList();
    for (const OverlayScale::Class& named : scale.classes) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const float side = ImGui::GetFontSize();
        list.AddRectFilled(at, ImVec2(at.x + side, at.y + side), named.colour, 3 * scale_);
        ImGui::Dummy(ImVec2(side, side));
        ImGui::SameLine();
        ImGui::TextUnformatted(named.words.c_str());
    }
    if (scale.classes.empty()) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        constexpr int steps = 50;
        for (int k = 0; k < steps; ++k) {
            const double share = (k + 0.5) / steps;
            list.AddRectFilled(ImVec2(at.x + wide * static_cast<float>(k) / steps, at.y),
                               ImVec2(at.x + wide * static_cast<float>(k + 1) / steps, at.y + tall),
                               ramp_colour(scale.least_is_light ? 1 - share : share));
        }
        ImGui::Dummy(ImVec2(wide, tall));
        const std::string least = in_words("%.4g", scale.range.least),
                          most = in_words("%.4g", scale.range.greatest);
        ImGui::TextDisabled("%s", least.c_str());
        ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + wide - ImGui::CalcTextSize(most.c_str()).x);
        ImGui::TextDisabled("%s", most.c_str());
    }
    ImGui::End();
}

/// Above the middle of what the panel leaves free.
void WindowPanel::draw_message(const PanelFacts& facts, float width) {
    if (facts.message.empty()) return;
    const float m = margin * scale_, from = shown ? 104 * scale_ : 0.0F;
    const float to = shown ? width - side_width(width) - 2 * m : width;
    begin_fixed("message", ImVec2((from + to) / 2, m), ImVec2(0.5F, 0), ImVec2(0, 0),
                ImGuiWindowFlags_NoInputs);
    ImGui::PushTextWrapPos(shown ? to - from - m : width * 0.6F);
    const ImVec4 bad(1.0F, 0.62F, 0.45F, 1);
    ImGui::TextColored(facts.message_is_bad ? bad : ImGui::GetStyle().Colors[ImGuiCol_Text], "%s",
                       facts.message.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

float WindowPanel::side_width(float width) const {
    return std::min(310 * scale_, width * 0.5F);
}

}  // namespace touchable
