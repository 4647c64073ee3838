// SPDX-License-Identifier: Apache-2.0
//
// A star of five arms, two cells thick. Around its middle lie five cells a layer, whose far corners
// are the roots of the arms; an arm is two cells wide, so that around a root there are three. Arms
// get thinner, curl up and turn sideways. The density is 1 on the middle line and 0 on the skin.
#include <cmath>
#include <numbers>

#include "ovoid/solid.h"

namespace ovoid {

namespace {

constexpr int kArms = 5, kStations = 5, kLayers = 3;  // stations: of an arm, behind its root
constexpr double kGapRadius = 0.8;                    // where two arms meet
constexpr double kRootRadius = 1.3;
constexpr double kStationLength = 0.62;
constexpr double kWidth = 0.62, kHeight = 0.6;  // of half an arm at its root
constexpr double kTip = 0.4;                    // what is left of them at its end
constexpr double kRound = 0.72;                 // edges of the skin are drawn in
constexpr double kSwirl = 0.09, kCurl = 0.055;  // per length squared

// The vertices of one layer: the middle, then for each arm the gap before it, its root and, of each
// station, right side, middle and left side.
constexpr int kPerArm = 2 + 3 * kStations, kPerLayer = 1 + kArms * kPerArm;
constexpr int gap(int arm) { return 1 + (arm + kArms) % kArms * kPerArm; }
constexpr int root(int arm) { return gap(arm) + 1; }
// `side` -1, 0, 1; station 0 is the root between its two gaps.
constexpr int on_arm(int arm, int station, int side) {
  if (station > 0) return gap(arm) + 2 + 3 * (station - 1) + side + 1;
  return side == 0 ? root(arm) : gap(side < 0 ? arm : arm + 1);
}

class Star {
 public:
  SolidMesh make() {
    for (int layer = 0; layer < kLayers; ++layer) add_layer(layer);
    for (int layer = 0; layer + 1 < kLayers; ++layer) {
      for (int arm = 0; arm < kArms; ++arm) {
        add_cell(layer, {0, gap(arm), gap(arm + 1), root(arm)});
        for (int station = 0; station < kStations; ++station) {
          for (int side = -1; side <= 0; ++side)
            add_cell(layer, {on_arm(arm, station, side), on_arm(arm, station + 1, side),
                             on_arm(arm, station, side + 1), on_arm(arm, station + 1, side + 1)});
        }
      }
    }
    return std::move(mesh_);
  }

 private:
  void add_cell(int layer, const std::array<int, 4>& vertices) {
    std::array<std::uint32_t, 8> cell{};
    for (std::size_t corner = 0; corner < cell.size(); ++corner)
      cell[corner] = static_cast<std::uint32_t>(vertices[corner % 4] +
                                                (layer + static_cast<int>(corner / 4)) * kPerLayer);
    mesh_.cells.push_back(cell);
  }

  void add_layer(int layer) {
    add_vertex(0, 0, 0, {0, layer, false});
    for (int arm = 0; arm < kArms; ++arm) {
      const double angle = 2 * std::numbers::pi * arm / kArms;
      const double half = std::numbers::pi / kArms;
      add_vertex(angle - half, kGapRadius, 0, {0, layer, true});
      add_vertex(angle, kRootRadius, 0, {0, layer, false});
      for (int station = 1; station <= kStations; ++station) {
        const double share = static_cast<double>(station) / kStations;
        const double width = kWidth * (1 + share * (kTip - 1)) * (layer == 1 ? 1 : kRound);
        for (int side = -1; side <= 1; ++side)
          add_vertex(angle, kRootRadius + kStationLength * station, side * width,
                     {share, layer, side != 0 || station == kStations});
      }
    }
  }

  struct Where {
    double share;  // of an arm
    int layer;
    bool is_rim;  // at the end of its layer
  };

  void add_vertex(double angle, double along, double across, const Where& where) {
    const double height = kHeight * (1 + where.share * (kTip - 1)) * (where.is_rim ? kRound : 1);
    const double turn = angle + kSwirl * along * along / 2;
    const double bend = kCurl * along * along;  // the arm's middle line rises like a parabola
    const double lift = (where.layer - 1) * height;
    const double slope = std::atan(2 * kCurl * along);
    const double out = along - lift * std::sin(slope);
    mesh_.positions.insert(mesh_.positions.end(), {out * std::cos(turn) - across * std::sin(turn),
                                                   out * std::sin(turn) + across * std::cos(turn),
                                                   bend + lift * std::cos(slope)});
    const bool is_inside = where.layer == 1 && !where.is_rim;
    mesh_.densities.push_back(is_inside ? 1 - 0.4 * where.share : 0);
  }

  SolidMesh mesh_;
};

}  // namespace

SolidMesh make_sample_control_mesh() { return Star().make(); }

}  // namespace ovoid
