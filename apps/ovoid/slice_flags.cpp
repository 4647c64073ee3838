// SPDX-License-Identifier: Apache-2.0
#include "slice_flags.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<SliceMethod> kMethods = {{"interpolated", SliceMethod::kInterpolated},
                                     {"extracted", SliceMethod::kExtracted}};
const Names<LatticeKind> kLattices = {{"cc", LatticeKind::kCartesian},
                                      {"bcc", LatticeKind::kBodyCentred}};
constexpr double kLeastSpacing = 0.05;
constexpr double kMostSpacing = 1000;

Hyperplane parse_hyperplane(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 5);
  Hyperplane plane{{numbers[0], numbers[1], numbers[2], numbers[3]}, numbers[4]};
  if (plane.normal == std::array<double, 4>{})
    throw BadValue("expected a, b, c and d that are not all 0");
  return plane;
}

}  // namespace

void add_slice_flags(Flags& flags, SliceFlags* slice) {
  flags.value("--hyperslice", "A,B,C,D,E",
              "of lattices in time, what lies where A x + B y + C z + D t = E, in world units and "
              "those of the times: docs/time.md",
              [slice](const std::string& text) { slice->plane = parse_hyperplane(text); });
  flags.value("--slice-method", joined(kMethods),
              fmt::format("a new lattice in the plane, or the samples near it, moved onto it "
                          "(default {})",
                          name_in(kMethods, slice->method)),
              [slice](const std::string& text) { slice->method = parse_name(text, kMethods); });
  flags.value("--slice-lattice", joined(kLattices),
              "the lattice of an interpolated slice (default: the data's, bcc of D4*)",
              [slice](const std::string& text) { slice->lattice = parse_name(text, kLattices); });
  flags.value("--slice-spacing", "S",
              fmt::format("its T, in that of the data (default {})", slice->spacing),
              [slice](const std::string& text) {
                slice->spacing = parse_number(text, {.lo = kLeastSpacing, .hi = kMostSpacing});
              });
}

void check_slice_flags(const Flags& flags, const SliceFlags& slice) {
  const char* const lost =
      flags.first_given({"--slice-method", "--slice-lattice", "--slice-spacing"});
  if (!slice.plane) {
    if (lost != nullptr)
      throw UsageError(fmt::format("{}: has no effect without --hyperslice", lost));
    return;
  }
  const char* const other = flags.first_given({"--step", "--time"});
  if (other != nullptr)
    throw UsageError(fmt::format("{}: contradicts --hyperslice; give one of them", other));
  const char* const of_lattice = flags.first_given({"--slice-lattice", "--slice-spacing"});
  if (slice.method == SliceMethod::kExtracted && of_lattice != nullptr)
    throw UsageError(fmt::format(
        "{}: has no effect with --slice-method extracted, which makes no lattice", of_lattice));
}

}  // namespace ovoid::cli
