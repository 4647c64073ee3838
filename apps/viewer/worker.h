// SPDX-License-Identifier: Apache-2.0
// Draws pictures on a thread of its own: the newest that is asked for, coarse ones while something
// moves, then finer ones up to the full picture.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "levels.h"
#include "loader.h"
#include "ovoid/renderer.h"
#include "ovoid/scene.h"

namespace ovoid::viewer {

using Clock = std::chrono::steady_clock;

// All that one picture is made of. Immutable once it is handed over.
struct PictureJob {
  std::shared_ptr<const Shown> shown;
  std::shared_ptr<const Extras> extras;  // of `shown`; null while it is worked out
  Scene scene;                           // but for the slices
  cli::GeometryFlags slices;             // of it what is about slices
  bool is_of_shown = true;               // the first volume's field is that of `shown`
  Camera camera;
  RenderOptions options;  // the full picture's, width and height included
  RendererSetup setup;
  Rgb background{0, 0, 0};
  std::optional<std::pair<double, double>> xray_range;  // none: the picture's own

  const Field& field() const { return scene.volumes.front().field; }
  const Look& look() const { return scene.volumes.front().look; }
  // Several volumes, or another than the coarser fields are of, become coarser by pixels alone.
  bool has_coarser() const { return extras != nullptr && is_of_shown && scene.volumes.size() == 1; }
};

struct Request {
  std::uint64_t number = 0;                             // rising
  std::vector<std::shared_ptr<const PictureJob>> jobs;  // one, or two to be compared
  std::size_t own = 0;                                  // which of two is the document's
  bool is_moving = false;  // more requests will follow soon: a coarse picture will do
};

struct Picture {
  std::shared_ptr<const PictureJob> job;
  Image image;
  std::vector<std::uint8_t> bgra;  // opaque, before the background; row 0 at the bottom
  std::pair<double, double> xray_range{1e-3, 1};
  FrameProfile profile;
};

struct Pictures {
  std::uint64_t number = 0;  // of the request
  Level level;
  bool is_final = false;  // nothing finer follows
  std::vector<Picture> pictures;
  std::size_t own = 0;  // as the request has it
  std::string error;    // why there is none
  double ms = 0;        // of all its pictures
  // Of two full pictures.
  double psnr = 0;
  std::vector<std::uint8_t> difference;  // their distance, kDifferenceGain-fold, as Picture::bgra
};

inline constexpr double kDifferenceGain = 8;

class Worker {
 public:
  Worker();
  ~Worker();  // stops, and waits until it has
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Supersedes what was asked for before. A picture for something moving that is nearly done is
  // finished first, so that pictures keep coming; finer ones are given up at once.
  void ask(Request request);
  // The pictures that are newer than those taken last, if there are.
  std::optional<Pictures> take();
  // How long pictures that were given up took to stop, since the last call; milliseconds.
  std::vector<double> take_cancel_times();
  bool is_idle() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The colours of an x-ray whose integrals lie in the range; on a logarithmic scale what is not
// above 0 lies below them.
TransferFunction spread_over_integrals(TransferFunction tf, const std::pair<double, double>& range);

// Opaque 8-bit colours, blue first, row 0 at the bottom; an x-ray's integrals become colours over
// `xray_range`.
std::vector<std::uint8_t> to_display(const Image& image, const PictureJob& job,
                                     const std::pair<double, double>& xray_range);

}  // namespace ovoid::viewer
