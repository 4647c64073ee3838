// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/tile.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/cpu/tile-inl.h"

#if HWY_ONCE
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <mutex>

#include "ovoid/error.h"

namespace ovoid::cpu {

HWY_EXPORT(render_patch_on_target);

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

void choose_target_once() {
  static std::once_flag once;
  std::call_once(once, [] {
    const char* wanted = std::getenv("OVOID_TARGET");
    if (wanted == nullptr || *wanted == '\0') {
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      return;
    }
    std::string names;
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      if (name_of_target(target) == lower(wanted)) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        return;
      }
      names += (names.empty() ? "" : ", ") + name_of_target(target);
    }
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("OVOID_TARGET = {}: must be one of {} on this machine", wanted, names));
  });
}

}  // namespace

void render_patch(const CpuFrame& frame, LatticeWorkspace& work, const TileRect& rect) {
  HWY_DYNAMIC_DISPATCH(render_patch_on_target)(frame, work, rect);
}

std::string simd_target_in_use() {
  choose_target_once();
  const auto targets = hwy::SupportedAndGeneratedTargets();
  return targets.empty() ? "scalar" : name_of_target(targets.front());
}

std::vector<std::string> usable_simd_targets() {
  std::vector<std::string> names;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets())
    names.push_back(name_of_target(target));
  return names;
}

}  // namespace ovoid::cpu
#endif
