// SPDX-License-Identifier: Apache-2.0
// Measures what a person feels: how soon, how often, how late.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace ovoid::viewer {

// Milliseconds since the process was started (by whatever started it), where the system tells; else
// since the first call.
double ms_since_start();

class Meter {
 public:
  Meter();
  void begin(const std::string& name);  // a section of its own

  void interface_frame(double ms);  // from the end of the wait for input until the frame was shown
  void changed(std::uint64_t version);  // something was done that the picture must follow
  void picture_shown(std::uint64_t version, bool is_moving, bool is_final, double picture_ms);
  void moving(bool is_moving);         // every frame
  void cancelled(double ms);           // a picture that was given up had stopped
  void first_frame();                  // the window is up
  double pictures_per_second() const;  // of the last second while moving
  double interface_ms() const;         // the last one

  nlohmann::ordered_json report() const;

 private:
  struct Change {
    std::uint64_t version;
    double at_ms;
  };
  struct Section {
    std::string name;
    std::vector<double> interface_ms, latency_ms, picture_ms, gap_ms, settle_ms, cancel_ms;
    double moving_ms = 0;
    std::int64_t pictures_moving = 0, pictures = 0;
  };
  Section& now() { return sections_.back(); }

  std::vector<Section> sections_;
  std::deque<Change> waiting_;
  std::deque<double> recent_;  // when pictures were shown
  bool is_moving_ = false;
  double moving_since_ms_ = 0;
  double last_picture_ms_ = 0;
  double released_ms_ = -1;
  double window_ms_ = -1, first_picture_ms_ = -1, first_full_ms_ = -1;
  double last_interface_ms_ = 0;
};

}  // namespace ovoid::viewer
