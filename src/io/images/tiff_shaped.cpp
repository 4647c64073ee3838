// SPDX-License-Identifier: Apache-2.0
#include "io/images/tiff_shaped.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "io/core/axis_order.h"
#include "io/core/json_file.h"
#include "io/core/length_units.h"
#include "io/core/number_fields.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr char kUnknownAxis = '?';
constexpr std::size_t kMostShapedAxes = 32;

// The description that JSON holds, or that a tuple does ("shape=(7, 5, 6)"), as the first versions
// wrote it. Nothing for another text.
std::optional<Json> shaped_json(const std::string& text) {
  constexpr std::string_view kTuple = "shape=(";
  if (text.starts_with(kTuple)) {
    std::string numbers = text.substr(kTuple.size(), text.find(')') - kTuple.size());
    std::replace(numbers.begin(), numbers.end(), ',', ' ');
    Json shape = Json::array();
    for (const std::string_view word : words(numbers))
      shape.push_back(parse_number<std::int64_t>(word).value_or(0));
    return Json{{"shape", std::move(shape)}};
  }
  if (!text.starts_with('{') || text.size() > kMaxJsonBytes ||
      text.find("\"shape\"") == std::string::npos)
    return std::nullopt;
  try {
    Json json = parse_json(text, "description");
    return json.is_object() ? std::optional(std::move(json)) : std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<Json> shaped_json(const TiffFile& file, std::size_t page) {
  for (const std::string& text : file.descriptions(file.pages()[page]))
    if (auto json = shaped_json(text)) return json;
  return std::nullopt;
}

std::string text_of_key(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

// A length that is not 0, without its sign; numbers may be written as text.
std::optional<double> length_of_key(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) return std::nullopt;
  const std::optional<double> value = found->is_number() ? std::optional(found->get<double>())
                                                         : parse_field(text_of_key(json, key));
  if (!value || !std::isfinite(*value) || *value == 0) return std::nullopt;
  return std::abs(*value);
}

// One series: the array of a call of the writer's.
class ShapedReader {
 public:
  ShapedReader(const TiffFile& file, std::size_t first_page, const Json& json)
      : page_(file.pages()[first_page]),
        resolution_(file.resolution()),
        json_(json),
        num_pages_(static_cast<std::int64_t>(file.pages().size() - first_page)),
        has_one_directory_(file.pages().size() == 1) {
    stack_.first = static_cast<std::int64_t>(first_page);
  }

  // `are_slices`: pages behind the series contradict it.
  TiffStack run(bool are_slices) {
    stack_.name = text_of_key(json_, "name");
    read_lengths();
    read_times();
    read_channels();
    read_shape();
    if (are_slices || !fit_page()) {
      take_pages_as_slices("does not fit its pages");
      return std::move(stack_);
    }
    name_axes();
    return std::move(stack_);
  }

 private:
  void note(std::string what) { stack_.notes.push_back(std::move(what)); }

  std::string shape_text() const { return fmt::format("({})", fmt::join(told_shape_, ", ")); }

  void take_pages_as_slices(const char* why) {
    stack_.num_slices = num_pages_;
    stack_.num_channels = stack_.num_frames = 1;
    stack_.order.clear();
    stack_.shape.clear();
    note(fmt::format("the shape of its description, {}, {}: its {} pages are taken as slices",
                     shape_text(), why, num_pages_));
  }

  void read_shape() {
    const Json& shape = json_["shape"];
    if (shape.is_array() && shape.size() <= kMostShapedAxes) {
      for (const Json& size : shape) {
        const auto value = size.is_number_integer() ? size.get<std::int64_t>() : 0;
        told_shape_.push_back(std::clamp<std::int64_t>(value, 0, kMaxAxisSize));
      }
    }
    sizes_ = told_shape_;
    const std::string axes = text_of_key(json_, "axes");
    if (axes.size() == sizes_.size()) {
      letters_ = axes;
    } else {
      letters_.assign(sizes_.size(), kUnknownAxis);
      if (!axes.empty())
        note(
            fmt::format("its axes '{}' do not fit its shape {}", axes.substr(0, 40), shape_text()));
    }
    has_names_ = axes.size() == sizes_.size() && !axes.empty();
  }

  // Do the last axes make a page, and those before as many pages as there are? Takes these last
  // ones off, but for height and width.
  bool fit_page() {
    const std::size_t num_page_axes = page_.num_samples > 1 ? 3 : 2;
    const std::array<std::int64_t, 3> together{page_.height, page_.width, page_.num_samples};
    const std::array<std::int64_t, 3> in_planes{page_.num_samples, page_.height, page_.width};
    const auto& page_sizes = page_.is_planar ? in_planes : together;
    const auto fits = [&] {
      return sizes_.size() >= num_page_axes &&
             std::equal(page_sizes.begin(), page_sizes.begin() + num_page_axes,
                        sizes_.end() - static_cast<std::ptrdiff_t>(num_page_axes));
    };
    // The writer leaves out last axes of one sample.
    while (!fits() && !sizes_.empty() && sizes_.back() == 1) take_off(sizes_.size() - 1);
    if (!fits()) return false;
    if (page_.num_samples > 1) take_off(page_.is_planar ? sizes_.size() - 3 : sizes_.size() - 1);
    const auto leading = std::span(sizes_).first(sizes_.size() - 2);
    const std::int64_t num_planes = checked_product(leading).value_or(kMaxNumBytes);
    // One directory may stand for planes behind each other: the samples tell.
    return num_planes >= 1 && num_planes <= static_cast<std::int64_t>(kMaxTiffPages) &&
           (num_planes <= num_pages_ || has_one_directory_);
  }

  void take_off(std::size_t axis) {
    sizes_.erase(sizes_.begin() + static_cast<std::ptrdiff_t>(axis));
    letters_.erase(axis, 1);
  }

  void name_axes() {
    const std::string told = letters_;
    for (std::size_t a = 0; a < letters_.size(); ++a) {
      const std::string letter = lower(letters_.substr(a, 1));
      letters_[a] = kAxisLetters.find(letter) != std::string_view::npos &&
                            letters_.substr(0, a).find(letter) == std::string::npos
                        ? letter[0]
                        : kUnknownAxis;
      // Samples of a pixel that are pages.
      if (letter == "s" && lower(told).find('c') == std::string::npos &&
          letters_.substr(0, a).find('c') == std::string::npos)
        letters_[a] = 'c';
    }
    const std::size_t y = letters_.size() - 2, x = y + 1;
    if (letters_[y] == kUnknownAxis && letters_.find('y') == std::string::npos) letters_[y] = 'y';
    if (letters_[x] == kUnknownAxis && letters_.find('x') == std::string::npos) letters_[x] = 'x';
    const std::string known = letters_;
    const bool are_named = name_unknown_axes(sizes_, &letters_);
    if (!are_named || letters_.find('y') == std::string::npos ||
        letters_.find('x') == std::string::npos) {
      take_pages_as_slices(has_names_ ? "has axes that are not known" : "has too many axes");
      return;
    }
    tell_names(told, known);
    if (letters_[y] == 'y' && letters_[x] == 'x') return take_planes();
    stack_.order = letters_;
    stack_.shape = sizes_;
    if (page_.num_samples > 1) {
      stack_.order += letters_.find('c') == std::string::npos ? 'c' : kPassedAxis;
      stack_.shape.push_back(page_.num_components);
    }
    stack_.num_slices =
        checked_product(std::span(sizes_).first(sizes_.size() - 2)).value_or(num_pages_);
  }

  // What was guessed, if it was.
  void tell_names(const std::string& told, const std::string& known) {
    std::string order;
    int num_guessed = 0;
    for (std::size_t a = 0; a < letters_.size(); ++a) {
      order += fmt::format("{}{}", a > 0 ? ", " : "", letters_[a]);
      if (known[a] != kUnknownAxis || letters_[a] == kPassedAxis) continue;
      ++num_guessed;
      if (has_names_)
        note(fmt::format("axis {} of its axes '{}' is taken as {}; --axis-order says another",
                         told[a], told, letters_[a]));
    }
    if (!has_names_ && num_guessed > 1)
      note(
          fmt::format("its description names no axes: shape {} is taken as ({}); --axis-order "
                      "says another",
                      shape_text(), order));
  }

  // Pages are (y, x): from page to page go slices, channels and steps.
  void take_planes() {
    stack_.strides = {0, 0, 0};
    std::int64_t stride = 1;
    for (std::size_t a = sizes_.size() - 2; a-- > 0;) {
      const std::size_t kind = letters_[a] == 'z' ? 0 : letters_[a] == 'c' ? 1 : 2;
      if (letters_[a] != kPassedAxis) {
        *std::array{&stack_.num_slices, &stack_.num_channels, &stack_.num_frames}[kind] = sizes_[a];
        stack_.strides[kind] = stride;
      }
      stride *= sizes_[a];
    }
    stack_.shape = sizes_;
    if (page_.num_components > 1) stack_.shape.push_back(page_.num_components);
    if (static_cast<std::int64_t>(stack_.channels.size()) != stack_.num_channels)
      stack_.channels.clear();
  }

  // `spacing` is that of slices; that of pixels is the page's resolution. The unit is that of both,
  // as with ImageJ, but for a resolution per centimetre, which is one.
  void read_lengths() {
    constexpr int kInch = 2, kCentimetre = 3;
    std::string unit = plain_unit(text_of_key(json_, "unit"));
    stack_.spacing[2] = length_of_key(json_, "spacing");
    // Without a unit a resolution is one of print, or what the writer puts where nothing is known.
    const bool is_length = !unit.empty() || (resolution_ && resolution_->unit == kCentimetre) ||
                           (stack_.spacing[2] && resolution_ && resolution_->unit != kInch);
    if (resolution_ && is_length) {
      const auto metres = metres_in(unit);
      double scale = 1;
      if (resolution_->unit == kCentimetre && unit.empty()) {
        unit = "cm";
      } else if (resolution_->unit == kCentimetre && metres) {
        scale = 0.01 / *metres;
      } else if (resolution_->unit == kInch && metres && unit != "inch" && unit != "in") {
        note(
            fmt::format("its resolution says pixels per inch: taken as pixels per {}, the unit of "
                        "its description",
                        unit));
      }
      stack_.spacing[0] = scale / resolution_->x;
      stack_.spacing[1] = scale / resolution_->y;
    }
    stack_.length_unit = unit;
    read_physical_sizes();
  }

  // Keys as OME-XML has them, in the unit of the first.
  void read_physical_sizes() {
    constexpr std::array kAxes{"X", "Y", "Z"};
    std::optional<double> first;  // metres
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string key = std::string("PhysicalSize") + kAxes[i];
      const auto length = length_of_key(json_, key.c_str());
      if (!length) continue;
      const std::string told = text_of_key(json_, (key + "Unit").c_str());
      const std::string unit = plain_unit(told.empty() ? "um" : told);
      const auto metres = metres_in(unit);
      if (!first) {
        first = metres;
        stack_.length_unit = unit;
      }
      stack_.spacing[i] = *length * (first && metres ? *metres / *first : 1);
    }
  }

  void read_times() {
    stack_.frame_interval = length_of_key(json_, "finterval");
    if (const auto rate = length_of_key(json_, "fps"); rate && !stack_.frame_interval)
      stack_.frame_interval = 1 / *rate;
    if (stack_.frame_interval) stack_.time_unit = "s";
    if (const auto step = length_of_key(json_, "TimeIncrement")) {
      stack_.frame_interval = step;
      const std::string unit = text_of_key(json_, "TimeIncrementUnit");
      stack_.time_unit = unit.empty() ? "s" : unit;
    }
  }

  // {"Channel": {"Name": ["DAPI", "GFP"]}}
  void read_channels() {
    const auto channels = json_.find("Channel");
    if (channels == json_.end() || !channels->is_object()) return;
    const auto names = channels->find("Name");
    constexpr std::size_t kMostNames = 10'000;
    if (names == channels->end() || !names->is_array() || names->size() > kMostNames) return;
    for (const Json& name : *names)
      stack_.channels.push_back({name.is_string() ? name.get<std::string>() : std::string(), {}});
  }

  const TiffPage& page_;
  const std::optional<TiffFile::Resolution>& resolution_;
  const Json& json_;
  std::int64_t num_pages_;
  bool has_one_directory_;
  TiffStack stack_;
  std::vector<std::int64_t> told_shape_, sizes_;
  std::string letters_;
  bool has_names_ = false;
};

}  // namespace

bool name_unknown_axes(const std::vector<std::int64_t>& shape, std::string* letters) {
  std::size_t num_unknown = 0;
  for (std::size_t a = 0; a < letters->size(); ++a) {
    char& letter = (*letters)[a];
    if (letter != kUnknownAxis) continue;
    if (shape[a] == 1) letter = kPassedAxis;
    if (letter == kUnknownAxis) ++num_unknown;
  }
  std::string wanted;
  for (const char letter : std::string_view("ztc"))
    if (letters->find(letter) == std::string::npos && wanted.size() < num_unknown) wanted += letter;
  if (wanted.size() < num_unknown) return false;
  for (const char letter : std::string_view("tcz")) {
    if (wanted.find(letter) != std::string::npos)
      *std::find(letters->begin(), letters->end(), kUnknownAxis) = letter;
  }
  return true;
}

std::vector<TiffStack> shaped_stacks(const TiffFile& file) {
  std::vector<TiffStack> stacks;
  const std::size_t num_pages = file.pages().size();
  std::optional<Json> json = shaped_json(file, 0);
  for (std::size_t page = 0; json;) {
    TiffStack& stack = stacks.emplace_back(ShapedReader(file, page, *json).run(false));
    if (stack.name.empty()) stack.name = fmt::format("series {}", stacks.size());
    const auto num_planes = static_cast<std::size_t>(std::max<std::int64_t>(1, stack.num_planes()));
    if (num_planes >= num_pages - page) break;
    std::optional<Json> next = shaped_json(file, page + num_planes);
    if (!next && stacks.size() == 1) {
      stack = ShapedReader(file, page, *json).run(true);
    } else if (!next) {
      stack.notes.push_back(fmt::format("{} pages behind those of its descriptions are left out",
                                        num_pages - page - num_planes));
    }
    page += num_planes;
    json = std::move(next);
  }
  return stacks;
}

}  // namespace ovoid::io
