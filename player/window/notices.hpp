#pragma once

#include <algorithm>
#include <deque>
#include <set>
#include <string>
#include <utility>

namespace touchable {

/// How a window says something.
enum class Tone {
    remark,   ///< what was done: goes by itself
    refusal,  ///< what cannot be done, to whoever has just asked for it: goes by itself
    fault     ///< what went wrong: stays until somebody has read it
};

/// What a fault is about: it goes with that.
enum class About { window, clip };

/// What a window has to say to a person. Times are the window's own, seconds, and do not go backward.
class Notices {
public:
    static constexpr double shown_s = 4;           ///< what goes by itself
    static constexpr std::size_t most_faults = 5;  ///< that wait: the newest of more

    void say(std::string words, Tone tone, double now_s, About about = About::window) {
        if (tone != Tone::fault) {
            passing_ = std::move(words);
            is_refusal_ = tone == Tone::refusal;
            said_s_ = now_s;
            return;
        }
        if (std::find(faults_.begin(), faults_.end(), words) != faults_.end()) return;
        if (faults_.size() == most_faults) dismiss();
        if (about == About::clip) of_clip_.insert(words);
        faults_.push_back(std::move(words));
    }
    /// Another clip takes the place of the one that is there: what was said so far goes, but for faults of
    /// the window.
    void leave_clip() {
        clear_passing();
        std::erase_if(faults_, [this](const std::string& fault) { return of_clip_.contains(fault); });
        of_clip_.clear();
    }
    /// What has been there long enough goes.
    void pass(double now_s) {
        if (now_s - said_s_ > shown_s) passing_.clear();
    }
    /// What goes by itself goes now.
    void clear_passing() { passing_.clear(); }
    /// The fault that is shown was read; whether there was one.
    bool dismiss() {
        if (faults_.empty()) return false;
        of_clip_.erase(faults_.front());
        faults_.pop_front();
        return true;
    }

    const std::string& passing() const { return passing_; }  ///< empty: nothing
    bool is_refusal() const { return is_refusal_; }          ///< `passing`
    const std::deque<std::string>& faults() const { return faults_; }

private:
    std::string passing_;
    bool is_refusal_ = false;
    double said_s_ = 0;
    std::deque<std::string> faults_;  // the first one is shown
    std::set<std::string> of_clip_;   // those of them that are about the clip
};

}  // namespace touchable
