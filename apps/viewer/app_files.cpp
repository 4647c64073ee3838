// SPDX-License-Identifier: Apache-2.0
// What is opened, read and written, and what the loader tells of it.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "app.h"
#include "apply_crop.h"
#include "command.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "state_file.h"
#include "usage.h"

namespace ovoid::viewer {
namespace {

constexpr double kWatchEvery = 0.5;    // seconds
constexpr double kWatchSettles = 0.3;  // seconds for which a file must have stayed as it is

std::filesystem::file_time_type time_of(const std::string& path) {
  std::error_code error;
  const auto time = std::filesystem::last_write_time(path, error);
  return error ? std::filesystem::file_time_type() : time;
}

// The start of a file, to tell what it is.
std::string head_of(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return {};  // a pipe would block
  std::ifstream file(path, std::ios::binary);
  std::string head(4096, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

std::string free_name(const std::string& stem, const std::string& ending) {
  for (int i = 1;; ++i) {
    std::string name = fmt::format("{}-{:04}{}", stem, i, ending);
    std::error_code error;
    if (!std::filesystem::exists(name, error)) return name;
  }
}

}  // namespace

bool is_look_file(const std::string& path) {
  return cli::has_ending(path, ".json") || cli::has_ending(path, ".vp") ||
         cli::has_ending(path, ".itf") || cli::has_ending(path, ".xml");
}

void App::take_load_reports() {
  for (LoadReport& report : loader_->take_reports()) {
    frames_due_ = std::max(frames_due_, 2);
    if (auto* progress = std::get_if<LoadProgress>(&report)) {
      progress_ = *progress;
      if (progress->is_opening) document_.notes.clear();
    }
    if (auto* noted = std::get_if<Noted>(&report)) {
      tell(noted->text);
      document_.notes.push_back(noted->text);
    }
    if (auto* opened = std::get_if<Opened>(&report)) {
      const bool is_other = !opened->is_reload;
      document_.take(*opened);
      asked_solid_.reset();
      awaits_surfaces_ = false;
      fitter_->cancel();  // of what was there before
      if (is_other) {
        picture_view_.forget();
        panel_state_ = {};
      }
      load_error_.clear();
      window_.set_title(opened->info->title + " - Ovoid");
      if (is_other) remember(opened->launch->data);
      watched_.clear();
      if (is_other) watched_beside_.clear();
      watch_files();
      if (!is_other) renew_beside(files_beside());
    }
    if (auto* ready = std::get_if<ShownReady>(&report)) {
      try {
        document_.take(*ready, aspect());
      } catch (const Error& error) {  // a camera that cannot be
        tell(cli::message_line(error.what()), true);
      }
      watch_files();
      time_version_ = document_.version();
      if (!was_edited_) last_view_version_ = document_.view_version();  // nobody's edit
      progress_.reset();
    }
    if (auto* extras = std::get_if<std::shared_ptr<const Extras>>(&report)) {
      if ((*extras)->of == document_.shown) document_.extras = std::move(*extras);
    }
    if (auto* counted = std::get_if<Counted2D>(&report)) {
      if (!counted->error.empty()) tell(counted->error, true);
      if (counted->of == document_.shown) document_.counted_2d = std::move(*counted);
    }
    if (const auto* read = std::get_if<BesideRead>(&report)) take_beside(*read);
    if (auto* failed = std::get_if<LoadFailed>(&report)) {
      progress_.reset();
      waits_for_time_ = awaits_surfaces_ = false;
      document_.time.is_playing = false;
      if (failed->was_opening) load_error_ = failed->message;
      if (failed->was_solid) {
        document_.give_up_solid();
        asked_solid_.reset();
      }
      // With nothing open it stands in the middle.
      if (document_.is_open()) tell(failed->message, true);
      last_message_ = failed->message;
    }
  }
}

// A place that cannot be written is no reason to be told so each time.
void App::remember(const cli::DataFlags& data) {
  try {
    memory_.add_recent(recent_input(data));
  } catch (const std::exception& error) {
    if (!std::exchange(has_told_of_memory_, true)) tell(cli::message_line(error.what()), true);
  }
}

void App::browse(Browsing what) {
  if (dialog_.is_shown()) return;
  // Where the file lay that was named last.
  std::string last;
  if (what == Browsing::kLook) last = panel_state_.look_path;
  if (what == Browsing::kState) last = panel_state_.state_path;
  if (what == Browsing::kBeside) last = panel_state_.beside_path;
  if (std::filesystem::path(last).parent_path().empty() && !memory_.recent().empty())
    last = memory_.recent().front().inputs.front();
  std::error_code ignored;
  std::filesystem::path folder = std::filesystem::current_path(ignored);
  if (!last.empty()) folder /= std::filesystem::path(last).parent_path();
  const char* const title = what == Browsing::kLook     ? "Open a look - Ovoid"
                            : what == Browsing::kState  ? "Restore a state - Ovoid"
                            : what == Browsing::kBeside ? "Add to the picture - Ovoid"
                                                        : "Open - Ovoid";
  const bool takes_several = what == Browsing::kInput || what == Browsing::kBeside;
  dialog_.show({title, folder.string(), takes_several});
  browsing_ = what;
}

void App::take_dialog() {
  const auto answer = dialog_.take();
  if (!answer) return;
  frames_due_ = std::max(frames_due_, 2);
  if (!answer->error.empty()) tell(answer->error, true);
  if (answer->paths.empty()) return;
  const std::string& path = answer->paths.front();
  if (browsing_ == Browsing::kLook) {
    panel_state_.look_path = path;
    read_look_file(path);
  } else if (browsing_ == Browsing::kState) {
    panel_state_.state_path = path;
    read_state_file(path);
  } else if (browsing_ == Browsing::kBeside) {
    panel_state_.beside_path = path;
    read_beside({answer->paths, BesideUse::kAdd});
  } else {
    open_files(answer->paths);
  }
}

void App::open(const std::vector<std::string>& words) {
  try {
    std::shared_ptr<Launch> launch = parse_launch(words);
    if (!launch || launch->data.inputs.empty()) return;
    launch->watches = launch_->watches;
    launch->drawing.run = document_.is_open() ? document_.setup : launch_->drawing.run;
    loader_->open(std::move(launch));
  } catch (const std::exception& error) {
    tell(cli::message_line(error.what()), true);
  }
}

void App::take_drop(const std::vector<std::string>& paths) {
  if (!paths.empty() && !take_drop_beside(paths)) open_files(paths);
}

void App::open_files(const std::vector<std::string>& paths) {
  if (paths.size() == 1 && cli::has_ending(paths.front(), ".json")) {
    if (head_of(paths.front()).find("\"ovoid_state\"") != std::string::npos)
      return read_state_file(paths.front());
  }
  if (paths.size() == 1 && is_look_file(paths.front())) return read_look_file(paths.front());
  open(paths);
}

void App::read_look_file(const std::string& path) {
  if (!document_.is_open()) return tell("a look needs data first", true);
  try {
    const Look read = read_look(path);
    Look& look = document_.view.look;
    look.transfer_function = read.transfer_function;
    look.transfer_function_2d = read.transfer_function_2d;
    look.shade = read.shade;
    look.material = read.material;
    look.flat_rise = read.flat_rise;
    const Lighting before = std::exchange(look.lighting(), read.lighting());
    look.light = before.light;  // the view's own, as beside --tf
    look.light_direction = before.light_direction;
    look.unit_distance = read.unit_distance;
    panel_state_.opacity = panel_state_.gradient = panel_state_.colors = {};
    document_.touch();
    tell("look of " + path);
  } catch (const std::exception& error) {
    tell(cli::message_line(error.what()), true);
  }
}

void App::read_state_file(const std::string& path) { open({"--state", path}); }

void App::save_state(const std::string& path) {
  if (!document_.is_open()) return;
  if (document_.view.solid) {
    throw Error(ErrorCode::kUnsupported,
                "a state holds no solid: save its control mesh or its kernels, and open that");
  }
  cli::State state;
  state.inputs = document_.launch->data.inputs;
  state.flags = flags_of(document_, picture_size(), FlagsFor::kState);
  state.window = window_state(document_);
  cli::write_state(state, path);
}

void App::grant(Wishes wishes) {
  try {
    if (!wishes.open.empty()) open_files({wishes.open});
    if (!wishes.add_beside.empty()) read_beside({{wishes.add_beside}, BesideUse::kAdd});
    if (!wishes.add_labels.empty())
      read_beside({{wishes.add_labels}, BesideUse::kAdd, BesideKind::kLabels});
    if (!wishes.read_look.empty()) read_look_file(wishes.read_look);
    if (!wishes.write_look.empty()) {
      write_look(document_.view.look, wishes.write_look);
      tell("look written to " + wishes.write_look);
    }
    if (!wishes.read_state.empty()) read_state_file(wishes.read_state);
    if (!wishes.write_state.empty() && document_.is_open()) {
      save_state(wishes.write_state);
      tell("state written to " + wishes.write_state);
    }
    if (wishes.counts_2d && !document_.time.is_playing) loader_->count_2d(document_.shown);
    grant_fit(wishes);
    grant_solid(wishes);
    if (wishes.copies_command && document_.is_open()) {
      window_.set_clipboard(command_of(document_, picture_size()));
      tell(has_command(document_) ? "the command is in the clipboard" : kNoCommand);
    }
    if (wishes.saves_picture && document_.is_open()) {
      const std::string stem =
          std::filesystem::path(document_.launch->data.inputs.front()).stem().stem().string();
      picture_wish_ = free_name(stem.empty() ? "picture" : stem, ".png");
      if (picture_view_.full(document_) != nullptr)
        save_the_picture(*std::exchange(picture_wish_, std::nullopt));
    }
    if (wishes.browses != Browsing::kNothing) browse(wishes.browses);
    if (wishes.open_recent && *wishes.open_recent < memory_.recent().size())
      open(memory_.recent()[*wishes.open_recent].words());
    if (wishes.forgets_recent) memory_.forget_recent();
    if (wishes.theme) {
      theme_ = *wishes.theme;
      memory_.set_theme(theme_);
    }
    if (wishes.array) {
      progress_ = LoadProgress{"choosing kernels for " + wishes.array->array, 0};
      loader_->choose(*wishes.array);
    }
  } catch (const std::exception& error) {
    tell(cli::message_line(error.what()), true);
  }
  if (wishes.goes_to_time) {
    played_time_ = document_.time.now;
    go_to_time();
  }
}

// As `ovoid render` would write it. Throws Error(kFileWrite).
void App::save_the_picture(const std::string& path) {
  const Picture* const picture = picture_view_.full(document_);
  if (picture == nullptr) return;
  const PictureJob& job = *picture->job;
  Image image = picture->image;
  Look look = job.look();
  const bool is_for_eyes = cli::is_for_eyes(path);
  if (look.mode == Mode::kXray && is_for_eyes) {
    look.transfer_function = spread_over_integrals(look.transfer_function, picture->xray_range);
    cli::color_integrals(image, look.transfer_function);
  }
  cli::DrawingFlags drawing;
  drawing.background = document_.view.background;
  if (is_for_eyes) drawing.annotation = document_.marks_of(document_.view);
  cli::Described described = job.shown->subject.described;
  RenderOptions ignored;
  described.box = cli::apply_crop(crop_of(document_), job.shown->field(), &ignored);
  cli::write_picture(image, drawing, described, job.camera, look, {path, {}});
  tell("picture written to " + std::filesystem::absolute(path).string());
}

// What is watched already keeps the time at which it was read.
void App::watch_files() {
  const auto add = [](Watched& watched, const std::string& file) {
    const bool is_there = std::any_of(watched.begin(), watched.end(),
                                      [&](const auto& entry) { return entry.first == file; });
    if (!is_there) watched.emplace_back(file, time_of(file));
  };
  for (const std::string& input : document_.launch->data.inputs) {
    for (const std::string& file : files_read_for(input)) add(watched_, file);
  }
  for (const std::string& file : files_beside()) add(watched_beside_, file);
}

void App::watch() {
  if (!launch_->watches || !document_.is_open()) return;
  const double now = now_s();
  if (now - watched_at_ < kWatchEvery) return;
  watched_at_ = now;
  constexpr std::filesystem::file_time_type kNowhere;
  const auto is_changed = [](const auto& entry) { return time_of(entry.first) != entry.second; };
  const bool is_data_changed = std::any_of(watched_.begin(), watched_.end(), is_changed);
  // What was removed, or is not there, may come back.
  const std::vector<std::string> shown = files_beside();
  Watched surfaces;
  std::copy_if(watched_beside_.begin(), watched_beside_.end(), std::back_inserter(surfaces),
               [&](const auto& entry) {
                 return std::find(shown.begin(), shown.end(), entry.first) != shown.end() &&
                        is_changed(entry) && time_of(entry.first) != kNowhere;
               });
  if ((!is_data_changed && surfaces.empty()) || loader_->is_busy()) return;
  // Whoever writes it may not be done.
  const auto settled = std::filesystem::file_time_type::clock::now() -
                       std::chrono::duration_cast<std::filesystem::file_time_type::duration>(
                           std::chrono::duration<double>(kWatchSettles));
  const auto is_settled = [&](const auto& entry) {
    const auto written = time_of(entry.first);
    return written != kNowhere && written <= settled;
  };
  if (!std::all_of(watched_.begin(), watched_.end(), is_settled) ||
      !std::all_of(surfaces.begin(), surfaces.end(), is_settled))
    return;
  // Tried once, should it fail.
  for (auto& [path, time] : watched_) time = time_of(path);
  for (auto& [path, time] : watched_beside_) {
    if (std::find(shown.begin(), shown.end(), path) != shown.end()) time = time_of(path);
  }
  tell("the file has changed: read again");
  if (is_data_changed) return loader_->open(document_.launch, true);  // and then the surfaces
  std::vector<std::string> paths;
  for (const auto& [path, time] : surfaces) paths.push_back(path);
  renew_beside(paths);
}

}  // namespace ovoid::viewer
