// SPDX-License-Identifier: Apache-2.0
// Input from a file instead of a person: the same events take the same way. docs/viewer.md lists
// the commands.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "events.h"
#include "widgets.h"

namespace ovoid::viewer {

// What a script asks the program.
class ScriptHost {
 public:
  virtual ~ScriptHost() = default;
  virtual std::optional<Box2> find(const std::string& name) const = 0;
  virtual bool scroll_to(const std::string& name) = 0;
  // "loaded": data are open or have failed to; "full": and the full picture is shown; "idle": and
  // nothing else is worked on.
  virtual bool has_come_to(const std::string& state) const = 0;
  // What is known by that name; throws Error(kInvalidArgument) for what is not.
  virtual std::string value_of(const std::string& key) const = 0;
  virtual void save_screenshot(const std::string& path) = 0;
  virtual void save_picture(const std::string& path) = 0;
  virtual void save_state(const std::string& path) = 0;
  virtual void resize(int width, int height) = 0;
  virtual void begin_measure(const std::string& name) = 0;
};

class Script {
 public:
  // Reads and checks the whole file. Throws Error(kFileNotFound, kFileFormat) that names file and
  // line.
  explicit Script(const std::string& path);

  // The events of the next frame. Throws Error(kInvalidArgument), naming file and line, for what is
  // not there, is not as expected, or does not come within a minute.
  std::vector<Event> next_frame(ScriptHost& host);
  // While something is waited for, frames of nothing new would only take time from it.
  double seconds_per_frame() const noexcept {
    return awaited_.empty() ? seconds_per_frame_ : std::max(seconds_per_frame_, kUsualFrame);
  }
  bool is_over() const noexcept {
    const bool waits = !awaited_.empty() || until_ms_ > 0 || frames_to_wait_ > 0;
    return at_ >= lines_.size() && frames_.empty() && !waits;
  }

 private:
  struct Line {
    int number = 0;
    std::vector<std::string> words;
  };
  struct Loop {
    std::size_t first;
    long left;
  };
  using Frame = std::vector<Event>;
  static constexpr double kUsualFrame = 1.0 / 60;  // seconds

  [[noreturn]] void fail(const std::string& what) const;
  template <typename Question>
  auto asked(const Question& question) const;
  void check(const Line& line, int* depth) const;
  void begin(const Line& line, ScriptHost& host);  // turns it into frames, or acts at once
  bool begin_input(const Line& line, ScriptHost& host);
  void ask_host(const Line& line, ScriptHost& host);
  bool waits(ScriptHost& host);
  void move_to(double x, double y);
  void press(int button, bool is_down);
  std::optional<ImVec2> place_of(const std::string& target, ScriptHost& host);
  void press_key(const std::string& chord);
  void drag(const Line& line, ImVec2 from);
  void expect(const Line& line, const ScriptHost& host) const;

  std::string path_;
  std::vector<Line> lines_;
  std::size_t at_ = 0;
  std::vector<Loop> loops_;
  std::vector<Frame> frames_;  // to come, the next one first
  double seconds_per_frame_ = kUsualFrame;
  // What is waited for.
  std::string awaited_;
  double until_ms_ = 0, since_ms_ = -1;
  int frames_to_wait_ = 0;
  int searches_ = 0;  // frames in which a target was scrolled to
};

// The other way round: what a person does, as a script.
class Recorder {
 public:
  explicit Recorder(std::string path) : path_(std::move(path)) {}
  void take(const std::vector<Event>& events, double at_ms);
  void begin(int width, int height);
  void write() const;  // throws Error(kFileWrite)

 private:
  std::string path_;
  std::string text_;
  double last_ms_ = 0;
};

// GLFW's number of a key by its name ("r", "ctrl", "left", "?"), and back; -1 and "" for
// none.
int key_by_name(const std::string& name);
std::string name_of_key(int key);

}  // namespace ovoid::viewer
