// SPDX-License-Identifier: Apache-2.0
#include "model/team/kernel_halo.h"

#include <cmath>
#include <utility>

#include "model/particles/site_groups.h"
#include "model/team/territory.h"

namespace ovoid::model {
namespace {

Bounds3 support_of(const KernelParts& parts, std::size_t i) {
  const float* const l = parts.shapes.data() + 6 * i;
  const Vec3 reach =
      parts.cutoff * Vec3(std::abs(l[0]), std::hypot(l[1], l[2]), std::hypot(l[3], l[4], l[5]));
  return {parts.center(i) - reach, parts.center(i) + reach};
}

}  // namespace

KernelHalo::KernelHalo(const ModelRun& run, KernelParts& parts)
    : run_(run), num_own_(parts.count()), lists_(static_cast<std::size_t>(run.team->count())) {
  Territory own;
  if (num_own_ > 0) own = territory_of(SiteGroups(parts.centers, run.threads, run.stop));
  const std::vector<Territory> territories = territories_of_all(run, own);
  for (std::size_t i = 0; i < num_own_; ++i) {
    const Bounds3 support = support_of(parts, i);
    for (std::size_t p = 0; p < territories.size(); ++p) {
      if (p != static_cast<std::size_t>(run.team->number()) && territories[p].meets(support))
        lists_[p].push_back(static_cast<std::uint32_t>(i));
    }
  }
  constexpr std::size_t kRowBytes = 3 * sizeof(double) + 7 * sizeof(float);
  KernelTeam::Letters letters = data::letters_of(lists_, kRowBytes);
  data::append_rows(letters, lists_, 3, std::as_const(parts.centers));
  data::append_rows(letters, lists_, 6, std::as_const(parts.shapes));
  data::append_rows(letters, lists_, 1, std::as_const(parts.weights));
  for (data::Letter& letter : run.team->exchange(std::move(letters))) {
    const std::size_t count = letter.size() / kRowBytes;
    data::LetterReader reader(letter);
    reader.take(3 * count, parts.centers);
    reader.take(6 * count, parts.shapes);
    reader.take(count, parts.weights);
    letter = {};
  }
}

void KernelHalo::renew(std::vector<float>& weights) const {
  KernelTeam::Letters letters = data::letters_of(lists_, sizeof(float));
  data::append_rows(letters, lists_, 1, std::as_const(weights));
  weights.resize(num_own_);
  for (const data::Letter& letter : run_.team->exchange(std::move(letters)))
    data::LetterReader(letter).take(letter.size() / sizeof(float), weights);
}

void KernelHalo::remove_from(KernelParts& parts) const {
  parts.centers.resize(3 * num_own_);
  parts.shapes.resize(6 * num_own_);
  parts.weights.resize(num_own_);
}

}  // namespace ovoid::model
