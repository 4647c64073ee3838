// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ovoid/depth_limits.h"
#include "ovoid/field.h"
#include "ovoid/look.h"
#include "ovoid/renderer.h"
#include "render/reference/shading.h"
#include "render/reference/view_rays.h"
#include "view/look/look_2d.h"
#include "view/look/look_table.h"

namespace ovoid::reference {

struct Pixel {
  std::array<double, 4> rgba{};  // premultiplied
  double depth = std::numeric_limits<double>::infinity();
  double front_depth = std::numeric_limits<double>::infinity();
  std::size_t num_stops = 0;  // of the depth limits, that have joined it
};

// What was done for some pixels.
struct TraceCounts {
  std::int64_t samples = 0;
  std::int64_t visible = 0;    // samples with a non-zero opacity
  std::int64_t gradients = 0;  // samples whose gradient was used
};

class PixelTracer;

// Who else draws in a frame, asked sheet by sheet for what it has there. They outlive whoever asks.
struct BesideTracer {
  const PixelTracer* trail = nullptr;       // behind the field; null: none
  std::vector<const PixelTracer*> further;  // mixed with it
  Mixing mixing = Mixing::kAveraged;
};

// One pixel after the other, one sample of its ray after the other: docs/numerics.md,
// "Classification" to "Modes". What a sample is, and its gradient, is the field's matter. Immutable
// after construction: any number of threads may trace at once.
class PixelTracer {
 public:
  virtual ~PixelTracer() = default;

  Pixel trace(int x, int y, TraceCounts& counts) const;

 protected:
  // Where the field is drawn, and whether somebody else draws on at its ends.
  struct Span : ZRange {
    bool begins_at_seam = false, ends_at_seam = false;
  };
  // What a mode sees of a ray: the ray itself, and its samples by sheet.
  struct PixelRay {
    int x;
    int y;
    Ray ray;
    SheetRange sheets;
    std::span<const DepthLimits::Stop> stops;
    std::vector<Span> spans;
  };
  struct RaySample {
    std::int64_t sheet;
    double z;
    double path;
    double value;
    double color_value;   // what the colour is taken at
    Vec3 exact_gradient;  // of lattices, unless from nodes
    bool is_from_nodes = false;
    double presence = 1;  // of a trail: the share of its moments at which there is a value
  };
  // The ends of what lies between sheet - 1 and sheet; at least one is there.
  struct Piece {
    std::int64_t sheet;
    std::optional<RaySample> front, back;
  };
  struct Crossing {
    double z;
    double color_value;
    Vec3 gradient;  // zero unless the look is lit
  };

  // Camera, look and options are valid. `light`: how much of it arrives; null: all.
  PixelTracer(const Field& field, const ViewRays& view, const Look& look,
              const RenderOptions& options, const BesideTracer& beside = {},
              const view::LightVolume* light = nullptr);

  // All sheets on which the ray may have a sample.
  virtual SheetRange sheets_of(const Ray& ray) const = 0;
  // The sample of a sheet, if there is one.
  virtual std::optional<RaySample> sample(const PixelRay& pixel, std::int64_t sheet,
                                          TraceCounts& counts) const = 0;
  virtual Vec3 gradient(const PixelRay& pixel, const RaySample& sample) const = 0;
  // Of the piece between two sheets.
  virtual Vec3 piece_gradient(const PixelRay& pixel, const RaySample& from,
                              const RaySample& to) const = 0;
  // The sample before as the front end of the piece to `at`.
  virtual RaySample front_end(const PixelRay& pixel, const RaySample& before,
                              const RaySample& at) const;
  // Where along the ray a piece has a field, before anything is cut away.
  virtual ZRange range_of(const PixelRay& pixel, const Piece& piece) const;
  // Where between two samples on either side the field takes the isovalue.
  virtual Crossing crossing(const PixelRay& pixel, const RaySample& near, const RaySample& far,
                            double isovalue) const = 0;

  const Look& look() const { return look_; }
  const ViewRays& view() const { return view_; }
  bool is_preintegrated() const { return is_preintegrated_; }
  bool is_refined() const { return is_refined_; }
  bool uses_gradients() const {
    return look_.shade || !fading_.opacities.empty() || look_.transfer_function_2d;
  }

 private:
  ClassifiedSample classified_sample(const std::optional<RaySample>& before,
                                     const RaySample& at) const;
  Rgb color_of(double color_value) const;
  PixelRay pixel_ray(int x, int y) const;
  SheetRange sheets_of_all(const Ray& ray) const;
  std::optional<RaySample> within_limits(const PixelRay& pixel, std::optional<RaySample> at) const;
  bool is_within(const PixelRay& pixel, double z) const;
  void add_stops(const PixelRay& pixel, double up_to, Pixel& result) const;
  // What one field shows of a step or a sample, lit.
  struct Share {
    Rgb color;
    double opacity;
    double z;
    bool is_own = true;  // of the field, not of a further volume
  };
  std::optional<Share> share_of_sample(const PixelRay& pixel, const std::optional<RaySample>& start,
                                       const RaySample& at, TraceCounts& counts) const;
  Share mixed(const std::vector<Share>& shares) const;
  void add_shares(const std::vector<Share>& shares, Pixel& result) const;
  void add_trail(const PixelRay& pixel, std::int64_t sheet, Pixel& result,
                 TraceCounts& counts) const;
  // What was classified, and where it is composited. Of a look with a 2-D transfer function the
  // value alone has been classified so far, by its envelope.
  struct SeenSample {
    double value;
    ClassifiedSample look;
    Vec3 slope;
    double clearance;
    view::ArrivingLight arriving;
    double z, path;
  };
  Share share_of(const PixelRay& pixel, const SeenSample& seen) const;
  double clearance_at(const PixelRay& pixel, double z) const;
  LitPlace lit_place(const PixelRay& pixel, const Vec3& slope, double clearance) const;
  view::ArrivingLight light_at(const PixelRay& pixel, double z, const Vec3& slope) const;
  Rgb seen_color(const Rgb& color, const LitPlace& place,
                 const view::ArrivingLight& arriving) const;
  bool may_show(const Piece& piece) const;
  int num_steps(const Piece& piece, const Vec3& front_slope, const Vec3& back_slope) const;
  // A field's piece, and whose it is.
  struct OwnedPiece {
    const PixelTracer* owner;
    Piece piece;
  };
  // What a span leaves of a piece, and how it changes from end to end.
  struct PiecePart {
    OwnedPiece of;
    ZRange part;
    Vec3 front_slope = Vec3::Zero(), back_slope = Vec3::Zero();
    view::ArrivingLight front_light{}, back_light{};
    double front_clearance = 1, back_clearance = 1;
    int steps = 1;  // that it needs
  };
  std::optional<ZRange> part_within(const PixelRay& pixel, const Piece& piece,
                                    const Span& span) const;
  PiecePart part_in_steps(const PixelRay& pixel, const Piece& piece, const ZRange& part,
                          TraceCounts& counts) const;
  std::optional<Share> share_of_step(const PixelRay& pixel, const PiecePart& part, int step,
                                     int steps, TraceCounts& counts) const;
  void add_parts(const PixelRay& pixel, const std::vector<PiecePart>& parts, Pixel& result,
                 TraceCounts& counts) const;
  void add_pieces(const PixelRay& pixel, const std::vector<OwnedPiece>& pieces, Pixel& result,
                  TraceCounts& counts) const;
  Pixel composite(const PixelRay& pixel, TraceCounts& counts) const;
  Pixel refined(const PixelRay& pixel, TraceCounts& counts) const;
  Pixel xray(const PixelRay& pixel, TraceCounts& counts) const;
  // Maximum or minimum.
  Pixel extreme(const PixelRay& pixel, TraceCounts& counts) const;
  Pixel mean(const PixelRay& pixel, TraceCounts& counts) const;
  Pixel isosurface(const PixelRay& pixel, TraceCounts& counts) const;
  void add_surface(const PixelRay& pixel, const Isosurface& surface, const Crossing& at,
                   Pixel& result, TraceCounts& counts) const;
  void add_surfaces_between(const PixelRay& pixel, const RaySample& near, const RaySample& far,
                            Pixel& result, TraceCounts& counts) const;
  Pixel classified(double value, double depth, TraceCounts& counts) const;
  // What one sample, or a part of a piece, says of a pixel that shows a value.
  struct SeenValue {
    double value, z, path;
  };
  std::vector<SeenValue> values_along(const PixelRay& pixel, TraceCounts& counts) const;
  void add_values(const PixelRay& pixel, const Piece& piece, std::vector<SeenValue>& seen) const;
  std::vector<ZRange> parts_left(const PixelRay& pixel, const Piece& piece) const;
  static Pixel kept(double best, double path, double depth);

  const Look look_;
  const std::vector<Isosurface> surfaces_;  // by rising value
  const bool has_own_color_;
  const double opaque_at_;
  const bool keeps_values_;                          // a part of a picture
  const std::shared_ptr<const DepthLimits> limits_;  // null: none
  const bool reaches_limits_;  // a piece with one end reaches to a limit on its other side
  const bool is_preintegrated_;
  const bool is_refined_;
  const TransferFunction fading_;      // opacity by the gradient's length; without points 1
  const view::LookTable table_;        // decides about steps and what shows, never about colours
  const view::Variation2D variation_;  // by gradient of a 2-D transfer function alone
  const ViewRays view_;
  ShadingContext shading_;
  const BesideTracer beside_;
  std::vector<const PixelTracer*> all_;  // this one and those that are mixed with it
  const view::LightVolume* const light_;
};

}  // namespace ovoid::reference
