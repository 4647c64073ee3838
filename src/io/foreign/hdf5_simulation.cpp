// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_simulation.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "io/core/text_scanner.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/hdf5_positions.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr double kMostFiles = 65536;

// Groups of a file that hold attributes alone.
class AttributeGroups {
 public:
  explicit AttributeGroups(const std::string& path)
      : file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose) {}

  bool has(const char* group) const { return open(group).is_open(); }

  std::vector<double> numbers(const char* group, const char* name) const {
    constexpr std::size_t kMost = 64;
    const Hdf5Handle handle = open(group);
    return handle.is_open() ? hdf5_numbers(handle.get(), name, kMost) : std::vector<double>();
  }
  std::optional<double> number(const char* group, const char* name) const {
    const std::vector<double> all = numbers(group, name);
    return all.empty() ? std::nullopt : std::optional(all[0]);
  }
  std::string text(const char* group, const char* name) const {
    const Hdf5Handle handle = open(group);
    return handle.is_open() ? hdf5_text(handle.get(), name).value_or("") : std::string();
  }

 private:
  Hdf5Handle open(const char* group) const {
    if (!file_.is_open() || H5Lexists(file_.get(), group, H5P_DEFAULT) <= 0 ||
        !is_hard_link(file_.get(), group))
      return {};
    return {H5Gopen2(file_.get(), group, H5P_DEFAULT), H5Gclose};
  }

  Hdf5Silence silence_;
  Hdf5Handle file_;
};

bool has_word(std::string_view text, std::string_view word) {
  return lower(text).find(word) != std::string::npos;
}

// By the words of a kernel's name: "Quartic spline (M5)", "Wendland C2".
CodeFound swift_code(const AttributeGroups& groups) {
  constexpr std::string_view kSwift = "SWIFT, ";
  const std::string kernel = groups.text("HydroScheme", "Kernel function");
  std::optional<data::SmoothingCode> first;
  for (const data::SmoothingCode& code : data::smoothing_codes()) {
    if (!code.name.starts_with(kSwift)) continue;
    if (!first) first = code;
    const auto wanted = words(code.name.substr(kSwift.size()));
    if (std::all_of(wanted.begin(), wanted.end(),
                    [&](std::string_view word) { return has_word(kernel, lower(word)); }))
      return {code, true};
  }
  return {*first, false};
}

}  // namespace

std::optional<SnapshotHeader> snapshot_header(const std::string& path) {
  const AttributeGroups groups(path);
  const double num_files = groups.number("Header", "NumFilesPerSnapshot").value_or(1);
  if (!(num_files > 1)) return std::nullopt;
  if (num_files > kMostFiles || num_files != std::floor(num_files)) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: '/Header' NumFilesPerSnapshot {}: expected 1 to {}", path,
                            num_files, kMostFiles));
  }
  SnapshotHeader header{static_cast<std::int64_t>(num_files), {}, {num_files}};
  header.totals = groups.numbers("Header", "NumPart_Total");
  const std::vector<double> high = groups.numbers("Header", "NumPart_Total_HighWord");
  for (std::size_t i = 0; i < std::min(high.size(), header.totals.size()); ++i)
    header.totals[i] += std::ldexp(high[i], 32);
  header.identity.insert(header.identity.end(), header.totals.begin(), header.totals.end());
  for (const char* const name : {"Time", "Redshift", "BoxSize"})
    header.identity.push_back(groups.number("Header", name).value_or(0));
  return header;
}

std::optional<CodeFound> smoothing_code(const std::string& path, const std::string& group,
                                        const std::string& name) {
  if (gadget_type(group) < 0) return std::nullopt;
  const AttributeGroups groups(path);
  const std::string code = groups.text("Code", "Code") + " " + groups.text("Header", "Code");
  const bool is_swift = has_word(code, "swift") || lower(name) == "smoothinglengths" ||
                        !groups.text("HydroScheme", "Kernel function").empty();
  if (is_swift) return swift_code(groups);
  return CodeFound{data::smoothing_codes()[0], true};
}

std::string cosmology_text(const std::string& path) {
  const AttributeGroups groups(path);
  if (groups.number("Cosmology", "Cosmological run").value_or(0) == 1) {
    const auto scale = groups.number("Cosmology", "Scale-factor");
    return scale && *scale != 1 ? fmt::format("of the scale factor ({:.6g})", *scale)
                                : std::string();
  }
  if (groups.has("Cosmology")) return {};  // SWIFT's, of another run
  const auto redshift = groups.number("Header", "Redshift");
  const auto time = groups.number("Header", "Time");
  const double hubble = groups.number("Header", "HubbleParam").value_or(1);
  // In a cosmological run the time is the scale factor.
  constexpr double kSame = 1e-3;
  if (!redshift || !time || !(std::abs(*time * (1 + *redshift) - 1) < kSame) ||
      !(groups.number("Header", "Omega0").value_or(1) > 0))
    return {};
  const bool has_scale = std::abs(*time - 1) > kSame, has_hubble = hubble > 0 && hubble != 1;
  return fmt::format("{}{}{}",
                     has_scale ? fmt::format("of the scale factor ({:.6g})", *time) : std::string(),
                     has_scale && has_hubble ? " and " : "",
                     has_hubble ? fmt::format("of Hubble's h ({:.6g})", hubble) : std::string());
}

}  // namespace ovoid::io
#endif
