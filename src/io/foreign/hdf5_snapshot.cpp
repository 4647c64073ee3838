// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_snapshot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>
#include <utility>

#include "data/names_text.h"
#include "data/scalar_visit.h"
#include "io/core/point_arrays.h"
#include "io/core/row_share.h"
#include "io/foreign/hdf5_points.h"
#include "io/foreign/hdf5_positions.h"
#include "io/points/snapshot_names.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// A snapshot that is still being put together.
struct OpenSnapshot {
  Snapshot snapshot;
  std::optional<SnapshotPart> name;  // of its first file
  std::set<std::int64_t> numbers;    // that it has

  bool takes(const SnapshotHeader& header, const std::optional<SnapshotPart>& part) const {
    if (!snapshot.header || name.has_value() != part.has_value()) return false;
    if (std::ssize(snapshot.files) >= snapshot.header->num_files) return false;
    if (!part) return header.identity == snapshot.header->identity;
    return part->stem == name->stem && part->ending == name->ending &&
           header.num_files == snapshot.header->num_files && !numbers.contains(part->number);
  }
};

// What is beside the named parts, and what is not.
void find_missing(OpenSnapshot& open) {
  Snapshot& snapshot = open.snapshot;
  snapshot.num_named = std::ssize(snapshot.files);
  if (!snapshot.header || !open.name) return;
  for (std::int64_t number = 0; number < snapshot.header->num_files; ++number) {
    if (open.numbers.contains(number)) continue;
    const std::string path = open.name->path(number);
    std::optional<SnapshotHeader> other;
    try {
      other = snapshot_header(path);
    } catch (const Error&) {
      // It is none of this snapshot's.
    }
    if (other && other->identity == snapshot.header->identity)
      snapshot.files.push_back(path);
    else
      snapshot.missing.push_back(path);
  }
  const auto number_of = [](const std::string& path) {
    const auto part = snapshot_part(path);
    return part ? part->number : 0;
  };
  std::stable_sort(
      snapshot.files.begin(), snapshot.files.end(),
      [&](const std::string& a, const std::string& b) { return number_of(a) < number_of(b); });
}

// All values as float64, if some parts have others than the first.
bool are_alike(const std::vector<const DataArray*>& parts) {
  return std::all_of(parts.begin(), parts.end(), [&](const DataArray* part) {
    return part->type == parts[0]->type && part->value_scale == parts[0]->value_scale &&
           part->value_offset == parts[0]->value_offset;
  });
}

// Arrays behind each other; each part is released when it is copied.
DataArray joined(const std::vector<DataArray*>& parts) {
  const bool is_alike = are_alike({parts.begin(), parts.end()});
  DataArray description = *parts[0];
  description.bytes = {};
  description.num_tuples = 0;
  for (const DataArray* part : parts) description.num_tuples += part->num_tuples;
  if (!is_alike) {
    description.type = ScalarType::kFloat64;
    description.value_scale = 1;
    description.value_offset = 0;
  }
  std::byte* to = nullptr;
  DataArray all = new_array(std::move(description), to);
  for (DataArray* part : parts) {
    const std::int64_t count = part->num_tuples * part->num_components;
    if (is_alike) {
      const std::size_t size = part->bytes.view.size();
      if (size > 0) std::memcpy(to, part->bytes.view.data(), size);
      to += size;
    } else {
      data::visit_scalar(part->type, [&]<class T>(std::type_identity<T>) {
        for (std::int64_t i = 0; i < count; ++i, to += sizeof(double)) {
          const double value =
              static_cast<double>(data::load_scalar<T>(part->bytes.view.data(), i)) *
                  part->value_scale +
              part->value_offset;
          std::memcpy(to, &value, sizeof(double));
        }
      });
    }
    part->bytes = {};
  }
  return all;
}

// Reads one kind of particles of all parts.
class SnapshotReader {
 public:
  SnapshotReader(const Snapshot& snapshot, const ReadOptions& options)
      : snapshot_(snapshot), options_(options), source_(snapshot.source) {}

  Dataset run() {
    find_places();
    const std::string path = choose();
    std::int64_t total = 0;
    for (const auto& places : places_) total += count_at(places, path);
    const Rows wanted = rows_of_share(options_.share, total);
    std::vector<Dataset> parts;
    std::int64_t first = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const std::int64_t count = count_at(places_[i], path);
      if (count == 0) continue;
      const std::int64_t begin = std::clamp<std::int64_t>(wanted.first - first, 0, count);
      const std::int64_t end = std::clamp<std::int64_t>(wanted.end() - first, begin, count);
      parts.push_back(read_part(i, path, {begin, end - begin}, {first, total}));
      first += count;
    }
    Dataset all = join(parts);
    tell(path, total, all);
    set_share(all, options_.share, total);
    return all;
  }

 private:
  // Rows of the whole that were read before, and are to be read.
  struct Progress {
    std::int64_t first = 0, total = 1;
  };

  void find_places() {
    for (const std::string& file : snapshot_.files) places_.push_back(hdf5_points_in(file));
  }

  static std::int64_t count_at(const std::vector<Hdf5PointsPlace>& places,
                               const std::string& path) {
    for (const Hdf5PointsPlace& place : places)
      if (place.path == path) return place.count;
    return 0;
  }

  // The path of the positions, the same in all parts.
  std::string choose() {
    std::vector<PositionsPlace> all;
    for (const auto& places : places_) {
      for (const Hdf5PointsPlace& place : places) {
        if (std::none_of(all.begin(), all.end(),
                         [&](const PositionsPlace& known) { return known.path == place.path; }))
          all.push_back({place.path, place.group});
      }
    }
    if (options_.hdf5.positions.empty()) return all[choose_positions(source_, all, notes_)].path;
    return choose_asked();
  }

  // What is asked for need not be called like positions.
  std::string choose_asked() {
    std::string path = absolute_path(options_.hdf5.positions);
    std::optional<Error> first_error;
    bool is_found = false;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      try {
        const Hdf5File file(snapshot_.files[i]);
        const std::int64_t count = asked_positions(file, source_, path).count;
        std::erase_if(places_[i], [&](const Hdf5PointsPlace& place) { return place.path == path; });
        places_[i].push_back({path, "", count});
        is_found = true;
      } catch (const Error& error) {
        if (!first_error) first_error = error;
      }
    }
    if (!is_found && first_error) throw Error(*first_error);
    return path;
  }

  Dataset read_part(std::size_t i, const std::string& path, const Rows& rows,
                    const Progress& done) const {
    ReadOptions own = options_;
    own.hdf5.positions = path;
    own.share.reset();
    if (options_.progress) {
      own.progress = [&, share = static_cast<double>(rows.count)](double fraction) {
        options_.progress((static_cast<double>(done.first) + share * fraction) /
                          static_cast<double>(done.total));
      };
    }
    return read_hdf5_rows_of_points(snapshot_.files[i], own, rows);
  }

  Dataset join(std::vector<Dataset>& parts) {
    std::vector<std::string> notes;
    std::vector<DataArray*> positions;
    for (Dataset& part : parts) {
      positions.push_back(&part.positions);
      if (!part.periodic_box) parts[0].periodic_box.reset();
      // What is said of the whole snapshot is said once.
      for (std::string& note : part.notes) {
        if (note.starts_with(part.source)) note = source_ + note.substr(part.source.size());
        if (std::find(notes.begin(), notes.end(), note) == notes.end())
          notes.push_back(std::move(note));
      }
    }
    DataArray places = joined(positions);
    Dataset all = std::move(parts[0]);
    all.positions = std::move(places);
    all.notes = std::move(notes);
    std::vector<std::string> left_out;
    std::vector<DataArray> arrays = std::exchange(all.arrays, {});
    for (DataArray& array : arrays) {
      std::vector<DataArray*> columns{&array};
      for (std::size_t i = 1; i < parts.size(); ++i) {
        for (DataArray& other : parts[i].arrays) {
          if (other.name == array.name && other.num_components == array.num_components)
            columns.push_back(&other);
        }
      }
      if (columns.size() == parts.size())
        all.arrays.push_back(joined(columns));
      else
        left_out.push_back(array.name);
    }
    if (!left_out.empty()) {
      all.notes.push_back(
          fmt::format("{}: arrays that not all files of the snapshot have are left "
                      "out: {}",
                      source_, data::names_text(left_out)));
    }
    all.source = source_;
    return all;
  }

  void tell(const std::string& path, std::int64_t total, Dataset& all) {
    all.notes.insert(all.notes.begin(), notes_.begin(), notes_.end());
    const std::int64_t num_files = snapshot_.header->num_files;
    if (snapshot_.num_named < std::ssize(snapshot_.files)) {
      all.notes.push_back(
          fmt::format("{}: is one of {} files of a snapshot: those beside it are read, too",
                      source_, num_files));
    }
    if (std::ssize(snapshot_.files) >= num_files) return;
    const int type = gadget_type(path.substr(0, path.rfind('/')));
    const std::vector<double>& totals = snapshot_.header->totals;
    const bool has_total = type >= 0 && static_cast<std::size_t>(type) < totals.size();
    const std::string particles =
        has_total ? fmt::format("{:.0f} of {:.0f} particles",
                                std::max(0.0, totals[static_cast<std::size_t>(type)] -
                                                  static_cast<double>(total)),
                                totals[static_cast<std::size_t>(type)])
                  : std::string("their particles");
    const auto num_missing = num_files - std::ssize(snapshot_.files);
    all.notes.push_back(fmt::format(
        "{}: of {} files of the snapshot {} {} not there{}: {} are missing", source_, num_files,
        num_missing, num_missing == 1 ? "is" : "are",
        snapshot_.missing.empty() ? "" : fmt::format(" ({})", data::names_text(snapshot_.missing)),
        particles));
  }

  const Snapshot& snapshot_;
  const ReadOptions& options_;
  const std::string& source_;
  std::vector<std::vector<Hdf5PointsPlace>> places_;  // of each file
  std::vector<std::string> notes_;
};

}  // namespace

std::vector<Snapshot> sort_snapshots(const std::vector<std::string>& paths) {
  std::vector<OpenSnapshot> open;
  for (const std::string& path : paths) {
    const auto header = snapshot_header(path);
    const auto part = header ? snapshot_part(path) : std::nullopt;
    auto found = open.end();
    if (header) {
      found = std::find_if(open.begin(), open.end(), [&](const OpenSnapshot& snapshot) {
        return snapshot.takes(*header, part);
      });
    }
    if (found == open.end()) {
      open.emplace_back();
      found = std::prev(open.end());
      found->snapshot.header = header;
      found->name = part;
    }
    if (found->snapshot.files.empty()) found->snapshot.source = path;
    found->snapshot.files.push_back(path);
    if (part) found->numbers.insert(part->number);
  }
  std::vector<Snapshot> snapshots;
  for (OpenSnapshot& one : open) {
    find_missing(one);
    snapshots.push_back(std::move(one.snapshot));
  }
  return snapshots;
}

Dataset read_snapshot(const Snapshot& snapshot, const ReadOptions& options) {
  return SnapshotReader(snapshot, options).run();
}

}  // namespace ovoid::io
#endif
