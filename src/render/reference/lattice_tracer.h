// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/reference/field_evaluator.h"
#include "render/reference/pixel_tracer.h"
#include "render/reference/post_convolution.h"

namespace ovoid::reference {

// Rays through a lattice field: a sample is asked for where it is needed. In a published way of
// post-convolution a pixel's samples are taken from the nodes around it, each of which is worked
// out anew for every pixel.
class LatticeTracer final : public PixelTracer {
 public:
  // Camera, look and options are valid; `field` and `evaluator` (of that field) outlive the tracer.
  LatticeTracer(const LatticeField& field, const FieldEvaluator& evaluator, const Camera& camera,
                const Look& look, const RenderOptions& options, const BesideTracer& beside = {},
                const view::BasePlane* base = nullptr, const view::LightVolume* light = nullptr);

 private:
  SheetRange sheets_of(const Ray& ray) const override;
  std::optional<RaySample> sample(const PixelRay& pixel, std::int64_t sheet,
                                  TraceCounts& counts) const override;
  Vec3 gradient(const PixelRay& pixel, const RaySample& sample) const override;
  Vec3 piece_gradient(const PixelRay& pixel, const RaySample& from,
                      const RaySample& to) const override;
  RaySample front_end(const PixelRay& pixel, const RaySample& before,
                      const RaySample& at) const override;
  ZRange range_of(const PixelRay& pixel, const Piece& piece) const override;
  Crossing crossing(const PixelRay& pixel, const RaySample& near, const RaySample& far,
                    double isovalue) const override;

  // A pixel or a node on a sheet, and how many pixels its neighbours are away: 1 of pixels, more of
  // nodes.
  struct Place {
    double x, y;
    std::int64_t sheet;
    double step = 1;
  };
  // The nodes that a pixel takes its samples on a sheet from.
  struct Nodes {
    double node_step;  // pixels from node to node
    FilterTaps x, y;
    std::int64_t sheet;

    Place place(std::size_t i, std::size_t j) const {
      return {node_step * (static_cast<double>(x.first) + static_cast<double>(i)),
              node_step * (static_cast<double>(y.first) + static_cast<double>(j)), sheet,
              node_step};
    }
  };
  std::optional<double> node_step_on(std::int64_t sheet) const;
  Nodes nodes_around(const PixelRay& pixel, std::int64_t sheet, double node_step) const;
  FieldSample value_from(const Nodes& nodes) const;
  Vec3 gradient_from(const Nodes& nodes) const;
  FieldSample node_at(const Place& place) const;
  FieldSample spread_at(const Place& place) const;
  Vec3 node_gradient(const Place& place) const;

  FieldSample field_at(const Place& place) const;
  FieldSample field_on_ray(const Ray& ray, double z, const Vec3& widening) const;
  Vec3 own_gradient(const Vec3& exact, const Vec3& position, const Vec3& widening) const;
  Vec3 central_gradient(const Place& place) const;
  double refined_crossing(const PixelRay& pixel, const RaySample& near, const RaySample& far,
                          double isovalue) const;

  const FieldEvaluator& evaluator_;
  const Slab slab_;
  const GradientMethod gradient_method_;
  const bool ends_at_faces_;   // a normalized field
  const bool has_nodes_;       // on sheets that are magnified enough
  const PostConvolution way_;  // and how pixels are made from them
  const Spread spread_;
  const Affine3 index_from_world_;
  const Affine3 world_from_index_;
  const LatticeKernel kernel_;  // in index units
  const double node_distance_;  // of the published ways, index units
  const Bounds3 support_;       // index space, the whole frame's
  const Bounds3 faces_;         // index space
};

}  // namespace ovoid::reference
