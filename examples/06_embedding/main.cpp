// SPDX-License-Identifier: Apache-2.0
// Drawing in the background of a program that stays responsive: embedding head.nrrd head.png
//
// What a window does: a frame is under way, the person turns the view, the frame is dropped and
// the next one begins. Finished tiles arrive one at a time and can be shown at once.
#include <ovoid/ovoid.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>

namespace {

// A frame on a thread of its own.
class BackgroundFrame {
 public:
  BackgroundFrame(const ovoid::LatticeField& field, const ovoid::Camera& camera,
                  const ovoid::Look& look) {
    thread_ = std::jthread([this, field, camera, look](const std::stop_token& stop) {
      ovoid::RenderHooks hooks;
      hooks.stop = stop;
      hooks.progress = [this](double fraction) { progress_ = fraction; };
      // Only the rectangle of this tile may be read from tile.image; here it is counted.
      hooks.tile_done = [this](const ovoid::TileDone& /*tile*/) { ++num_tiles_; };
      try {
        frame_ = ovoid::Renderer{}.render({field, look}, camera, {}, hooks);
      } catch (const ovoid::Error& error) {
        if (error.code() != ovoid::ErrorCode::kCancelled)
          std::fprintf(stderr, "%s\n", error.what());
      }
      is_done_ = true;
    });
  }

  void cancel() { thread_.request_stop(); }
  bool is_done() const { return is_done_; }
  double progress() const { return progress_; }
  int num_tiles() const { return num_tiles_; }
  // The picture; none if the frame was cancelled.
  std::optional<ovoid::Frame> wait() {
    thread_.join();
    return std::move(frame_);
  }

 private:
  std::atomic<double> progress_ = 0;
  std::atomic<int> num_tiles_ = 0;
  std::atomic<bool> is_done_ = false;
  std::optional<ovoid::Frame> frame_;
  std::jthread thread_;  // last, so that it ends first
};

}  // namespace

int main(int argc, char** argv) try {
  using namespace std::chrono_literals;
  if (argc != 3) return std::fprintf(stderr, "usage: %s VOLUME PICTURE\n", argv[0]), 2;
  const auto field = ovoid::make_lattice_field(ovoid::read_dataset({argv[1]}));
  const auto look = ovoid::default_look(field);
  auto camera = ovoid::default_camera(field.world_bounds());

  BackgroundFrame first(field, camera, look);
  std::this_thread::sleep_for(5ms);  // the person turns the view
  first.cancel();
  const auto start = std::chrono::steady_clock::now();
  const bool was_finished = first.wait().has_value();
  const std::chrono::duration<double, std::milli> waited = std::chrono::steady_clock::now() - start;
  std::printf("first frame: %s, %.1f ms after it was told to stop\n",
              was_finished ? "was already finished" : "cancelled", waited.count());

  camera.azimuth(40);
  BackgroundFrame second(field, camera, look);
  while (!second.is_done()) {  // here a program handles its events
    std::printf("\r%3.0f %%, %d tiles", 100 * second.progress(), second.num_tiles());
    std::fflush(stdout);
    std::this_thread::sleep_for(20ms);
  }
  std::printf("\r100 %%, %d tiles\n", second.num_tiles());
  const auto frame = second.wait();
  if (!frame) return 1;
  ovoid::write_image(frame->image, argv[2]);
} catch (const ovoid::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
