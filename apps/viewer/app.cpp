// SPDX-License-Identifier: Apache-2.0
// Once around: input, what was read and drawn meanwhile, the interface, the next picture.
#include "app.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "ovoid/error.h"
#include "ovoid/io.h"
#include "start_page.h"

namespace ovoid::viewer {
namespace {

constexpr double kFrame = 1.0 / 60;         // seconds between frames while anything happens
constexpr double kLeastBetween = 1.0 / 70;  // seconds between frames while something moves
constexpr double kRest = 0.5;               // seconds a window sleeps in which nothing does
constexpr double kDialogEvery = 0.1;        // seconds after which it is asked whether it is done
constexpr double kHeldStill = 0.25;         // seconds without a change after which pictures refine
constexpr int kFramesPerEvent = 3;          // ImGui needs some to show what an event led to

// A script does the same wherever it runs.
std::string memory_path(const Launch& launch) {
  if (launch.remember.empty()) return launch.script.empty() ? usual_memory_path() : "";
  return launch.remember == "none" ? "" : launch.remember;
}

}  // namespace

double now_s() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

App::App(std::shared_ptr<const Launch> launch)
    : launch_(std::move(launch)),
      memory_(memory_path(*launch_)),
      theme_(launch_->theme.value_or(memory_.theme())),
      window_("Ovoid", {launch_->drawing.options.width +
                            (launch_->has_panel ? static_cast<int>(kPanelWidth) : 0),
                        launch_->drawing.options.height}),
      gui_(window_),
      has_panel_(launch_->has_panel) {
  if (!launch_->script.empty()) script_.emplace(launch_->script);
  if (!launch_->record.empty()) {
    recorder_.emplace(launch_->record);
    recorder_->begin(window_.size().width, window_.size().height);
  }
  const float scale = gui_.scale();
  if (has_panel_ && scale != 1) {  // which is known only now
    const Size size = window_.size();
    const float more = static_cast<float>(kPanelWidth) * (scale - 1);
    window_.resize({size.width + static_cast<int>(more), size.height});
  }
  worker_ = std::make_unique<Worker>();
  loader_ = std::make_unique<Loader>();
  fitter_ = std::make_unique<Fitter>();
  document_.launch = launch_;
  if (!launch_->data.inputs.empty()) loader_->open(launch_);
}

App::~App() {
  window_.hide();  // what takes time now takes it out of sight
  loader_->stop();
  fitter_->stop();
  worker_.reset();
  loader_.reset();
  fitter_.reset();
}

double App::patience() const {
  if (frames_due_ > 0) return 0;
  if (is_moving_ || document_.time.is_playing || script_ || progress_) return kFrame;
  double rest = dialog_.is_shown() ? kDialogEvery : kRest;
  for (const Message& message : messages_) rest = std::min(rest, message.until - now_s());
  return std::max(rest, 0.0);
}

void App::run(const std::stop_token& stop) {
  const std::stop_callback wake(stop, [] { Window::wake(); });
  double last_frame = now_s();
  double next_input = last_frame;  // of the script
  while (is_open_ && !stop.stop_requested()) {
    double wait = patience();
    if (script_ && wait > 0) wait = std::clamp(next_input - now_s(), 0.0, wait);
    std::vector<Event> events = window_.events(wait);
    // Pictures and input that come soon after each other share a frame; what it would have cost is
    // left to the pictures.
    const double early = is_moving_ ? last_frame + kLeastBetween - now_s() : 0;
    if (early > 0) {
      std::this_thread::sleep_for(std::chrono::duration<double>(early));
      const std::vector<Event> more = window_.events(0);
      events.insert(events.end(), more.begin(), more.end());
    }
    const double begun = now_s();
    if (recorder_) recorder_->take(events, begun * 1000);
    if (script_ && begun >= next_input) {
      const std::vector<Event> scripted = script_->next_frame(*this);
      events.insert(events.end(), scripted.begin(), scripted.end());
      next_input = std::max(next_input + script_->seconds_per_frame(), begun);
      frames_due_ = std::max(frames_due_, 1);
      if (script_->is_over()) is_over_ = true;
    }
    if (!events.empty()) frames_due_ = kFramesPerEvent;
    // A script ends with what it led to being shown.
    if (is_over_ && frames_due_ <= 1 && screenshot_wish_.empty()) is_open_ = false;
    take_load_reports();
    take_pictures();
    take_fit();
    take_dialog();
    if (memory_.update()) frames_due_ = std::max(frames_due_, 2);
    watch();
    play();
    if (!messages_.empty() && messages_.front().until < begun) frames_due_ = 1;  // it goes
    if (frames_due_ <= 0 && !is_moving_ && !progress_) continue;
    frame(events, begun - last_frame);
    last_frame = begun;
    --frames_due_;
    meter_.interface_frame((now_s() - begun) * 1000);
    meter_.first_frame();
  }
  if (recorder_) recorder_->write();
  if (!launch_->save_state.empty()) save_state(launch_->save_state);
  if (!launch_->report.empty()) {
    nlohmann::ordered_json report = meter_.report();
    report["memory_mib"] = value_of("memory_mib");
    write_file(launch_->report, report.dump(2) + "\n");
  }
}

void App::frame(const std::vector<Event>& events, double seconds) {
  gui_.set_theme(theme_);
  gui_.begin(events, seconds);
  widgets_.begin_frame(gui_.scale(), colors_of(theme_));
  take_shortcuts(events);
  const ImVec2 all = ImGui::GetIO().DisplaySize;
  const Size pixels = window_.framebuffer();
  const bool is_visible = all.x >= 1 && all.y >= 1;
  const float density = is_visible ? static_cast<float>(pixels.width) / all.x : 1.0F;
  const float panel_width =
      has_panel_ ? std::min(static_cast<float>(kPanelWidth) * gui_.scale(), all.x / 2) : 0;
  picture_at_ = {0, 0};
  picture_extent_ = {std::max(all.x - panel_width, 1.0F), std::max(all.y, 1.0F)};
  status_.picture = picture_size();
  status_.pictures_per_second = meter_.pictures_per_second();
  status_.interface_ms = meter_.interface_ms();
  status_.resident_bytes = loader_->resident_bytes();
  status_.theme = theme_;
  Wishes wishes;
  status_.is_browsing = dialog_.is_shown();
  Panel panel{document_, widgets_, panel_state_, wishes, status_, memory_};
  const bool is_held = picture_view_.draw(panel, gui_, picture_at_, picture_extent_, density);
  if (document_.has_time() && document_.is_open())
    draw_transport(panel, picture_at_, picture_extent_);
  draw_status(picture_at_, picture_extent_);
  if (!document_.is_open() && !progress_)
    start_page(panel, load_error_, picture_at_, picture_extent_);
  if (has_panel_) draw_panel(panel, {picture_extent_.x, 0}, {panel_width, all.y});
  if (shows_help_) draw_help();
  take_changes(is_held);
  grant(std::move(wishes));
  // What is shown is what the slider says, once nothing newer is on its way.
  if (document_.is_open() && !ImGui::IsAnyMouseDown() && !waits_for_time_ &&
      !document_.time.is_playing)
    document_.time.now = document_.shown->time;
  ask_for_solid();
  ask_for_surfaces();
  ask_for_picture(is_moving_);
  if (is_visible)
    gui_.end();
  else
    ImGui::EndFrame();
  if (!screenshot_wish_.empty()) write_screenshot();
  window_.show_frame();
}

// What the frame has changed: is it moving, and is there something to undo?
void App::take_changes(bool is_held) {
  const double now = now_s();
  const bool is_mouse_down = ImGui::IsAnyMouseDown();
  if (document_.version() != last_version_) {
    last_version_ = document_.version();
    meter_.changed(last_version_);
    changed_at_ = now;
    frames_due_ = std::max(frames_due_, 2);
  }
  if (document_.view_version() != last_view_version_) {
    last_view_version_ = document_.view_version();
    was_edited_ = true;
  }
  is_moving_ =
      ((is_held || is_mouse_down) && now - changed_at_ < kHeldStill) || document_.time.is_playing;
  meter_.moving(is_moving_);
  if (was_edited_ && !is_mouse_down && !ImGui::IsAnyItemActive() && !document_.time.is_playing) {
    document_.remember();
    was_edited_ = false;
  }
}

double App::aspect() const {
  const Size size = picture_size();
  return static_cast<double>(size.width) / std::max(size.height, 1);
}

Size App::to_pixels(double width, double height) const {
  const Size window = window_.size();
  const Size framebuffer = window_.framebuffer();
  const double density =
      window.width > 0 ? static_cast<double>(framebuffer.width) / window.width : 1.0;
  const auto pixels_of = [&](double length) {
    return std::clamp(static_cast<int>(std::lround(length * density)), 1,
                      RenderOptions::kMaxImageSide);
  };
  return {pixels_of(width), pixels_of(height)};
}

Size App::picture_size() const { return to_pixels(picture_extent_.x, picture_extent_.y); }

Size App::drawn_size() const {
  const Box2 all = picture_view_.placement(document_, picture_at_, picture_extent_).all;
  return to_pixels(all.x1 - all.x0, all.y1 - all.y0);
}

void App::ask_for_picture(bool is_moving) {
  if (!document_.is_open()) return;
  const Size size = drawn_size();
  const std::uint64_t version = document_.version();
  // A vertex was moved, and its solid is not there yet: the picture would be the last one again.
  if (picture_view_.holds_vertex() && is_moving && asked_shown_ == document_.shown) return;
  const bool is_settled = asked_moving_ && !is_moving;
  if (version == asked_version_ && size == asked_size_ && !is_settled) return;
  Request request;
  request.number = version;
  request.jobs = document_.jobs(size, picture_size().width);
  request.own = document_.own_job();
  request.is_moving = is_moving;
  worker_->ask(std::move(request));
  asked_version_ = version;
  asked_size_ = size;
  asked_moving_ = is_moving;
  asked_shown_ = document_.shown;
}

void App::take_pictures() {
  std::optional<Pictures> pictures = worker_->take();
  if (!pictures) return;
  frames_due_ = std::max(frames_due_, 1);
  if (pictures->number >= time_version_) waits_for_time_ = false;
  if (!pictures->error.empty()) {
    tell(pictures->error, true);
    failed_version_ = pictures->number;
    return;
  }
  status_.profile = pictures->pictures[pictures->own].profile;
  status_.level = pictures->level;
  status_.picture_ms = pictures->ms;
  status_.is_final = pictures->is_final;
  status_.psnr = pictures->psnr;
  const std::string& notice = status_.profile.notice;
  if (!notice.empty() && notice != told_notice_) tell(told_notice_ = notice);
  meter_.picture_shown(pictures->number, is_moving_, pictures->is_final, pictures->ms);
  for (const double ms : worker_->take_cancel_times()) meter_.cancelled(ms);
  picture_view_.take(std::move(*pictures));
  if (picture_wish_ && picture_view_.full(document_) != nullptr) {
    try {
      save_the_picture(*std::exchange(picture_wish_, std::nullopt));
    } catch (const Error& error) {
      tell(cli::message_line(error.what()), true);
    }
  }
}

void App::tell(const std::string& text, bool is_error) {
  constexpr double kShown = 6;
  constexpr std::size_t kMost = 6;
  for (Message& message : messages_) {
    if (message.text != text) continue;
    message.until = now_s() + kShown;
    return;
  }
  messages_.push_back({text, is_error, now_s() + (is_error ? 3 * kShown : kShown)});
  if (messages_.size() > kMost) messages_.pop_front();
  last_message_ = text;
  frames_due_ = std::max(frames_due_, 2);
}

void App::go_to_time() {
  if (!document_.has_time()) return;
  const TimeState& time = document_.time;
  waits_for_time_ = true;
  time_version_ = ~std::uint64_t{0};
  loader_->go_to({time.now, time.is_interpolated, time.blur_length, time.blur_decay},
                 document_.view.look, !time.is_playing);
}

// The clock, or as soon as the last step is shown.
void App::play() {
  TimeState& time = document_.time;
  const double now = now_s();
  const double passed = now - std::exchange(played_at_, now);
  if (was_playing_ != time.is_playing) {
    was_playing_ = time.is_playing;
    frames_due_ = std::max(frames_due_, 2);
    if (!time.is_playing) go_to_time();  // with all that is worked out at rest
    played_time_ = time.now;
    return;
  }
  if (!time.is_playing || !document_.has_time()) return;
  const std::vector<double>& times = document_.info->times;
  if (time.is_fastest) {
    if (waits_for_time_) return;
    if (!time.loops && time.now >= times.back()) {
      time.is_playing = false;
      return;
    }
    step_time(document_, 1);
    go_to_time();
    return;
  }
  played_time_ += passed * time.rate;
  const double span = times.back() - times.front();
  if (played_time_ > times.back()) {
    if (!time.loops) {
      time.is_playing = false;
      return;
    }
    played_time_ = times.front() + std::fmod(played_time_ - times.front(), span);
  }
  if (waits_for_time_) return;  // late: what lies between is left out
  double wanted = played_time_;
  if (!time.is_interpolated) {
    const auto behind = std::upper_bound(times.begin(), times.end(), wanted);
    wanted = *std::prev(behind == times.begin() ? std::next(behind) : behind);
  }
  if (wanted == time.now) return;
  time.now = wanted;
  go_to_time();
}

}  // namespace ovoid::viewer
