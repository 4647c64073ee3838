// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>
#include <utility>

#include "data/names_text.h"
#include "data/scalar_visit.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/core/signatures.h"
#include "io/core/unpacked_samples.h"
#include "io/dicom/dicom_codec.h"
#include "io/dicom/dicom_file.h"
#include "io/dicom/dicom_pixels.h"
#include "io/dicom/dicom_series.h"
#include "io/formats.h"
#include "io/reader/reader_session.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 100'000;
constexpr int kMaxFolderDepth = 16;

using SharedSource = std::shared_ptr<const ByteSource>;
using SourceOpener = std::function<SharedSource(const std::string&)>;

bool begins_like_dicom(const ByteSource& source) { return looks_like_dicom(source.text(0, 512)); }

// What of the input is no part of a volume.
struct LeftOut {
  std::int64_t num_others = 0;                     // no DICOM
  std::int64_t num_directories = 0;                // DICOMDIR
  std::int64_t num_without_pixels = 0;             // reports
  std::map<std::string, std::int64_t> unreadable;  // by reason

  std::vector<std::string> notes(const std::string& source) const {
    std::vector<std::string> result;
    const auto add = [&](std::int64_t count, const std::string& what) {
      if (count == 0) return;
      result.push_back(fmt::format("{}: {} {} left out: {}", source, count,
                                   count == 1 ? "file is" : "files are", what));
    };
    add(num_others, "no DICOM");
    add(num_directories, "DICOMDIR, the directory of a medium");
    add(num_without_pixels, "DICOM without pixels");
    for (const auto& [reason, count] : unreadable) add(count, reason);
    return result;
  }
};

class DicomReader {
 public:
  DicomReader(std::string source, SourceOpener open, const ReadOptions& options)
      : source_(std::move(source)), open_(std::move(open)), options_(options) {}

  Dataset run(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      if (options_.stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
      add(name);
    }
    if (files_.empty()) refuse_empty(names.size());
    groups_ = group_dicom_frames(files_, [this](const DicomFrame& a, const DicomFrame& b) {
      const SharedSource data_a = data_of(a.file), data_b = data_of(b.file);
      return is_same_dicom_slice(*data_a, files_[a.file], a.frame, *data_b, files_[b.file],
                                 b.frame);
    });
    const std::size_t chosen = choose_group();
    dataset_.notes = left_out_.notes(source_);
    describe(chosen);
    DicomVolume volume = place_dicom_group(files_, std::move(groups_[chosen]));
    if (needs_foreign_decoder(volume)) {
      ReadOptions in_memory = options_;  // the process that decodes may not write
      in_memory.may_stay_in_file = false;
      return read_foreign("DICOM", source_, names, in_memory);
    }
    finish(volume);
    return std::move(dataset_);
  }

 private:
  void add(const std::string& name) {
    const SharedSource file = open_(name);
    if (!begins_like_dicom(*file)) {
      ++left_out_.num_others;
      const std::string format = picture_format_of(file->text(0, 512));
      if (!format.empty()) ++num_pictures_[format];
      if (format_by_content(*file) != nullptr) ++num_readable_;
      return;
    }
    DicomFile parsed = read_dicom_file(*dicom_data_source(file));
    if (parsed.pixels == DicomPixels::kNone) {
      ++(parsed.is_directory ? left_out_.num_directories : left_out_.num_without_pixels);
      return;
    }
    const std::string reason = unreadable_reason(parsed);
    if (reason.empty()) {
      files_.push_back(std::move(parsed));
    } else {
      ++left_out_.unreadable[reason];
    }
  }

  [[noreturn]] void refuse_empty(std::size_t num_files) const {
    if (!left_out_.unreadable.empty()) {
      const auto& [reason, count] = *left_out_.unreadable.begin();
      throw Error(ErrorCode::kUnsupported,
                  num_files == 1 ? fmt::format("{}: {}", source_, reason)
                                 : fmt::format("{}: none of {} files can be read; {} of them: {}",
                                               source_, num_files, count, reason));
    }
    if (left_out_.num_directories > 0) {
      std::error_code ignored;
      const std::string folder = fs::path(source_).parent_path().string();
      throw Error(
          ErrorCode::kUnsupported,
          fs::is_directory(source_, ignored)
              ? fmt::format("{}: holds a DICOMDIR, the directory of a medium, and no images",
                            source_)
              : fmt::format("{}: is a DICOMDIR, the directory of a medium, without images: "
                            "open the folder that it lies in, '{}'",
                            source_, folder.empty() ? "." : folder));
    }
    if (left_out_.num_without_pixels > 0) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: is DICOM, but has no pixel data", source_));
    }
    if (num_files == 0) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: the folder is empty, expected DICOM slices", source_));
    }
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: none of its {} files is DICOM: a folder is read as DICOM slices{}",
                            source_, num_files, advice()));
  }

  // What to do with a folder that holds something else.
  std::string advice() const {
    if (!num_pictures_.empty()) {
      const auto& [format, count] =
          *std::max_element(num_pictures_.begin(), num_pictures_.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; });
      return fmt::format(
          "; {} are {} pictures: stack them into one volume first, as Fiji does (File > Import > "
          "Image Sequence, then Save As > Nrrd)",
          count, format);
    }
    if (num_readable_ == 0) return {};
    return fmt::format("; {} are of other kinds that are read: name the files themselves",
                       num_readable_);
  }

  std::int64_t size_of_group(const DicomGroup& group) const {
    const DicomFrame& first = group.steps[0][0];
    return files_[first.file].slice_rows() * files_[first.file].slice_columns() *
           static_cast<std::int64_t>(group.steps[0].size());
  }

  std::size_t choose_group() const {
    if (options_.block.empty()) {
      const auto largest = std::max_element(
          groups_.begin(), groups_.end(),
          [&](const auto& a, const auto& b) { return size_of_group(a) < size_of_group(b); });
      return static_cast<std::size_t>(largest - groups_.begin());
    }
    std::vector<std::string> names;
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      if (groups_[i].name == options_.block) return i;
      names.push_back(groups_[i].name);
    }
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: block '{}': expected one of {}", source_, options_.block,
                            data::names_text(names)));
  }

  void describe(std::size_t chosen) {
    dataset_.source = source_;
    dataset_.format = "DICOM";
    if (groups_.size() == 1) {
      // One volume has no blocks, but may be asked for by the name that it would have.
      if (!options_.block.empty()) {
        dataset_.blocks.push_back({groups_[0].name, groups_[0].description});
        dataset_.block = groups_[0].name;
      }
      return;
    }
    for (const DicomGroup& group : groups_)
      dataset_.blocks.push_back({group.name, group.description});
    dataset_.block = groups_[chosen].name;
    if (options_.block.empty()) {
      dataset_.notes.push_back(
          fmt::format("{}: {} volumes; the largest, '{}' ({}), is read; choose with --block",
                      source_, groups_.size(), groups_[chosen].name, groups_[chosen].description));
    }
  }

  SharedSource data_of(std::size_t file) const {
    return dicom_data_source(open_(files_[file].name));
  }

  const DicomPlane& plane_of(const DicomFrame& frame) const {
    return files_[frame.file].planes[frame.frame];
  }

  bool needs_foreign_decoder(const DicomVolume& volume) const {
    const auto needs = [&](const DicomFrame& frame) {
      return !frame.is_missing() && files_[frame.file].is_encapsulated &&
             io::needs_foreign_decoder(files_[frame.file].transfer_syntax);
    };
    return std::any_of(volume.steps.begin(), volume.steps.end(), [&](const auto& slices) {
      return std::any_of(slices.begin(), slices.end(), needs);
    });
  }

  void finish(DicomVolume& volume) {
    dataset_.lattice = volume.lattice;
    dataset_.space = volume.space;
    dataset_.num_steps = static_cast<std::int64_t>(volume.steps.size());
    dataset_.times = std::move(volume.times.values);
    if (!dataset_.times.empty()) dataset_.time_unit = volume.times.unit;
    choose_values(volume);
    note_contents(volume);
    for (std::string& note : volume.notes) dataset_.notes.push_back(std::move(note));
    shorten_notes(dataset_.notes);
    read_steps(volume);
  }

  // Stored numbers with one scale, or values where slices have scales of their own or are made of
  // others.
  void choose_values(DicomVolume& volume) {
    const DicomPlane& first = plane_of(first_frame(volume));
    array_.name = "values";
    array_.type = files_[first_frame(volume).file].scalar_type();
    array_.num_tuples = num_samples(volume.lattice.dims);
    array_.unit = unit_of(volume);
    bool is_uniform = true;
    for (const auto& step : volume.steps) {
      for (const DicomFrame& frame : step) {
        if (frame.is_missing()) continue;
        const DicomPlane& plane = plane_of(frame);
        if (plane.slope.value_or(1) == 0) fail(frame, "RescaleSlope 0: expected another number");
        is_uniform = is_uniform && plane.slope.value_or(1) == first.slope.value_or(1) &&
                     plane.intercept.value_or(0) == first.intercept.value_or(0);
      }
    }
    stores_values_ = !is_uniform || volume.is_resampled();
    if (!stores_values_) {
      array_.value_scale = first.slope.value_or(1);
      array_.value_offset = first.intercept.value_or(0);
      return;
    }
    array_.type = size_of(array_.type) <= 2 || array_.type == ScalarType::kFloat32
                      ? ScalarType::kFloat32
                      : ScalarType::kFloat64;
    if (!is_uniform) {
      volume.notes.push_back(
          fmt::format("{}: slices have RescaleSlope and RescaleIntercept of their own: values are "
                      "kept as {}",
                      source_, name_of(array_.type)));
    }
  }

  [[noreturn]] void fail(const DicomFrame& frame, const std::string& what) const {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", files_[frame.file].name, what));
  }

  // The first slice is never missing: a lattice goes from slice to slice.
  static const DicomFrame& first_frame(const DicomVolume& volume) { return volume.steps[0][0]; }

  std::string unit_of(const DicomVolume& volume) const {
    const DicomFile& file = files_[first_frame(volume).file];
    const DicomPlane& plane = plane_of(first_frame(volume));
    if (!file.units.empty()) return file.units;
    if (plane.rescale_type == "US") return {};  // unspecified
    if (!plane.rescale_type.empty()) return plane.rescale_type;
    return file.modality == "CT" && (plane.slope || plane.intercept) ? "HU" : "";
  }

  void note_contents(DicomVolume& volume) const {
    const DicomFile& file = files_[first_frame(volume).file];
    if (file.photometric == "MONOCHROME1") {
      volume.notes.push_back(fmt::format(
          "{}: MONOCHROME1, where large values are meant to be dark: values are kept", file.name));
    }
    if (file.has_modality_lut) {
      volume.notes.push_back(fmt::format(
          "{}: its ModalityLUTSequence is not applied: values are the stored ones", file.name));
    }
  }

  // The step that was asked for, else the first whose samples differ.
  void read_steps(const DicomVolume& volume) {
    const auto num_steps = static_cast<std::int64_t>(volume.steps.size());
    std::int64_t step = options_.step.value_or(0);
    if (step < 0 || step >= num_steps) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: step {}: expected 0 to {}", source_, step, num_steps - 1));
    }
    const std::int64_t first = step;
    for (;; ++step) {
      read_step(volume, static_cast<std::size_t>(step));
      if (options_.step || num_steps == 1 || varies()) break;
      if (step + 1 < num_steps) continue;
      step = first;  // none does
      read_step(volume, static_cast<std::size_t>(step));
      break;
    }
    dataset_.step = step;
    dataset_.arrays.push_back(std::move(array_));
  }

  bool varies() const {
    const auto bytes = array_.bytes.view;
    const std::size_t size = size_of(array_.type);
    return bytes.size() > size &&
           std::memcmp(bytes.data(), bytes.data() + size, bytes.size() - size) != 0;
  }

  void read_step(const DicomVolume& volume, std::size_t step) {
    const std::int64_t num_bytes =
        checked_num_bytes(source_ + ": its volume", volume.lattice.dims, array_.type);
    const std::int64_t slice_bytes = num_bytes / volume.lattice.dims[2];
    const bool is_chosen = options_.step || volume.steps.size() == 1;
    UnpackedSamples samples(
        fmt::format("{}: {}", source_, layout_text(volume.lattice.dims, array_.type)), num_bytes,
        is_chosen && stays_in_file(array_.type, num_bytes, options_));
    const std::vector<DicomPlaneParts> planes = parts_of_planes(volume, step);
    // What a native file states has been compared with its size; a stream says little by its own.
    if (!files_[planes[0].below.file].is_encapsulated) samples.reserve();
    ReadProgress progress(options_, num_bytes);
    for (const DicomPlaneParts& parts : planes) {
      samples.append(slice_bytes, [&](std::span<std::byte> plane) {
        if (!stores_values_)
          read_stored(parts.below, plane);
        else
          fill_plane(parts, plane);
      });
      progress.advance(slice_bytes);
    }
    samples.release(options_, &array_);
  }

  void read_stored(const DicomFrame& frame, std::span<std::byte> out) {
    if (open_file_ != frame.file) {
      data_ = data_of(frame.file);
      open_file_ = frame.file;
    }
    slice_reader_.read(*data_, files_[frame.file], frame.frame, out);
  }

  // Kept for the planes between two slices, which are read from below.
  std::span<const std::byte> values_of(const DicomFrame& frame) {
    for (const SliceValues& kept : kept_)
      if (kept.frame == frame) return kept.bytes;
    SliceValues& oldest = kept_[next_kept_];
    next_kept_ = 1 - next_kept_;
    oldest.frame = {};
    const DicomFile& file = files_[frame.file];
    stored_.resize(static_cast<std::size_t>(file.slice_bytes()));
    read_stored(frame, stored_);
    const DicomPlane& plane = plane_of(frame);
    const double slope = plane.slope.value_or(1), intercept = plane.intercept.value_or(0);
    data::visit_scalar(file.scalar_type(), [&]<class From>(std::type_identity<From>) {
      const auto count = static_cast<std::int64_t>(stored_.size() / sizeof(From));
      oldest.bytes.resize(static_cast<std::size_t>(count) * size_of(array_.type));
      for (std::int64_t i = 0; i < count; ++i) {
        const double value =
            static_cast<double>(data::load_scalar<From>(stored_.data(), i)) * slope + intercept;
        store(oldest.bytes.data(), i, value);
      }
    });
    oldest.frame = frame;
    return oldest.bytes;
  }

  // Two slices are kept, so that both spans hold.
  void fill_plane(const DicomPlaneParts& parts, std::span<std::byte> out) {
    const std::span<const std::byte> below = values_of(parts.below);
    if (parts.weight == 0) {
      std::ranges::copy(below, out.begin());
      return;
    }
    const std::span<const std::byte> above = values_of(parts.above);
    const auto count = static_cast<std::int64_t>(out.size() / size_of(array_.type));
    const auto mix = [&]<class Value>(std::type_identity<Value>) {
      for (std::int64_t i = 0; i < count; ++i) {
        const auto a = static_cast<double>(data::load_scalar<Value>(below.data(), i));
        const auto b = static_cast<double>(data::load_scalar<Value>(above.data(), i));
        store(out.data(), i, a + parts.weight * (b - a));
      }
    };
    if (array_.type == ScalarType::kFloat32)
      mix(std::type_identity<float>());
    else
      mix(std::type_identity<double>());
  }

  void store(std::byte* to, std::int64_t index, double value) const {
    if (array_.type == ScalarType::kFloat32) {
      const auto narrow = static_cast<float>(value);
      std::memcpy(to + index * 4, &narrow, 4);
    } else {
      std::memcpy(to + index * 8, &value, 8);
    }
  }

  // The values of one slice.
  struct SliceValues {
    DicomFrame frame;
    std::vector<std::byte> bytes;
  };

  std::string source_;
  SourceOpener open_;
  const ReadOptions& options_;
  LeftOut left_out_;
  // Of the files that are no DICOM.
  std::map<std::string, std::int64_t> num_pictures_;  // by format
  std::int64_t num_readable_ = 0;
  std::vector<DicomFile> files_;
  std::vector<DicomGroup> groups_;
  Dataset dataset_;
  DataArray array_;
  bool stores_values_ = false;  // not the stored numbers
  DicomSliceReader slice_reader_;
  SharedSource data_;  // of the file that was read last
  std::size_t open_file_ = DicomFrame::kMissing;
  std::vector<std::byte> stored_;  // one slice's, while its values are computed
  std::array<SliceValues, 2> kept_;
  std::size_t next_kept_ = 0;
};

// Regular files of one folder, sorted; its folders are added to `folders`.
void list_folder(const fs::path& folder, std::vector<std::string>& files,
                 std::vector<fs::path>& folders) {
  std::error_code error;
  const std::size_t first = files.size();
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (entry->path().filename().string().starts_with(".")) continue;
    if (entry->is_regular_file(ignored)) {
      files.push_back(entry->path().string());
    } else if (!entry->is_symlink(ignored) && entry->is_directory(ignored)) {
      folders.push_back(entry->path());
    }
    if (files.size() > kMaxFiles || folders.size() > kMaxFiles) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: holds more than {} files", folder.string(), kMaxFiles));
    }
  }
  if (error) {
    throw Error(ErrorCode::kFileNotFound,
                fmt::format("{}: cannot be read: {}", folder.string(), error.message()));
  }
  std::sort(files.begin() + static_cast<std::ptrdiff_t>(first), files.end());
}

bool has_pixels(const std::string& path) {
  try {
    const SharedSource file = open_file(path);
    return begins_like_dicom(*file) &&
           read_dicom_file(*dicom_data_source(file)).pixels != DicomPixels::kNone;
  } catch (const Error&) {
    return true;  // it is DICOM, and reading it will tell
  }
}

}  // namespace

Dataset read_dicom(const ByteSource& source, const ReadOptions& options) {
  // Shared without an owner: the caller keeps it alive.
  SharedSource borrowed(SharedSource(), &source);
  return DicomReader(
             source.name(), [&](const std::string&) { return borrowed; }, options)
      .run({source.name()});
}

Dataset read_dicom(const std::string& source, const std::vector<std::string>& files,
                   const ReadOptions& options, const Opener& open) {
  return DicomReader(
             source, [&](const std::string& path) -> SharedSource { return open(path); }, options)
      .run(files);
}

std::vector<std::string> dicom_files_in(const std::string& folder) {
  std::vector<std::string> files;
  std::vector<fs::path> folders;
  list_folder(folder, files, folders);
  if (std::any_of(files.begin(), files.end(), has_pixels)) return files;
  for (int depth = 0; depth < kMaxFolderDepth && !folders.empty(); ++depth) {
    std::vector<fs::path> next;
    std::sort(folders.begin(), folders.end());
    for (const fs::path& inner : folders) list_folder(inner, files, next);
    folders = std::move(next);
  }
  return files;
}

bool is_dicom_file(const std::string& path) {
  try {
    return begins_like_dicom(*open_file(path));
  } catch (const Error&) {
    return false;
  }
}

}  // namespace ovoid::io
