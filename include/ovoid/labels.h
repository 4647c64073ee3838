// SPDX-License-Identifier: Apache-2.0
// Label maps: volumes whose values are names, such as organs, materials or grains. What is drawn of
// them are the smooth surfaces where one label gives way to another, found on every ray of every
// frame, without a mesh. docs/labels.md, and docs/numerics.md, "Labels".
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/label_style.h"
#include "ovoid/lattice.h"
#include "ovoid/look.h"
#include "ovoid/math.h"

namespace ovoid::labels {
class LabelGrid;
}

namespace OVOID_API ovoid {

// Which label holds where. Immutable; what smoothing makes of its parts is made when a ray first
// meets them, and kept: all members may be called from many threads at once.
class LabelMap {
 public:
  ~LabelMap();
  LabelMap(const LabelMap&) = delete;
  LabelMap& operator=(const LabelMap&) = delete;

  const std::vector<int>& labels() const noexcept;       // all that occur, rising
  const LatticeGeometry& geometry() const noexcept;      // of the samples
  std::optional<int> label_at(const Vec3& world) const;  // that wins there; none: outside, missing
  std::size_t resident_bytes() const noexcept;           // memory held now

  const labels::LabelGrid& grid() const noexcept { return *grid_; }  // the library's own business

 private:
  friend std::shared_ptr<const LabelMap> make_label_map(const LatticeField&, int, std::stop_token);
  explicit LabelMap(std::unique_ptr<const labels::LabelGrid> grid);

  std::unique_ptr<const labels::LabelGrid> grid_;
};

// A segmentation whose segments overlap, as files keep it: in layers, each a component of an array.
struct MergedLayers {
  Dataset dataset;                // with one array of one component
  std::vector<LabelEntry> table;  // of its labels, layer after layer
};
// All layers as one. Where segments overlap the one with the fewest samples is kept, so that what
// lies within another is not hidden by it; 0 is nothing in each. A label keeps its number unless a
// layer before has it; then it gets the next that is free. `tables`: what is known of the labels of
// each layer; may be fewer. Throws Error(kInvalidArgument) unless the dataset is a lattice whose
// first array has whole numbers in memory, with at most 65,000 different segments. Cost: twice over
// all samples; memory: two bytes for each place.
MergedLayers merge_layers(const Dataset& dataset,
                          const std::vector<std::vector<LabelEntry>>& tables);

// A map of the field's samples, which are whole numbers of at most 24 bits; the kernels of the
// field do not matter. Missing samples are no label's. Memory: one byte for each sample, two of
// more than 254 labels, and where labels meet 0.6 KiB and 1.8 for each of them, for 8 x 8 x 8
// samples. Throws
// Error: kInvalidArgument for a value that is no label, naming it, and for more than 65,000
// different ones; kUnsupported for body-centred lattices; kOutOfMemory, kCancelled, and what the
// field's source throws. Cost: once over all samples.
std::shared_ptr<const LabelMap> make_label_map(const LatticeField& field, int threads = 0,
                                               std::stop_token stop = {});

// How all labels of a map are drawn: as a table says, or else opaque and in a colour by the number.
// The background, 0 or else what the map's faces show most, is not drawn. What the table says of
// labels that the map does not have is passed over.
std::vector<LabelStyle> label_styles(const LabelMap& map,
                                     const std::vector<LabelEntry>& table = {});

// The look that shows labels by value in the same colours, as default_look() would: what colour
// bars tell, and what light in a scene and cameras that fit what shows go by. `styles`: at least
// one. Of labels that reach further than 2000 those that are near each other share a colour.
Look label_look(const std::vector<LabelStyle>& styles);

// The surfaces of a label map in a scene (Scenery), and what its slices show of them.
struct LabelSurfaces {
  std::shared_ptr<const LabelMap> map;  // null: none
  std::vector<LabelStyle> styles;       // of each label once; others are not drawn
  bool shows_field_elsewhere = true;    // whether the field is drawn in other labels and outside
  bool shows_surfaces = true;           // false: slices alone show those of an opacity > 0
  // On slices, of labels of an opacity > 0: how opaque their outlines are, as wide as that of a
  // slice (FieldSlice), and what they cover; each in [0, 1].
  double slice_lines = 1;
  double slice_areas = 0;

  // Throws Error(kInvalidArgument) that names what is wrong.
  void validate() const;
};

}  // namespace ovoid
