#include "player/panel/imgui_layer.hpp"

#include <imgui.h>

#include <set>
#include <utility>

#include "player/panel/theme.hpp"

namespace touchable {
namespace {

/// The keys that a text field or a slider knows, as ImGui 1.86 numbers what it is told.
int number_of_key(const std::string& name) {
    constexpr const char* names[] = {"tab",  "left", "right",  "up",        "down",  "pageup", "pagedown",
                                     "home", "end",  "delete", "backspace", "enter", "escape"};
    for (std::size_t k = 0; k < std::size(names); ++k)
        if (name == names[k]) return static_cast<int>(k);
    return -1;
}

void map_keys(ImGuiIO& io) {
    constexpr ImGuiKey keys[] = {
        ImGuiKey_Tab,       ImGuiKey_LeftArrow, ImGuiKey_RightArrow, ImGuiKey_UpArrow, ImGuiKey_DownArrow,
        ImGuiKey_PageUp,    ImGuiKey_PageDown,  ImGuiKey_Home,       ImGuiKey_End,     ImGuiKey_Delete,
        ImGuiKey_Backspace, ImGuiKey_Enter,     ImGuiKey_Escape};
    for (int k = 0; k < static_cast<int>(std::size(keys)); ++k) io.KeyMap[keys[k]] = k;
}

int button_of(const std::string& word) {
    return word == "left" ? 0 : (word == "right" ? 1 : 2);
}

void tell(ImGuiIO& io, const InputEvent& event) {
    using Kind = InputEvent::Kind;
    switch (event.kind) {
        case Kind::moved:
            io.MousePos = ImVec2(static_cast<float>(event.x), static_cast<float>(event.y));
            break;
        case Kind::left_window:
            io.MousePos = ImVec2(-FLT_MAX, -FLT_MAX);
            break;
        case Kind::pressed:
        case Kind::released:
            io.MouseDown[button_of(event.word)] = event.kind == Kind::pressed;
            break;
        case Kind::wheel:
            io.MouseWheel += static_cast<float>(event.y);
            break;
        case Kind::key:
        case Kind::key_released:
            if (const int key = number_of_key(event.word); key >= 0)
                io.KeysDown[key] = event.kind == Kind::key;
            io.KeyCtrl = event.control;
            io.KeyShift = event.shift;
            break;
        case Kind::resized:
        case Kind::dropped:
        case Kind::close:
            break;
    }
}

}  // namespace

ImGuiLayer::ImGuiLayer(double scale) : context_(ImGui::CreateContext()) {
    ImGui::SetCurrentContext(context_);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.LogFilename = nullptr;
    map_keys(io);
    apply_theme(scale);
}

ImGuiLayer::~ImGuiLayer() {
    ImGui::DestroyContext(context_);
}

void ImGuiLayer::begin(int width, int height, double seconds, std::span<const InputEvent> events) {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = ImVec2(static_cast<float>(width), static_cast<float>(height));
    io.DeltaTime = static_cast<float>(seconds > 1e-4 ? seconds : 1e-4);
    // ImGui sees what a button is when a picture begins: of a short click each half gets a picture.
    std::vector<InputEvent> now = std::exchange(later_, {});
    now.insert(now.end(), events.begin(), events.end());
    std::set<std::string> pressed;
    for (const InputEvent& event : now) {
        const bool is_let_go = event.kind == InputEvent::Kind::released && pressed.contains(event.word);
        if (is_let_go || !later_.empty()) {
            later_.push_back(event);
            continue;
        }
        if (event.kind == InputEvent::Kind::pressed) pressed.insert(event.word);
        tell(io, event);
    }
    // Words have a size even where nobody draws them.
    if (!io.Fonts->IsBuilt()) io.Fonts->Build();
    ImGui::NewFrame();
}

void ImGuiLayer::end() {
    ImGui::Render();
}

bool ImGuiLayer::holds_pointer() const {
    return ImGui::IsAnyItemActive();
}

}  // namespace touchable
