// SPDX-License-Identifier: Apache-2.0
#include "io/images/slice_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <utility>

#include "io/core/signatures.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

bool is_decimal(char c) noexcept { return c >= '0' && c <= '9'; }

// From `at`, the digits in a row.
std::string_view digits_at(std::string_view text, std::size_t at) noexcept {
  std::size_t end = at;
  while (end < text.size() && is_decimal(text[end])) ++end;
  return text.substr(at, end - at);
}

std::string_view without_zeros(std::string_view digits) noexcept {
  while (digits.size() > 1 && digits.front() == '0') digits.remove_prefix(1);
  return digits;
}

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

// A name without its numbers, and these.
struct NameParts {
  std::string frame;                 // "s#_t#.png"
  std::vector<std::string> numbers;  // without leading zeros
};

NameParts parts_of(const std::string& path) {
  const std::string name = file_name(path);
  NameParts parts;
  for (std::size_t at = 0; at < name.size();) {
    const std::string_view digits = digits_at(name, at);
    if (digits.empty()) {
      parts.frame += name[at++];
      continue;
    }
    parts.frame += '#';
    parts.numbers.emplace_back(without_zeros(digits));
    at += digits.size();
  }
  parts.frame = lower(parts.frame);
  return parts;
}

// Longer numbers are no slices' numbers but stamps of a time or hashes.
constexpr std::size_t kMostDigits = 15;

// The gaps between rising numbers, in words; empty if they rise evenly.
std::string gaps_text(const std::vector<std::int64_t>& numbers) {
  std::int64_t step = numbers.back();
  for (std::size_t i = 1; i < numbers.size(); ++i)
    step = std::min(step, numbers[i] - numbers[i - 1]);
  if (step <= 0) return "some numbers stand twice";
  std::string text;
  std::size_t num_gaps = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    if (numbers[i] - numbers[i - 1] == step) continue;
    constexpr std::size_t kToldGaps = 3;
    if (++num_gaps <= kToldGaps)
      text += fmt::format("{}{} and {}", num_gaps > 1 ? ", " : "", numbers[i - 1], numbers[i]);
  }
  if (num_gaps == 0) return {};
  return fmt::format("no slices between {}{}: the others are put at equal distances", text,
                     num_gaps > 3 ? fmt::format(" and in {} more places", num_gaps - 3) : "");
}

// What is odd about the numbers of slices in their order.
std::vector<std::string> odd_numbers(const std::string& source,
                                     const std::vector<std::string>& paths) {
  std::vector<NameParts> parts;
  parts.reserve(paths.size());
  for (const std::string& path : paths) parts.push_back(parts_of(path));
  for (const NameParts& part : parts)
    if (part.frame != parts[0].frame) return {};  // there is no number that all share
  std::vector<std::size_t> varying;
  for (std::size_t i = 0; i < parts[0].numbers.size(); ++i) {
    const auto differs = [&](const NameParts& part) {
      return part.numbers[i] != parts[0].numbers[i];
    };
    if (std::any_of(parts.begin(), parts.end(), differs)) varying.push_back(i);
  }
  if (varying.size() > 1) {
    return {
        fmt::format("{}: the names of its slices differ in {} numbers ({}, {}, ...): they are "
                    "one volume in this order",
                    source, varying.size(), file_name(paths[0]), file_name(paths[1]))};
  }
  if (varying.empty()) return {};
  std::vector<std::int64_t> numbers;
  for (const NameParts& part : parts) {
    const std::string& digits = part.numbers[varying[0]];
    if (digits.size() > kMostDigits) return {};
    numbers.push_back(std::stoll(digits));
  }
  if (const std::string gaps = gaps_text(numbers); !gaps.empty())
    return {fmt::format("{}: {}", source, gaps)};
  return {};
}

bool is_before_by_name(const std::string& a, const std::string& b) {
  const std::string name_a = file_name(a), name_b = file_name(b);
  return name_a == name_b ? a < b : is_before_naturally(name_a, name_b);
}

}  // namespace

bool is_before_naturally(std::string_view a, std::string_view b) noexcept {
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    const std::string_view digits_a = digits_at(a, i), digits_b = digits_at(b, k);
    if (digits_a.empty() || digits_b.empty()) {
      if (a[i] != b[k]) return a[i] < b[k];
      ++i, ++k;
      continue;
    }
    const std::string_view number_a = without_zeros(digits_a), number_b = without_zeros(digits_b);
    if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
    if (number_a != number_b) return number_a < number_b;
    i += digits_a.size();
    k += digits_b.size();
  }
  if (i < a.size() || k < b.size()) return k < b.size();
  return a.size() < b.size();
}

SliceNames slices_in_order(const std::string& source, std::vector<std::string> paths) {
  SliceNames names;
  const bool was_sorted = std::is_sorted(paths.begin(), paths.end(), is_before_by_name);
  // A shell gives s10 before s2, which is no order that anybody has chosen.
  const bool is_plain = std::is_sorted(paths.begin(), paths.end());
  std::sort(paths.begin(), paths.end(), is_before_by_name);
  names.paths = std::move(paths);
  names.notes = odd_numbers(source, names.paths);
  if (!was_sorted && !is_plain) {
    names.notes.push_back(
        fmt::format("{}: its slices are ordered by the numbers in their names, "
                    "not as they were given",
                    source));
  }
  return names;
}

SliceNames slices_of_folder(const std::string& source, std::vector<std::string> paths) {
  std::map<std::string, std::vector<std::string>> kinds;  // by the frame of the name
  for (std::string& path : paths) kinds[parts_of(path).frame].push_back(std::move(path));
  using Kind = std::pair<const std::string, std::vector<std::string>>;
  const auto most = std::max_element(kinds.begin(), kinds.end(), [](const Kind& a, const Kind& b) {
    return a.second.size() < b.second.size();
  });
  if (most == kinds.end()) return {};
  for (const Kind& kind : kinds) {
    if (&kind == &*most || kind.second.size() < most->second.size()) continue;
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("{}: holds {} files like {} and as many like {}: name the slices of one "
                    "volume alone, or move them to a folder of their own",
                    source, kind.second.size(), file_name(most->second[0]),
                    file_name(kind.second[0])));
  }
  SliceNames names = slices_in_order(source, std::move(most->second));
  names.notes = odd_numbers(source, names.paths);  // nobody has given an order
  for (const Kind& kind : kinds)
    if (&kind != &*most)
      names.left_out.insert(names.left_out.end(), kind.second.begin(), kind.second.end());
  if (!names.left_out.empty()) {
    std::string more;
    if (names.left_out.size() > 1) more = fmt::format(" and {} more", names.left_out.size() - 1);
    names.notes.push_back(fmt::format("{}: {}{} left out: not named as its {} slices", source,
                                      file_name(names.left_out[0]), more, names.paths.size()));
  }
  return names;
}

}  // namespace ovoid::io
