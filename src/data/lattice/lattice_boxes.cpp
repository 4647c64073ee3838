// SPDX-License-Identifier: Apache-2.0
#include "ovoid/lattice_boxes.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <new>
#include <string>

#include "data/lattice/box_values.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_boxes(const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, what);
}

void check(const LatticeBoxes& all) {
  double count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    if (all.dims[a] < 1) refuse_boxes(fmt::format("dims[{}] = {}: must be >= 1", a, all.dims[a]));
    count *= static_cast<double>(all.dims[a]);
  }
  if (count > static_cast<double>(std::numeric_limits<std::uint32_t>::max()))
    refuse_boxes(fmt::format("dims: {} samples: expected fewer than 2^32", count));
  for (const double number : {all.background, all.least, all.greatest}) {
    if (!(std::abs(number) <= static_cast<double>(std::numeric_limits<float>::max())))
      refuse_boxes(fmt::format("background, least, greatest: {}: must be a float", number));
  }
  if (!(all.step > 0 && std::isfinite(all.step)))
    refuse_boxes(fmt::format("step = {}: must be > 0", all.step));
  if (!(all.least <= all.greatest))
    refuse_boxes(fmt::format("least, greatest = {}, {}: must rise", all.least, all.greatest));
}

// Puts boxes into samples one after the other.
class BoxFiller {
 public:
  explicit BoxFiller(const LatticeBoxes& all)
      : all_(all),
        sample_(all),
        samples_(static_cast<std::size_t>(num_samples(all.dims)),
                 static_cast<float>(all.background)),
        is_in_box_(samples_.size(), 0) {}

  void fill(std::size_t number) {
    const LatticeBox& box = all_.boxes[number];
    const Index3 begin = begin_of(number);
    for (std::size_t a = 0; a < 3; ++a) {
      if (box.size[a] < 1 || box.size[a] > all_.dims[a] - begin[a])
        refuse(number, fmt::format("its size along {} is {}: expected 1 to {}", "xyz"[a],
                                   box.size[a], all_.dims[a] - begin[a]));
    }
    if (all_.whole && box.first == LatticeBox::kMissing)
      refuse(number, "its samples are missing, which whole numbers are not");
    const data::BoxValues values(box);
    for (std::int64_t k = 0; k < box.size[2]; ++k) {
      for (std::int64_t j = 0; j < box.size[1]; ++j) fill_row(number, values, begin, j, k);
    }
  }

  std::vector<float> take() { return std::move(samples_); }

 private:
  [[noreturn]] static void refuse(std::size_t number, const std::string& what) {
    refuse_boxes(fmt::format("boxes[{}]: {}", number, what));
  }

  Index3 begin_of(std::size_t number) {
    std::int64_t gap = all_.boxes[number].gap;
    if (gap < 0) refuse(number, fmt::format("gap = {}: must be >= 0", gap));
    for (;; ++next_) {
      if (next_ == samples_.size()) refuse(number, "its gap reaches beyond the lattice");
      if (is_in_box_[next_] == 0 && gap-- == 0) break;
    }
    const auto at = static_cast<std::int64_t>(next_);
    return {at % all_.dims[0], at / all_.dims[0] % all_.dims[1], at / all_.dims[0] / all_.dims[1]};
  }

  void fill_row(std::size_t number, const data::BoxValues& values, const Index3& begin,
                std::int64_t j, std::int64_t k) {
    const LatticeBox& box = all_.boxes[number];
    const auto from = static_cast<std::size_t>(
        ((begin[2] + k) * all_.dims[1] + begin[1] + j) * all_.dims[0] + begin[0]);
    const double row = values.row(j, k);
    for (std::int32_t i = 0; i < box.size[0]; ++i) {
      const std::size_t at = from + static_cast<std::size_t>(i);
      if (is_in_box_[at] != 0) refuse(number, "it overlaps one before");
      is_in_box_[at] = 1;
      samples_[at] = box.first == LatticeBox::kMissing ? std::numeric_limits<float>::quiet_NaN()
                                                       : sample_(row + i * values.slope());
    }
  }

  const LatticeBoxes& all_;
  data::SampleOfBox sample_;
  std::vector<float> samples_;
  std::vector<std::uint8_t> is_in_box_;
  std::size_t next_ = 0;  // no box begins before it
};

std::vector<float> filled(const LatticeBoxes& boxes, const std::stop_token& stop,
                          const std::function<void(double fraction)>& progress) {
  constexpr std::size_t kBatch = 1 << 14;
  BoxFiller filler(boxes);
  for (std::size_t number = 0; number < boxes.boxes.size(); ++number) {
    if (number % kBatch == 0) {
      if (stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "expanding boxes was cancelled");
      if (progress) progress(static_cast<double>(number) / static_cast<double>(boxes.boxes.size()));
    }
    filler.fill(number);
  }
  if (progress) progress(1);
  return filler.take();
}

}  // namespace

std::vector<float> samples_of(const LatticeBoxes& boxes, const std::stop_token& stop,
                              const std::function<void(double fraction)>& progress) {
  check(boxes);
  try {
    return filled(boxes, stop, progress);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("no memory for {} samples of boxes", num_samples(boxes.dims)));
  }
}

}  // namespace ovoid
