// SPDX-License-Identifier: Apache-2.0
#include "io/images/tiff_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <utility>

#include "io/core/length_units.h"
#include "io/core/number_fields.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/core/xml_tags.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// A whole number from 0; empty for another text.
std::optional<std::int64_t> count_in(std::string_view text) {
  const std::optional<double> value = parse_field(text);
  constexpr double kMost = 2147483647;
  if (!value || !(*value >= 0 && *value <= kMost) || *value != std::floor(*value))
    return std::nullopt;
  return static_cast<std::int64_t>(*value);
}

std::optional<double> length_in(std::string_view text) {
  const std::optional<double> value = parse_field(text);
  if (!value || !std::isfinite(*value) || !(*value > 0)) return std::nullopt;
  return value;
}

// Red, green, blue and opacity, the bytes of a signed number.
std::optional<std::array<double, 3>> color_in(std::string_view text) {
  const std::optional<double> value = parse_field(text);
  if (!value || !(std::abs(*value) <= 0xFFFFFFFF) || *value != std::floor(*value))
    return std::nullopt;
  const auto bits = static_cast<std::uint32_t>(static_cast<std::int64_t>(*value));
  return channel_color({static_cast<std::uint8_t>(bits >> 24),
                        static_cast<std::uint8_t>(bits >> 16),
                        static_cast<std::uint8_t>(bits >> 8)});
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

// A value of an XML attribute with its entities put in: the five of XML, and numbers.
std::string with_entities_read(std::string text) {
  for (const auto& [entity, character] : {std::pair{"&lt;", "<"},
                                          {"&gt;", ">"},
                                          {"&quot;", "\""},
                                          {"&apos;", "'"},
                                          {"&#181;", "\xc2\xb5"},
                                          {"&#xB5;", "\xc2\xb5"},
                                          {"&#xb5;", "\xc2\xb5"},
                                          {"&amp;", "&"}})
    replace_all(text, entity, character);
  return text;
}

std::string local_name(const std::string& tag) {
  const std::size_t colon = tag.find(':');
  if (colon == std::string::npos) return tag;
  return (tag.starts_with('/') ? "/" : "") + tag.substr(colon + 1);
}

// One Pixels element while its description is read.
struct OmePixels {
  TiffStack stack;
  std::string order = "XYZCT";
  std::int64_t samples_in_pixel = 1;  // of a channel
  std::int64_t num_samples = 1;       // SizeC
  struct Planes {
    std::int64_t directory = 0, z = 0, channel = 0, frame = 0;
    std::optional<std::int64_t> count;
    bool has_directory = false;
  };
  std::vector<Planes> planes;
};

class OmeReader {
 public:
  OmeReader(const std::string& file, const std::string& description)
      : file_(file),
        source_(
            open_memory(file + ": its OME description", std::as_bytes(std::span(description)))) {}

  std::vector<TiffStack> run() {
    XmlTagReader tags(*source_);
    while (const auto tag = tags.next()) add(*tag);
    if (files_.size() > 1) {
      throw Error(
          ErrorCode::kUnsupported,
          fmt::format("{}: its planes lie in {} files ({}, ...), which are not put together: "
                      "write one OME-TIFF of them",
                      file_, files_.size(), *files_.begin()));
    }
    if (images_.empty()) fail("names no image");
    std::vector<TiffStack> stacks;
    std::int64_t next = 0;  // page behind the images before
    for (OmePixels& image : images_) {
      place_planes(image, next);
      next += image.stack.num_planes();
      stacks.push_back(std::move(image.stack));
    }
    return stacks;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: its OME description {}", file_, what));
  }

  void add(const XmlTag& tag) {
    const std::string name = local_name(tag.name);
    if (name == "Image") {
      image_name_ = with_entities_read(tag.attribute("Name"));
    } else if (name == "Pixels") {
      add_pixels(tag);
    } else if (images_.empty() || !is_inside_) {
      return;
    } else if (name == "/Pixels") {
      is_inside_ = false;
    } else if (name == "Channel") {
      OmePixels& image = images_.back();
      if (image.stack.channels.size() < kMostChannels) {
        image.stack.channels.push_back({with_entities_read(tag.attribute("Name")),
                                        {color_in(tag.attribute("Color")), std::nullopt}});
      }
      if (const auto samples = count_in(tag.attribute("SamplesPerPixel")); samples.value_or(0) > 0)
        image.samples_in_pixel = *samples;
    } else if (name == "TiffData") {
      add_planes(tag);
    } else if (name == "UUID") {
      const std::string file = tag.attribute("FileName");
      if (!file.empty() && files_.size() < kMostFiles) files_.insert(file);
    }
  }

  void add_pixels(const XmlTag& tag) {
    if (images_.size() == kMostImages) fail(fmt::format("has more than {} images", kMostImages));
    OmePixels& image = images_.emplace_back();
    is_inside_ = !tag.is_empty_element;
    TiffStack& stack = image.stack;
    stack.name = image_name_.empty() ? fmt::format("image {}", images_.size()) : image_name_;
    const auto size = [&](const char* attribute) {
      const auto value = count_in(tag.attribute(attribute));
      if (value.value_or(0) == 0)
        fail(fmt::format("has {} '{}': expected 1 or more", attribute, tag.attribute(attribute)));
      return *value;
    };
    stack.num_slices = size("SizeZ");
    stack.num_frames = size("SizeT");
    image.num_samples = size("SizeC");
    image.order = tag.attribute("DimensionOrder", "XYZCT");
    std::string letters = image.order;
    std::sort(letters.begin(), letters.end());
    if (!image.order.starts_with("XY") || letters != "CTXYZ")
      fail(fmt::format("has DimensionOrder '{}': expected XY and then Z, C and T", image.order));
    const char* const axes[] = {"X", "Y", "Z"};
    std::array<std::string, 3> units;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string key = std::string("PhysicalSize") + axes[axis];
      stack.spacing[axis] = length_in(tag.attribute(key));
      units[axis] = plain_unit(with_entities_read(tag.attribute(key + "Unit", "um")));
    }
    // Lengths in the unit of the first.
    stack.length_unit = stack.spacing[0] ? units[0] : std::string();
    const auto first = metres_in(units[0]);
    for (std::size_t axis = 1; axis < 3; ++axis) {
      const auto own = metres_in(units[axis]);
      if (stack.spacing[axis] && first && own && units[axis] != units[0])
        *stack.spacing[axis] *= *own / *first;
    }
    if (const auto step = length_in(tag.attribute("TimeIncrement"))) {
      stack.frame_interval = step;
      stack.time_unit = with_entities_read(tag.attribute("TimeIncrementUnit", "s"));
    }
  }

  void add_planes(const XmlTag& tag) {
    OmePixels& image = images_.back();
    if (image.planes.size() == kMaxTiffPages) fail("has more planes than are read");
    const auto number = [&](const char* attribute) {
      return count_in(tag.attribute(attribute)).value_or(0);
    };
    OmePixels::Planes planes;
    planes.has_directory = !tag.attribute("IFD").empty();
    planes.directory = number("IFD");
    planes.z = number("FirstZ");
    planes.channel = number("FirstC");
    planes.frame = number("FirstT");
    planes.count = count_in(tag.attribute("PlaneCount"));
    image.planes.push_back(planes);
  }

  // Axes' numbers of planes, fastest first, and what they are: 0 slices, 1 channels, 2 frames.
  static std::array<std::size_t, 3> axes_of(const OmePixels& image) {
    std::array<std::size_t, 3> axes{};
    for (std::size_t i = 0; i < 3; ++i) {
      const char letter = image.order[2 + i];
      axes[i] = letter == 'Z' ? 0 : letter == 'C' ? 1 : 2;
    }
    return axes;
  }

  void place_planes(OmePixels& image, std::int64_t first) const {
    TiffStack& stack = image.stack;
    stack.num_channels = std::max<std::int64_t>(1, image.num_samples / image.samples_in_pixel);
    const std::array sizes{stack.num_slices, stack.num_channels, stack.num_frames};
    const auto num_planes = checked_product(sizes);
    if (!num_planes || *num_planes > static_cast<std::int64_t>(kMaxTiffPages)) {
      fail(fmt::format("has {} x {} x {} planes: at most {} are read", sizes[0], sizes[1], sizes[2],
                       kMaxTiffPages));
    }
    if (static_cast<std::int64_t>(stack.channels.size()) != stack.num_channels)
      stack.channels.clear();
    const std::array<std::size_t, 3> axes = axes_of(image);
    std::int64_t stride = 1;
    for (const std::size_t axis : axes) {
      stack.strides[axis] = stride;
      stride *= sizes[axis];
    }
    stack.first = first;
    const bool is_plain =
        image.planes.empty() || (image.planes.size() == 1 && image.planes[0].directory == 0 &&
                                 image.planes[0].z == 0 && image.planes[0].channel == 0 &&
                                 image.planes[0].frame == 0 && !image.planes[0].has_directory);
    if (is_plain) return;
    stack.directories.assign(static_cast<std::size_t>(*num_planes), -1);
    std::int64_t left = 2 * *num_planes;  // a plane may be named twice, but not again and again
    for (const OmePixels::Planes& planes : image.planes) {
      left -= set_planes(image.stack, planes, axes);
      if (left < 0) fail("names its planes again and again");
    }
  }

  // A run of planes, in the order of the axes from the first one on. Returns how many.
  static std::int64_t set_planes(TiffStack& stack, const OmePixels::Planes& planes,
                                 const std::array<std::size_t, 3>& axes) {
    const std::array sizes{stack.num_slices, stack.num_channels, stack.num_frames};
    std::array<std::int64_t, 3> at{planes.z, planes.channel, planes.frame};
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (at[axis] >= sizes[axis]) return 0;
    // Without a number of planes: one, if a page is named, else all.
    const std::int64_t count = planes.count.value_or(planes.has_directory ? 1 : stack.num_planes());
    for (std::int64_t i = 0; i < count; ++i) {
      stack.directories[static_cast<std::size_t>((at[2] * sizes[1] + at[1]) * sizes[0] + at[0])] =
          planes.directory + i;
      std::size_t axis = 0;
      while (axis < 3 && ++at[axes[axis]] == sizes[axes[axis]]) at[axes[axis++]] = 0;
      if (axis == 3) return i + 1;
    }
    return count;
  }

  static constexpr std::size_t kMostImages = 1000, kMostChannels = 10'000, kMostFiles = 1000;

  const std::string& file_;
  std::unique_ptr<ByteSource> source_;
  std::vector<OmePixels> images_;
  std::string image_name_;
  bool is_inside_ = false;  // a Pixels element
  std::set<std::string> files_;
};

}  // namespace

std::int64_t TiffStack::page(std::int64_t z, std::int64_t channel, std::int64_t frame) const {
  if (directories.empty())
    return first + z * strides[0] + channel * strides[1] + frame * strides[2];
  return directories[static_cast<std::size_t>((frame * num_channels + channel) * num_slices + z)];
}

namespace {

using ImageJValues = std::map<std::string, std::string>;

ImageJValues imagej_values(std::string_view description) {
  ImageJValues values;
  while (!description.empty()) {
    const std::size_t end = std::min(description.find('\n'), description.size());
    const std::string_view line = description.substr(0, end);
    description.remove_prefix(std::min(end + 1, description.size()));
    if (const std::size_t equals = line.find('='); equals != std::string_view::npos)
      values.emplace(lower(trimmed(line.substr(0, equals))), trimmed(line.substr(equals + 1)));
  }
  return values;
}

// Which page is which. Where numbers and pages contradict each other, the pages are slices.
void order_imagej_pages(const TiffFile& file, ImageJValues& values, TiffStack& stack) {
  const auto count = [&](const char* key) {
    return std::max<std::int64_t>(1, count_in(values[key]).value_or(1));
  };
  std::array sizes{count("slices"), count("channels"), count("frames")};
  const auto num_pages = static_cast<std::int64_t>(file.pages().size());
  const std::int64_t num_told = checked_product(sizes).value_or(0);
  const std::int64_t num_images = num_pages > 1 ? num_pages : std::max(num_told, count("images"));
  // Samples of a pixel may be told as channels.
  if (sizes[1] == file.pages()[0].num_samples && sizes[0] * sizes[2] == num_images) sizes[1] = 1;
  if (checked_product(sizes).value_or(0) != num_images) {
    if (num_told > 1) {
      stack.notes.push_back(fmt::format(
          "its description names {} slices, {} channels and {} time steps, and it has {} pages: "
          "these are taken as slices",
          sizes[0], sizes[1], sizes[2], num_images));
    }
    sizes = {num_images, 1, 1};
  }
  stack.num_slices = sizes[0];
  stack.num_channels = sizes[1];
  stack.num_frames = sizes[2];
  // The axis that changes fastest comes first.
  std::string order = lower(values["order"]);
  std::string letters = order;
  std::sort(letters.begin(), letters.end());
  if (letters != "ctz") order = "czt";
  std::int64_t stride = 1;
  for (const char letter : order) {
    const std::size_t axis = letter == 'z' ? 0 : letter == 'c' ? 1 : 2;
    stack.strides[axis] = stride;
    stride *= sizes[axis];
  }
}

// A straight line from stored to calibrated values. Others are told, and the values are the stored
// ones. Floats have none.
void calibrate_imagej_values(const TiffFile& file, ImageJValues& values, TiffStack& stack) {
  const ScalarType type = file.pages()[0].type;
  const auto function = parse_field(values["cf"]);
  if (!function || std::isnan(*function) || is_floating(type) || file.pages()[0].num_samples > 1)
    return;
  const auto c0 = parse_field(values["c0"]), c1 = parse_field(values["c1"]);
  if (*function != 0 || !c0 || !c1 || !std::isfinite(*c0) || !std::isfinite(*c1) || *c1 == 0) {
    stack.notes.push_back(
        fmt::format("has a calibration of values that is no straight line (function {:g}), which "
                    "is not read: values are those that it stores",
                    *function));
    return;
  }
  // ImageJ keeps signed samples of 16 bits without a sign, and its function is of these.
  constexpr double kSignedFrom = 32768;
  stack.value_scale = *c1;
  stack.value_offset = *c0 + (type == ScalarType::kInt16 ? *c1 * kSignedFrom : 0);
  stack.value_unit = values["vunit"];
  if (stack.value_unit == "Gray Value" || stack.value_unit == "gray value")
    stack.value_unit.clear();
}

void place_imagej_pages(const TiffFile& file, ImageJValues& values, TiffStack& stack) {
  stack.length_unit = plain_unit(values["unit"]);
  constexpr int kCentimetre = 3;
  if (const auto& resolution = file.resolution()) {
    // Centimetres beside another unit of length are those of the page.
    const auto metres = metres_in(stack.length_unit);
    const double scale =
        resolution->unit == kCentimetre && stack.length_unit == "um" && metres ? 0.01 / *metres : 1;
    stack.spacing = {scale / resolution->x, scale / resolution->y, 1.0};
  }
  // Stacks that were taken downwards have a spacing below 0.
  if (const auto distance = parse_field(values["spacing"]);
      distance && std::isfinite(*distance) && *distance != 0)
    stack.spacing[2] = std::abs(*distance);
  const auto rate = length_in(values["fps"]);
  const auto interval = length_in(values["finterval"]);
  if (!interval && !rate) return;
  stack.frame_interval = interval ? *interval : 1 / *rate;
  stack.time_unit = values["tunit"].empty() ? "s" : values["tunit"];
}

}  // namespace

std::optional<TiffStack> imagej_stack(const TiffFile& file) {
  std::string description = file.description();
  if (!description.starts_with("ImageJ=")) {
    // A second description, behind another program's.
    for (const std::string& other : file.descriptions(file.pages()[0]))
      if (other.starts_with("ImageJ=")) description = other;
  }
  if (!description.starts_with("ImageJ=")) return std::nullopt;
  ImageJValues values = imagej_values(description);
  TiffStack stack;
  order_imagej_pages(file, values, stack);
  place_imagej_pages(file, values, stack);
  calibrate_imagej_values(file, values, stack);
  return stack;
}

bool looks_like_ome(std::string_view description) noexcept {
  const std::string_view start = description.substr(0, 4096);
  return (start.starts_with("<?xml") || start.starts_with("<OME") || start.starts_with("<ome")) &&
         start.find("OME") != std::string_view::npos;
}

std::vector<TiffStack> ome_stacks(const std::string& file, const std::string& description) {
  return OmeReader(file, description).run();
}

std::string unread_tiff_program(const TiffFile& file) {
  // Fields that programs have registered, or take without.
  static constexpr std::pair<std::uint16_t, const char*> kFields[] = {
      {34412, "Zeiss LSM"},     {33629, "MetaMorph (STK)"}, {34361, "Olympus FluoView"},
      {51123, "Micro-Manager"}, {33560, "Olympus SIS"},     {65420, "Hamamatsu NDPI"},
      {34118, "Zeiss SEM"},     {34680, "FEI SEM"},         {34682, "FEI SEM"},
      {37706, "TVIPS"},         {33550, "GeoTIFF"},         {34264, "GeoTIFF"},
      {50838, "ImageJ"}};
  for (const auto& [tag, program] : kFields)
    if (file.has_field(tag)) return program;
  static constexpr std::pair<std::string_view, const char*> kTexts[] = {
      {"frameNumbers = ", "ScanImage"}, {"state.config", "ScanImage"},
      {"scanimage.SI", "ScanImage"},    {"Aperio ", "Aperio SVS"},
      {"<MetaData>", "MetaMorph"},      {"ImageJ", "ImageJ"},
      {"{\"shape\"", "tifffile"},       {"<PerkinElmer-QPI", "PerkinElmer QPI"}};
  const std::string_view start = std::string_view(file.description()).substr(0, 4096);
  for (const auto& [text, program] : kTexts)
    if (start.find(text) != std::string_view::npos) return program;
  return {};
}

}  // namespace ovoid::io
