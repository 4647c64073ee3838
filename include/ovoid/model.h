// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/field.h"

namespace ovoid {

// How a dataset's array becomes a field.
struct LatticeModelOptions {
  std::string array;  // empty: Dataset::array()'s default
  int component = 0;  // of the array's tuples; kMagnitude: Euclidean norm
  LatticeKernel kernel;
  Reconstruction reconstruction = Reconstruction::kNormalized;
  bool prefilter =
      false;        // coefficients such that the field takes the samples' values at the samples
  int threads = 0;  // 0: one per hardware thread

  static constexpr int kMagnitude = -1;
};

// What the model stage found; reported by `ovoid info` and in notes.
struct LatticeModelReport {
  std::string array;
  std::int64_t num_missing = 0;    // NaN and infinite samples: no kernel there
  std::size_t resident_bytes = 0;  // of the field, samples and ranges
  std::size_t source_bytes = 0;    // of the stored samples in the dataset
  std::vector<std::string> notes;
};

// Chooses kernels for a dataset: one ball per sample, shared shape. Samples are borrowed from the
// dataset (whose buffers stay alive with the field) when their type is one a BrickView can show;
// 32-bit and 64-bit integers and doubles become float32, and a prefiltered field is float32. Values
// beyond float32's range are missing. Throws Error: unknown array, component or type, kernel out of
// range, `prefilter` with a kernel whose samples cannot be interpolated. Cost: one pass for the
// value ranges; with `prefilter` three more, one per axis [METHOD 7.3.2: separable banded solve].
Field make_lattice_field(const Dataset& dataset, const LatticeModelOptions& options = {},
                         LatticeModelReport* report = nullptr, std::stop_token stop = {});

// Sample data by formula (`ovoid make`). Each is a dataset with one float32 array, centred on the
// origin.
struct MakeOptions {
  Index3 size{0, 0, 0};                    // samples; zeros: the name's own default
  ScalarType type = ScalarType::kFloat32;  // kUInt8 and kUInt16 are scaled to the type's full range
  std::uint64_t seed = 1;                  // for names that use random numbers
};
std::vector<std::string> sample_names();  // what make_sample() knows, with defaults in its page
std::string describe_sample(const std::string& name);  // one line for the help text
Dataset make_sample(const std::string& name,
                    const MakeOptions& options = {});  // throws Error(kInvalidArgument)

}  // namespace ovoid
