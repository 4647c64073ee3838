// SPDX-License-Identifier: Apache-2.0
#include "simd/simd_target.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hwy/highway.h>

#include <cctype>

#include "ovoid/error.h"

namespace ovoid::simd {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return text;
}

// Highway's name of the target in plain C++ arrays is EMU128; ours is the word people use.
std::string name_of_target(std::int64_t target) {
  return target == HWY_EMU128 || target == HWY_SCALAR ? "scalar" : lower(hwy::TargetName(target));
}

}  // namespace

SimdTarget::SimdTarget(const std::string& name) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if (!name.empty() && name_of_target(target) != lower(name)) continue;
    hwy::ChosenTarget chosen;
    chosen.Update(target);
    name_ = name_of_target(target);
    index_ = chosen.GetIndex();
    return;
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("simd_target = {}: must be one of {} on this machine", name,
                          fmt::join(usable(), ", ")));
}

std::vector<std::string> SimdTarget::usable() {
  std::vector<std::string> names;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets())
    names.push_back(name_of_target(target));
  return names;
}

}  // namespace ovoid::simd
