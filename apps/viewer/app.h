// SPDX-License-Identifier: Apache-2.0
// The program: window, data, pictures and panels, once around for every frame.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "document.h"
#include "file_dialog.h"
#include "fitter.h"
#include "gui.h"
#include "loader.h"
#include "memory.h"
#include "meter.h"
#include "panels.h"
#include "picture_view.h"
#include "script.h"
#include "widgets.h"
#include "window.h"
#include "worker.h"

namespace ovoid::viewer {

inline constexpr int kPanelWidth = 340;  // units, before the interface's scale

bool is_look_file(const std::string& path);  // by its name

double now_s();  // seconds of the steady clock

class App final : public ScriptHost {
 public:
  // Opens the window. Throws what Window throws, and Error of a script that cannot be read.
  explicit App(std::shared_ptr<const Launch> launch);
  ~App() override;

  // Until the window is closed, the script is over, or `stop` is triggered. Throws Error if the
  // script fails.
  void run(const std::stop_token& stop);

  // ScriptHost
  std::optional<Box2> find(const std::string& name) const override;
  bool scroll_to(const std::string& name) override;
  bool has_come_to(const std::string& state) const override;
  std::string value_of(const std::string& key) const override;
  void save_screenshot(const std::string& path) override;
  void save_picture(const std::string& path) override;
  void save_state(const std::string& path) override;
  void resize(int width, int height) override;
  void begin_measure(const std::string& name) override;

 private:
  struct Message {
    std::string text;
    bool is_error = false;
    double until = 0;  // seconds of the steady clock
  };

  void frame(const std::vector<Event>& events, double seconds);
  void take_changes(bool is_held);
  double patience() const;  // seconds to wait for events
  // Input.
  void take_shortcuts(const std::vector<Event>& events);
  bool take_key(const KeyChanged& key);
  bool take_plain_key(int key, bool is_shifted);
  void take_dialog();
  void browse(Browsing what);
  void take_drop(const std::vector<std::string>& paths);
  void open_files(const std::vector<std::string>& paths);
  // Data.
  void take_load_reports();
  void grant(Wishes wishes);
  void open(const std::vector<std::string>& words);
  void remember(const cli::DataFlags& data);
  void grant_solid(const Wishes& wishes);
  void ask_for_solid();
  void grant_fit(const Wishes& wishes);
  void take_fit();
  void save_fit(const std::string& path);
  // Whether they are taken for what may stand beside the data.
  bool take_drop_beside(const std::vector<std::string>& paths);
  void read_beside(BesideTask task);
  void renew_beside(const std::vector<std::string>& files);
  void take_beside(const BesideRead& read);
  void ask_for_surfaces();
  std::vector<std::string> files_beside() const;
  void read_look_file(const std::string& path);
  void read_state_file(const std::string& path);
  void go_to_time();
  void play();
  void watch();
  void watch_files();  // those that are shown
  // Pictures.
  void ask_for_picture(bool is_moving);
  void take_pictures();
  double aspect() const;
  Size picture_size() const;
  Size drawn_size() const;  // of what is asked for: without the colour bars beside it
  Size to_pixels(double width, double height) const;
  // What is drawn.
  void draw_panel(Panel& panel, ImVec2 at, ImVec2 size);
  void draw_status(ImVec2 at, ImVec2 size);
  void draw_transport(Panel& panel, ImVec2 at, ImVec2 size);
  void draw_help();
  void write_screenshot();
  nlohmann::ordered_json facts() const;  // what scripts may ask for
  nlohmann::ordered_json facts_of_fit() const;
  nlohmann::ordered_json facts_of_scene() const;
  nlohmann::ordered_json facts_of_labels() const;
  nlohmann::ordered_json facts_of_several() const;
  nlohmann::ordered_json facts_of_solid() const;
  void tell(const std::string& text, bool is_error = false);
  void save_the_picture(const std::string& path);

  std::shared_ptr<const Launch> launch_;
  Memory memory_;
  FileDialog dialog_;
  Browsing browsing_ = Browsing::kNothing;  // what the dialog that is shown was asked for
  Theme theme_;
  Window window_;
  Gui gui_;
  Meter meter_;
  Widgets widgets_;
  Document document_;
  PictureView picture_view_;
  PanelState panel_state_;
  Status status_;
  std::deque<Message> messages_;
  std::optional<LoadProgress> progress_;
  std::string load_error_;
  std::optional<Script> script_;
  std::optional<Recorder> recorder_;

  bool is_open_ = true;
  bool has_panel_ = true;
  bool is_over_ = false;  // the script
  bool has_chosen_tab_ = false;
  bool is_scene_shown_ = false;  // its tab
  bool shows_help_ = false;
  bool is_moving_ = false;
  bool has_told_of_memory_ = false;
  bool was_edited_ = false;  // since the view was remembered
  std::uint64_t last_version_ = 0, last_view_version_ = 0;
  std::uint64_t asked_version_ = 0;
  bool asked_moving_ = false;
  Size asked_size_;
  std::shared_ptr<const Shown> asked_shown_;
  bool awaits_surfaces_ = false;            // made otherwise: they were asked for
  std::optional<SolidChoice> asked_solid_;  // on its way, or there as it is while it moves
  int frames_due_ = 3;                      // to be drawn before the window may rest
  double changed_at_ = 0;                   // seconds; when the version counted up last
  std::uint64_t failed_version_ = ~std::uint64_t{0};  // of which there is no picture
  std::string told_notice_, last_message_;
  std::string screenshot_wish_;
  // Time.
  double played_at_ = 0;    // seconds; when the clock was looked at last
  double played_time_ = 0;  // the data's time by the clock, between steps, too
  bool was_playing_ = false;
  bool waits_for_time_ = false;     // a step was asked for and is not shown yet
  std::uint64_t time_version_ = 0;  // the document's, since when it has that step
  // Watched files.
  using Watched = std::vector<std::pair<std::string, std::filesystem::file_time_type>>;
  Watched watched_, watched_beside_;
  double watched_at_ = 0;
  std::optional<std::string> picture_wish_;  // saved when the full picture is there
  ImVec2 picture_at_{0, 0}, picture_extent_{1, 1};

  // The last to be made and the first to go: they post to the window.
  std::unique_ptr<Worker> worker_;
  std::unique_ptr<Loader> loader_;
  std::unique_ptr<Fitter> fitter_;
};

}  // namespace ovoid::viewer
