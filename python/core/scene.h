// SPDX-License-Identifier: Apache-2.0
// Data that are modelled once and drawn many times, by the flags of `ovoid render`.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "drawing.h"
#include "histogram.h"
#include "picking.h"
#include "profile.h"
#include "session.h"
#include "shot.h"
#include "source.h"
#include "waiting.h"

namespace ovoid::python {

// The flags that drawing takes, with the forms of all: those of `ovoid render` that are not about
// the run of a program.
class DrawFlags : public cli::Flags {
 public:
  DrawFlags(cli::DataFlags* data, cli::DrawingFlags* drawing);
};

// What is asked of a scene: flags as on a command line, and data in memory in the place of the
// files that some of them name.
struct Asked {
  cli::Words words;
  cli::Session::Provided beside;
};

// A frame, and what its files need to know.
struct Picture {
  Image image;                    // the field's own
  std::optional<Image> for_eyes;  // with marks, and x-rays in colours; none: the same
  cli::DrawingFlags drawing;
  cli::Described described;
  cli::Shot shot;
  cli::RunProfile profile;
  cli::FlagSet flags;
  std::vector<std::string> inputs;  // files; empty: data in memory
  std::vector<std::string> notes;
  Camera unturned;    // the shot's before it was turned and zoomed, looking at the same place
  ValueRange values;  // of the field
  double sampling_distance = 0;  // that it has by itself, world units
  double unit_distance = 0;      // of the look, world units
  std::int64_t num_steps = 1, step = 0;
  bool is_series = false;  // steps in memory
  cli::PickWords pick_words;

  const Image& seen() const { return for_eyes ? *for_eyes : image; }
};

// Does one thing at a time; a second thread waits.
class Scene {
 public:
  explicit Scene(Source source);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  // How a frame is drawn, beside its flags.
  struct Manner {
    bool with_stages = false;  // measured
    // How often the field was made coarser (ovoid/coarse.h) that is drawn in its place, for quick
    // pictures; of what has surfaces, planes, trails or points of its own, never.
    int coarseness = 0;
  };

  // By flags as on a command line. Throws Error and UsageError.
  std::shared_ptr<Picture> draw(const Asked& asked, Manner manner, Work& work);

  // Of the field that such a picture shows; world units.
  Bounds3 bounds(const Asked& asked, Work& work);
  cli::Histogram histogram(const Asked& asked, Work& work);
  // As cli::take_samples() and resample() do.
  Dataset sample(const Asked& asked, const Dataset& points, Work& work);
  Dataset resample(const Asked& asked, const LatticeGeometry& lattice, Work& work);

 private:
  struct Request;
  void take(Request& request, const Asked& asked, cli::Session& session, Work& work);
  void model(Request& request, cli::Session& session);
  // Makes coarser fields as far as that is worth it. Returns how often it was done.
  int coarsen(int coarseness, Work& work);
  const Field& field(const Asked& asked, cli::Session& session, Work& work);
  Renderer& renderer(const cli::Flags& flags, const RendererSetup& setup);

  Source source_;
  std::mutex mutex_;
  // What was modelled, by which flags, and what that said.
  std::optional<cli::Subject> subject_;
  std::vector<Field> coarser_;  // made of its field when they are first drawn
  std::string model_key_;
  cli::Session::Provided beside_;
  Dataset outline_;  // without its arrays
  std::optional<GradientMethod> gradient_of_labels_;
  std::vector<std::string> model_notes_;
  double load_ms_ = 0, model_ms_ = 0;  // of this frame
  std::unique_ptr<Renderer> renderer_;
  std::string renderer_key_;
  int process_ = 0;  // that the renderer's threads are in
};

// What `ovoid render --pick X,Y --pick-report FILE` writes of one pixel, and the units. Throws
// Error.
std::string picked(const Picture& picture, int x, int y);

// Writes what `ovoid render -o PATH` would write.
void save_picture(const Picture& picture, const std::string& path, std::stop_token stop);

// The bytes of the file that would be written: ".png", ".jpg" or ".jpeg", a JPEG by `quality`.
std::string encode_picture(const Picture& picture, const std::string& ending, int quality);

// Reads files as `ovoid render` does, with all their arrays. `may_stay`: samples that memory does
// not hold are left in them.
Dataset read_files(const std::vector<std::string>& inputs, const cli::Words& words, bool may_stay,
                   Work& work);

}  // namespace ovoid::python
