// SPDX-License-Identifier: Apache-2.0
// Everything that reads or makes data, on a thread of its own: the interface never waits for it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "beside.h"
#include "data_info.h"
#include "histogram.h"
#include "histogram_2d.h"
#include "launch.h"
#include "make_channels.h"
#include "make_look.h"
#include "make_solid.h"
#include "ovoid/dataset.h"
#include "ovoid/look.h"
#include "ovoid/sampler.h"

namespace ovoid::viewer {

// A control mesh's solid, instead of the mesh (docs/solids.md).
struct SolidShape {
  std::shared_ptr<const SolidMesh> control;
  int levels = cli::SolidFlags().levels;
  SolidBasis basis = cli::SolidFlags().basis;
  bool operator==(const SolidShape&) const = default;
};

// Channels of one file in one picture.
struct ShownChannels {
  std::vector<std::string> chosen;       // as --channels has them; empty: there are none
  std::vector<cli::NamedChannel> named;  // none of red, green and blue
  std::vector<cli::UsualLook> usual;     // of each, found already
  // What light their looks have as long as nobody edits it, and the flags that say so.
  Look first_look;
  cli::LookFlags flags;

  bool are_primaries() const { return !chosen.empty() && named.empty(); }
};

// What is drawn: one array of the data at one time. Immutable.
struct Shown {
  cli::Subject subject;
  std::shared_ptr<const Dataset> dataset;  // that it was made of
  double time = 0;
  std::string array;        // gives opacity
  std::string color_array;  // gives colour; of lattices the same
  int component = 0;
  bool is_density = false;             // of particles: mass, or number, per volume
  std::shared_ptr<const Trail> trail;  // what was there before; null: none
  std::optional<SolidShape> solid;     // whose kernels these are; none: of the data themselves
  bool is_rough = false;               // a solid as it is while it moves
  ShownChannels channels;              // that are drawn together, of which the field is the first

  const Field& field() const noexcept { return subject.modelled.field; }
  bool is_of(const std::optional<SolidShape>& wanted) const { return solid == wanted && !is_rough; }
};

// What is worked out of it for the interface, later than the first picture.
struct Extras {
  std::shared_ptr<const Shown> of;
  std::vector<Field> coarser;  // coarse_field(), once, twice, ...
  cli::Histogram histogram;
  std::shared_ptr<const FieldProbe> probe;  // values at places
};

// How often values and gradients go together, which is counted when it is asked for.
struct Counted2D {
  std::shared_ptr<const Shown> of;
  std::shared_ptr<const cli::Histogram2D> histogram;  // null: it could not be counted
  std::string error;                                  // why
};

// Of `dataset`, drawn as `drawing` says, which gets what labels need; without what is the view's.
// Throws Error.
std::shared_ptr<Shown> make_shown(std::shared_ptr<const Dataset> dataset, const cli::Flags& flags,
                                  cli::DrawingFlags& drawing, double time, cli::Session& session);

// Throws Error(kCancelled).
std::shared_ptr<const Extras> make_extras(const std::shared_ptr<const Shown>& shown, int threads,
                                          const std::stop_token& stop);

// Reports of the loader.
struct LoadProgress {
  std::string what;  // "reading engine.nii.gz"
  double fraction = 0;
  bool is_opening = false;  // the first word of new data
};
struct Opened {  // files were read; `shown` follows
  std::shared_ptr<const DataInfo> info;
  std::shared_ptr<const Launch> launch;
  bool is_reload = false;
  // Not of a reload.
  std::vector<std::shared_ptr<const ReadSurface>> surfaces;  // of --add, one by one
  std::optional<LabelsBeside> labels;                        // of --labels
  std::vector<std::shared_ptr<const VolumeBeside>> volumes;  // of --over
};
struct ShownReady {
  std::shared_ptr<const Shown> shown;
  std::optional<Look> look;  // where another array wants another one
  // Options that the data ask for (labels: narrow kernels, differences).
  GradientMethod gradient = GradientMethod::kAuto;
  std::optional<LatticeKernel> kernel;
};
struct Noted {
  std::string text;
};
struct LoadFailed {
  std::string message;
  bool was_opening = false, was_solid = false;
};
using LoadReport = std::variant<LoadProgress, Opened, ShownReady, std::shared_ptr<const Extras>,
                                Counted2D, Noted, BesideRead, LoadFailed>;

struct ArrayChoice {
  std::string array;
  std::string color_array;  // empty: the same
  int component = 0;        // LatticeModelOptions::kMagnitude: the norm
  bool is_density = false;  // particles: their mass or number per volume; `array` is empty
  std::vector<std::string> channels{};  // that are drawn instead, as --channels has them
  bool operator==(const ArrayChoice&) const = default;
};

ArrayChoice choice_of(const Shown& shown);

struct TimeChoice {
  double time = 0;
  bool is_interpolated = true;
  double blur_length = 0;  // of --motion-blur; 0: none
  double blur_decay = 0;
  bool operator==(const TimeChoice&) const = default;
};

struct SolidChoice {
  std::optional<SolidShape> shape;  // without a control mesh: of what is shown; none: the mesh
  bool wants_look = false;          // a new one
  bool is_moving = false;           // more will follow soon: fewer levels and no extras will do
  bool operator==(const SolidChoice&) const = default;
};

// All members may be called from one thread, the interface's. Of several choices of the same kind
// that wait only the last one is served; opening stops whatever else is done.
class Loader {
 public:
  Loader();
  ~Loader();  // stops, and waits until it has
  Loader(const Loader&) = delete;
  Loader& operator=(const Loader&) = delete;

  void open(std::shared_ptr<const Launch> launch, bool is_reload = false);
  void choose(const ArrayChoice& choice);
  // `look`: the picture's, which a trail's is made from.
  void go_to(const TimeChoice& choice, const Look& look, bool wants_extras);
  void show_solid(const SolidChoice& choice);
  // What is to stand beside the data; each task is served.
  void read_beside(BesideTask task);
  // Counts values and gradients, once, however often it is asked for; before the extras.
  void count_2d(std::shared_ptr<const Shown> shown);
  void stop();  // asks what is done to end; nothing follows

  std::vector<LoadReport> take_reports();
  bool is_busy() const;                // or has reports that nobody has taken
  std::size_t resident_bytes() const;  // of the steps that are kept

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovoid::viewer
