// SPDX-License-Identifier: Apache-2.0
// Parts of pictures as deep OpenEXR files. Whoever reads one may have it from anywhere: sizes and
// counts are checked before anything is allocated for them.
#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <new>
#include <vector>

#include "io/core/atomic_file.h"
#include "io/core/memory.h"
#include "io/pictures/exr_stream.h"
#include "io/pictures/exr_structure.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/space_part.h"

namespace ovoid {
namespace {

using Run = DeepImage::Run;

struct RunChannel {
  const char* name;
  Imf::PixelType type;
  std::size_t at;  // in a Run
};

constexpr std::array<RunChannel, 9> kChannels = {{
    {"R", Imf::FLOAT, offsetof(Run, rgba)},
    {"G", Imf::FLOAT, offsetof(Run, rgba) + 4},
    {"B", Imf::FLOAT, offsetof(Run, rgba) + 8},
    {"A", Imf::FLOAT, offsetof(Run, rgba) + 12},
    {"Z", Imf::FLOAT, offsetof(Run, front_depth)},
    {"half_opacity.Z", Imf::FLOAT, offsetof(Run, depth)},
    {"coverage", Imf::FLOAT, offsetof(Run, coverage)},
    // The format knows no numbers below 0: they are those of 32 bits without a sign.
    {"sheet.first", Imf::UINT, offsetof(Run, first)},
    {"sheet.last", Imf::UINT, offsetof(Run, last)},
}};
static_assert(sizeof(float) == 4 && sizeof(Run::first) == 4);

struct ModeWord {
  Mode mode;
  const char* word;
};

// What files call the modes.
constexpr std::array<ModeWord, 6> kModeWords = {{
    {Mode::kComposite, "composite"},
    {Mode::kXray, "x-ray"},
    {Mode::kMaximum, "maximum"},
    {Mode::kMean, "mean"},
    {Mode::kIsosurface, "isosurface"},
    {Mode::kMinimum, "minimum"},
}};

constexpr bool has_every_mode() {
  for (std::size_t i = 0; i < kModeWords.size(); ++i)
    if (kModeWords[i].mode != static_cast<Mode>(i)) return false;
  return true;
}
static_assert(has_every_mode());
static_assert(kModeWords.size() == static_cast<std::size_t>(Mode::kMinimum) + 1);  // the last

const char* word_of(Mode mode) { return kModeWords[static_cast<std::size_t>(mode)].word; }

[[noreturn]] void refuse_part(const std::string& path, const std::string& message) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", path, message));
}

// Where a row's runs are, as OpenEXR wants to know: for each channel and pixel a pointer.
class RowPointers {
 public:
  explicit RowPointers(std::size_t width) : counts_(width) {
    for (std::vector<char*>& pointers : pointers_) pointers.resize(width);
  }

  // The same slices for every row: what they point to is set row by row.
  Imf::DeepFrameBuffer frame_buffer() {
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts_.data()), sizeof(unsigned int), 0));
    for (std::size_t c = 0; c < kChannels.size(); ++c)
      frame.insert(kChannels[c].name,
                   Imf::DeepSlice(kChannels[c].type, reinterpret_cast<char*>(pointers_[c].data()),
                                  sizeof(char*), 0, sizeof(Run)));
    return frame;
  }

  // `runs`: where those of the row's first pixel begin. OpenEXR writes through the pointers only
  // where it reads a file.
  void set_row(const std::uint32_t* first, const Run* runs) {
    for (std::size_t x = 0; x < counts_.size(); ++x) {
      counts_[x] = first[x + 1] - first[x];
      const auto* const begin = reinterpret_cast<const char*>(runs + (first[x] - first[0]));
      for (std::size_t c = 0; c < kChannels.size(); ++c)
        pointers_[c][x] = const_cast<char*>(begin) + kChannels[c].at;
    }
  }

  unsigned int count(std::size_t x) const { return counts_[x]; }

 private:
  std::vector<unsigned int> counts_;
  std::array<std::vector<char*>, kChannels.size()> pointers_;
};

std::string text_attribute(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* const attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
  if (attribute == nullptr)
    refuse_part(
        path, fmt::format("has no attribute '{}': no part that ovoid render --part writes", name));
  return attribute->value();
}

int number_attribute(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* const attribute = header.findTypedAttribute<Imf::IntAttribute>(name);
  if (attribute == nullptr)
    refuse_part(
        path, fmt::format("has no attribute '{}': no part that ovoid render --part writes", name));
  return attribute->value();
}

void require_channels(const Imf::Header& header, const std::string& path) {
  for (const RunChannel& channel : kChannels) {
    const Imf::Channel* const found = header.channels().findChannel(channel.name);
    if (found == nullptr || found->type != channel.type || found->xSampling != 1 ||
        found->ySampling != 1)
      refuse_part(path,
                  fmt::format("has no channel '{}' of the kind that parts have", channel.name));
  }
}

// Messages may repeat what is in the file.
std::string in_one_line(std::string text) {
  for (char& c : text) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = ' ';
  }
  return text;
}

PicturePart part_of_header(const Imf::Header& header, const std::string& path) {
  require_channels(header, path);
  const Imath::Box2i& window = header.dataWindow();
  PicturePart part;
  part.number = number_attribute(header, "ovoid.part", path);
  part.count = number_attribute(header, "ovoid.parts", path);
  if (part.count < 1 || part.count > kMostParts || part.number < 1 || part.number > part.count)
    refuse_part(path, fmt::format("part {} of {}: must be 1 to {} parts", part.number, part.count,
                                  kMostParts));
  part.picture = text_attribute(header, "ovoid.picture", path);
  part.look = look_from_text(text_attribute(header, "ovoid.look", path), path + ": ovoid.look");
  const std::string mode = text_attribute(header, "ovoid.mode", path);
  const auto* const known =
      std::find_if(kModeWords.begin(), kModeWords.end(),
                   [&](const ModeWord& candidate) { return candidate.word == mode; });
  if (known == kModeWords.end()) refuse_part(path, "ovoid.mode: an unknown mode");
  part.seen.mode = known->mode;
  part.seen.width = window.max.x + 1;
  part.seen.height = window.max.y + 1;
  return part;
}

// All rows' counts first, so that their sum is known before memory is asked for.
void read_counts(Imf::DeepScanLineInputFile& file, RowPointers& row, DeepImage& seen,
                 const std::string& path, const std::stop_token& stop) {
  const auto width = static_cast<std::size_t>(seen.width);
  std::uint64_t sum = 0;
  for (int y = 0; y < seen.height; ++y) {
    io::check_stop(stop);
    file.readPixelSampleCounts(y, y);
    for (std::size_t x = 0; x < width; ++x) {
      if (row.count(x) > kMostParts)
        refuse_part(path, fmt::format("pixel {}, {}: {} runs, must be at most {}", x, y,
                                      row.count(x), kMostParts));
      sum += row.count(x);
      if (sum > 0xFFFFFFFFU) refuse_part(path, "more runs than 32 bits can count");
      seen.first.push_back(static_cast<std::uint32_t>(sum));
    }
  }
}

void read_runs(Imf::DeepScanLineInputFile& file, const std::string& path, DeepImage& seen,
               const std::stop_token& stop) {
  const auto width = static_cast<std::size_t>(seen.width);
  seen.first.reserve(width * static_cast<std::size_t>(seen.height) + 1);
  seen.first.push_back(0);
  RowPointers row(width);
  file.setFrameBuffer(row.frame_buffer());
  read_counts(file, row, seen, path, stop);
  const std::uint64_t bytes = std::uint64_t{seen.first.back()} * sizeof(Run);
  io::require_memory(path + ": its runs", static_cast<std::int64_t>(bytes));
  seen.runs.resize(seen.first.back());
  for (int y = 0; y < seen.height; ++y) {
    io::check_stop(stop);
    const std::uint32_t* const first = &seen.first[static_cast<std::size_t>(y) * width];
    file.readPixelSampleCounts(y, y);
    row.set_row(first, seen.runs.data() + first[0]);
    file.readPixels(y, y);
  }
}

}  // namespace

void write_picture_part(const PicturePart& part, const std::string& path,
                        const WriteOptions& options) {
  part.seen.validate();
  io::check_writable(path);
  io::ExrStream stream(path);
  const auto width = static_cast<std::size_t>(part.seen.width);
  try {
    Imf::Header header(part.seen.width, part.seen.height);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    for (const RunChannel& channel : kChannels)
      header.channels().insert(channel.name, Imf::Channel(channel.type));
    header.insert("ovoid.part", Imf::IntAttribute(part.number));
    header.insert("ovoid.parts", Imf::IntAttribute(part.count));
    header.insert("ovoid.picture", Imf::StringAttribute(part.picture));
    header.insert("ovoid.look", Imf::StringAttribute(to_text(part.look)));
    header.insert("ovoid.mode", Imf::StringAttribute(word_of(part.seen.mode)));
    Imf::DeepScanLineOutputFile file(stream, header, 0);
    RowPointers row(width);
    file.setFrameBuffer(row.frame_buffer());
    for (int y = 0; y < part.seen.height; ++y) {
      io::check_stop(options.stop);
      const std::uint32_t* const first = &part.seen.first[static_cast<std::size_t>(y) * width];
      row.set_row(first, part.seen.runs.data() + first[0]);
      file.writePixels(1);
    }
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, fmt::format("{}: no memory to pack it", path));
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kFileWrite,
                fmt::format("{}: cannot be written: OpenEXR: {}", path, error.what()));
  }
  io::write_atomically(path, stream.bytes(), options.stop);
}

PicturePart read_picture_part(const std::string& path, std::stop_token stop) try {
  io::require_deep_structure(*io::open_file(path));
  io::ExrSource source(path);
  Imf::DeepScanLineInputFile file(source, 0);
  PicturePart part = part_of_header(file.header(), path);
  read_runs(file, path, part.seen, stop);
  part.seen.validate();
  return part;
} catch (const Error& error) {
  if (error.code() == ErrorCode::kFileFormat) throw Error(error.code(), in_one_line(error.what()));
  if (error.code() != ErrorCode::kInvalidArgument) throw;
  throw Error(ErrorCode::kFileFormat, in_one_line(fmt::format("{}: {}", path, error.what())));
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory, fmt::format("{}: no memory for its runs", path));
} catch (const std::exception& error) {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: cannot be read as a part of a picture: OpenEXR: {}", path,
                          in_one_line(error.what())));
}

}  // namespace ovoid
