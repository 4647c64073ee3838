// SPDX-License-Identifier: Apache-2.0
// A lattice's samples on the device, in boxes that a shader can address, as many of them at a time
// as its memory holds.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ovoid/field.h"
#include "render/shared/device_layout.h"
#include "render/vulkan/residency.h"

namespace ovoid::vulkan {

struct LatticeBox : Resident {
  Index3 own_lo{}, own_hi{};        // cells that it alone has
  Index3 stored_lo{}, stored_hi{};  // cells whose samples are stored: as far as kernels reach
  std::uint64_t bytes = 0;
};

// Bytes of a sample, as the field's source has it. Throws what that throws.
std::size_t stored_size(const LatticeField& field);

// How a lattice is cut into boxes. Lattices of the same geometry that are cut alike have the same
// boxes.
struct BoxCut {
  int reach = 0;                 // cells that what a place reads may be away from it
  std::size_t sample_bytes = 1;  // of the largest samples that are cut so
  std::uint64_t most_bytes = 0;  // of the device's memory for samples, and of a box
  bool operator==(const BoxCut&) const = default;
};

class DeviceLattice {
 public:
  // Nothing is uploaded yet.
  DeviceLattice(std::shared_ptr<Device> device, const LatticeField& field, const BoxCut& cut);

  bool is_of(const LatticeField& field) const noexcept {
    return field.id() == id_ && field.version() == version_;
  }
  const BoxCut& cut() const noexcept { return cut_; }
  ScalarType type() const noexcept { return type_; }
  bool may_miss() const noexcept { return may_miss_; }
  // Of every brick whether a sample that reaches it is missing; bytes of 0 or kMissingBit.
  const std::vector<std::uint8_t>& missing() const noexcept { return missing_; }
  std::size_t num_boxes() const noexcept { return boxes_.size(); }

  // Numbers of the boxes such that along every ray those in front come first. `eye`: index space;
  // parallel projection: far away.
  std::vector<std::size_t> front_to_back(const Vec3& eye) const;

  // With its samples on the device; others give way. Throws what the source throws.
  const LatticeBox& acquire(std::size_t box, const LatticeField& field, Commands& commands);
  device::BoxConstants constants_of(const LatticeBox& box) const;

 private:
  void cut_boxes(std::uint64_t most_bytes);
  std::vector<std::byte> pack(const LatticeBox& box, const LatticeField& field) const;
  std::uint64_t bytes_of(const Index3& lo, const Index3& hi) const noexcept;

  std::shared_ptr<Device> device_;
  std::uint64_t id_, version_;
  Index3 cells_;
  Index3 num_boxes_{1, 1, 1};
  ScalarType type_ = ScalarType::kFloat32;
  int num_sublattices_;
  BoxCut cut_;
  bool may_miss_ = false;
  std::vector<std::uint8_t> missing_;
  std::vector<LatticeBox> boxes_;
  Residency residency_;
};

}  // namespace ovoid::vulkan
