// SPDX-License-Identifier: Apache-2.0
// A dump is a row of frames, each a few "ITEM:" lines, their values, and a line per atom. Where the
// frames begin is known only by walking over them, so one pass counts all and reads one.
#include "io/points/lammps_dump.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "data/varies.h"
#include "io/core/byte_stream.h"
#include "io/core/number_fields.h"
#include "io/core/row_share.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/points/point_columns.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kMaxDumpColumns = 4096;

struct DumpFrame {
  double step = 0;             // its number
  std::optional<double> time;  // in the simulation's units
  std::string units;           // their name: "metal"
  std::int64_t num_atoms = -1;
  Vec3 origin = Vec3::Zero();  // of the box
  Mat3 edges = Mat3::Zero();   // columns: its edge vectors
  bool has_box = false;
  bool is_periodic = false;  // in all three directions
  std::vector<std::string> columns;
};

// How a frame's columns hold the positions.
struct DumpPositions {
  std::array<std::size_t, 3> columns{};
  bool is_scaled = false;     // parts of the box's edges
  bool is_unwrapped = false;  // atoms that have left the box stay out of it
};

bool find_dump_positions(const DumpFrame& frame, DumpPositions& positions) {
  for (const char* const suffix : {"", "u", "s", "su"}) {
    const std::string_view kind = suffix;
    bool is_there = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto found = std::find(frame.columns.begin(), frame.columns.end(),
                                   fmt::format("{}{}", "xyz"[axis], kind));
      is_there = is_there && found != frame.columns.end();
      positions.columns[axis] = static_cast<std::size_t>(found - frame.columns.begin());
    }
    positions.is_scaled = kind.starts_with('s');
    positions.is_unwrapped = kind.ends_with('u');
    if (is_there) return true;
  }
  return false;
}

class DumpReader {
 public:
  DumpReader(LineReader& lines, std::vector<std::string>& notes) : lines_(lines), notes_(notes) {}

  // Up to the first atom of the next frame; false at the end of the file.
  bool next(DumpFrame& frame) {
    frame = {};
    std::string_view line;
    do {
      if (!lines_.next(line)) return false;
    } while (line.find_first_not_of(" \t") == std::string_view::npos);
    while (true) {
      if (line.starts_with("ITEM: ATOMS")) {
        for (const std::string_view word : words(line.substr(11))) frame.columns.emplace_back(word);
        check(frame);
        return true;
      }
      read_item(line, frame);
      line = next_line();
    }
  }

  void skip_atoms(const DumpFrame& frame) {
    for (std::int64_t i = 0; i < frame.num_atoms; ++i) next_line();
  }

  // Behind them. Of `dataset` it sets positions, arrays, box and share.
  void read_atoms(const DumpFrame& frame, const std::optional<RowShare>& share, Dataset& dataset);

  bool is_cut() const noexcept { return is_cut_; }  // the file ended within a frame

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    throw Error(code, fmt::format("{}: {}", lines_.where(), what));
  }

  [[noreturn]] void refuse_item(std::string_view line) const {
    if (line.starts_with("ITEM: GRID") || line.starts_with("ITEM: NUMBER OF ENTRIES") ||
        line.starts_with("ITEM: ENTRIES")) {
      fail(fmt::format("'{}': is a dump of {}, which is not read: expected one of atoms",
                       line.substr(0, 40),
                       line.starts_with("ITEM: GRID") ? "grid cells" : "bonds or other entries"),
           ErrorCode::kUnsupported);
    }
    fail(fmt::format("'{}': expected 'ITEM: TIMESTEP', 'NUMBER OF ATOMS', 'BOX BOUNDS' or 'ATOMS'",
                     line.substr(0, 40)));
  }

  std::string_view next_line() {
    std::string_view line;
    if (!lines_.next(line)) {
      is_cut_ = true;
      fail("the file ends within a frame");
    }
    return line;
  }

  double number(std::string_view word) const {
    const auto value = parse_field(word);
    if (!value || !(*value - *value == 0))
      fail(fmt::format("'{}': expected a number", word.substr(0, 40)));
    return *value;
  }

  void read_item(std::string_view line, DumpFrame& frame) {
    if (line.starts_with("ITEM: TIMESTEP")) {
      frame.step = number(next_line());
    } else if (line.starts_with("ITEM: TIME")) {
      frame.time = number(next_line());
    } else if (line.starts_with("ITEM: UNITS")) {
      frame.units = trimmed(next_line());
    } else if (line.starts_with("ITEM: NUMBER OF ATOMS")) {
      const std::string_view text = next_line();
      const auto parts = words(text);
      const auto count = parts.size() == 1 ? parse_integer(parts[0]) : std::nullopt;
      if (!count || *count < 0)
        fail(fmt::format("'{}': expected a number of atoms", text.substr(0, 40)));
      frame.num_atoms = *count;
    } else if (line.starts_with("ITEM: BOX BOUNDS")) {
      read_box(std::string(line.substr(16)), frame);
    } else {
      refuse_item(line);
    }
  }

  // A general box is given by its three edge vectors, the others by bounds and tilts.
  void read_box(const std::string& kinds, DumpFrame& frame) {
    const auto flags = words(kinds);
    const auto has = [&](std::string_view flag) {
      return std::find(flags.begin(), flags.end(), flag) != flags.end();
    };
    const bool is_general = has("abc"), is_tilted = has("xy");
    const std::size_t wanted = is_general ? 4 : is_tilted ? 3 : 2;
    std::array<std::array<double, 4>, 3> rows{};
    for (auto& row : rows) {
      const std::string_view line = next_line();
      const auto numbers = words(line);
      if (numbers.size() != wanted)
        fail(fmt::format("'{}': expected {} numbers", line.substr(0, 60), wanted));
      for (std::size_t i = 0; i < wanted; ++i) row[i] = number(numbers[i]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      const auto& row = rows[static_cast<std::size_t>(axis)];
      if (!is_general) continue;
      frame.edges.col(axis) = Vec3(row[0], row[1], row[2]);
      frame.origin[axis] = row[3];
    }
    if (!is_general) set_bounds(rows, frame);
    frame.has_box = true;
    frame.is_periodic = std::count(flags.begin(), flags.end(), "pp") == 3;
  }

  // The bounds of a tilted box are those of the box around it.
  void set_bounds(const std::array<std::array<double, 4>, 3>& rows, DumpFrame& frame) const {
    Vec3 lo, hi;
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = rows[static_cast<std::size_t>(axis)][0];
      hi[axis] = rows[static_cast<std::size_t>(axis)][1];
    }
    const double xy = rows[0][2], xz = rows[1][2], yz = rows[2][2];
    lo[0] -= std::min({0.0, xy, xz, xy + xz});
    hi[0] -= std::max({0.0, xy, xz, xy + xz});
    lo[1] -= std::min(0.0, yz);
    hi[1] -= std::max(0.0, yz);
    for (int axis = 0; axis < 3; ++axis) {
      if (!(hi[axis] >= lo[axis]))
        fail(fmt::format("the box is turned inside out along {}", "xyz"[axis]));
    }
    frame.origin = lo;
    frame.edges = (hi - lo).asDiagonal();
    frame.edges(0, 1) = xy;
    frame.edges(0, 2) = xz;
    frame.edges(1, 2) = yz;
  }

  void check(const DumpFrame& frame) const {
    if (frame.num_atoms < 0) fail("no 'ITEM: NUMBER OF ATOMS' before the atoms");
    if (frame.columns.size() > kMaxDumpColumns)
      fail(fmt::format("{} columns: expected at most {}", frame.columns.size(), kMaxDumpColumns),
           ErrorCode::kUnsupported);
  }

  void place(const DumpFrame& frame, const DumpPositions& positions, PointTable& table,
             Dataset& dataset);

  LineReader& lines_;
  std::vector<std::string>& notes_;
  bool is_cut_ = false;
};

// Brings scaled positions into the box, and says whether its faces are joined.
void DumpReader::place(const DumpFrame& frame, const DumpPositions& positions, PointTable& table,
                       Dataset& dataset) {
  if (positions.is_scaled) {
    if (!frame.has_box) fail("scaled positions without 'ITEM: BOX BOUNDS'");
    double* const x = table.slot(positions.columns[0], 0).first;  // y and z follow it
    for (std::int64_t i = 0; i < table.num_rows(); ++i) {
      Eigen::Map<Vec3> place(x + 3 * i);
      place = (frame.origin + frame.edges * Vec3(place)).eval();
    }
  }
  const Vec3 sizes = frame.edges.diagonal();
  const bool is_tilted = frame.edges != Mat3(sizes.asDiagonal());
  if (!frame.is_periodic || positions.is_unwrapped) return;
  if (is_tilted) {
    notes_.push_back(
        fmt::format("{}: the box is tilted: its periodic faces are not joined", lines_.where()));
    return;
  }
  if ((sizes.array() > 0).all()) dataset.periodic_box = Bounds3(frame.origin, frame.origin + sizes);
}

void DumpReader::read_atoms(const DumpFrame& frame, const std::optional<RowShare>& share,
                            Dataset& dataset) {
  DumpPositions positions;
  if (!find_dump_positions(frame, positions))
    fail("the atoms have no columns x y z, xu yu zu, xs ys zs or xsu ysu zsu");
  if (frame.num_atoms == 0) fail("the frame has no atoms");
  std::string_view line = next_line();
  std::vector<PointColumn> columns;
  const auto first = split_fields(line, Separator::kBlanks);
  for (std::size_t i = 0; i < frame.columns.size(); ++i)
    columns.push_back({frame.columns[i], i < first.size() && parse_field(first[i]).has_value()});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (PointColumn& column : columns)  // one of three that are not all there
      if (column.name == std::string(1, "xyz"[axis])) column.name += " alone";
    PointColumn& column = columns[positions.columns[axis]];
    if (!column.is_number) fail(fmt::format("column '{}' holds no numbers", column.name));
    column.name = std::string(1, "xyz"[axis]);
  }
  constexpr std::int64_t kAtomsAtATime = 4096;
  PointTable table(lay_out_points(lines_.where(), columns, notes_));
  std::vector<PointTable::Slot> slots(columns.size());
  const Rows rows = rows_of_share(share, frame.num_atoms);
  for (std::int64_t i = 0; i < frame.num_atoms; ++i) {
    if (i > 0) line = next_line();
    const std::int64_t row = i - rows.first;
    if (row < 0 || row >= rows.count) continue;  // another share's: its numbers are not looked at
    if (row % kAtomsAtATime == 0) {
      table.extend(std::min(kAtomsAtATime, rows.count - row));
      for (std::size_t c = 0; c < slots.size(); ++c) slots[c] = table.slot(c, row);
    }
    FieldReader fields(line, Separator::kBlanks);
    for (std::size_t c = 0; c < slots.size(); ++c) {
      const bool is_good =
          slots[c].first == nullptr ? fields.skip() : fields.number(*slots[c].first);
      if (!is_good) {
        fail(fmt::format("column '{}' is '{}': expected a number", frame.columns[c],
                         fields.text().substr(0, 32)));
      }
      if (slots[c].first != nullptr) slots[c].first += slots[c].stride;
    }
  }
  place(frame, positions, table, dataset);
  table.release(dataset);
  set_share(dataset, share, frame.num_atoms);
}

bool step_varies(const Dataset& dataset, const ReadOptions& options) {
  return dataset.arrays.empty() || data::varies(dataset.array(options.array));
}

// The times of all frames as they were told.
class DumpTimes {
 public:
  void add(const DumpFrame& frame) {
    steps_.push_back(frame.step);
    has_all_ = has_all_ && frame.time && (times_.empty() || *frame.time > times_.back());
    if (has_all_) times_.push_back(*frame.time);
    if (units_.empty()) units_ = frame.units;
  }

  // Times in the simulation's units where every frame tells a later one, else the numbers of steps.
  void give(Dataset& dataset) {
    dataset.times = has_all_ ? std::move(times_) : std::move(steps_);
    if (!has_all_) return;
    using Unit = std::pair<std::string_view, const char*>;
    static constexpr std::array<Unit, 7> kUnits{{{"real", "fs"},
                                                 {"metal", "ps"},
                                                 {"si", "s"},
                                                 {"cgs", "s"},
                                                 {"electron", "fs"},
                                                 {"micro", "us"},
                                                 {"nano", "ns"}}};
    for (const auto& [name, unit] : kUnits)
      if (name == units_) dataset.time_unit = unit;
  }

 private:
  std::vector<double> steps_, times_;
  std::string units_;
  bool has_all_ = true;
};

}  // namespace

Dataset read_lammps_dump(const ByteSource& source, const ReadOptions& options) {
  ReadProgress progress(options, source.size());
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "LAMMPS dump";
  dataset.kind = DatasetKind::kParticles;
  std::vector<std::string> notes, step_notes;
  DumpReader reader(lines, step_notes);
  DumpFrame frame;
  DumpTimes times;
  // Which step is the first that varies is seen in all of its atoms.
  const auto share = options.step ? options.share : std::nullopt;
  bool is_found = false, has_atoms = false;
  std::int64_t num_steps = 0;
  try {
    for (; reader.next(frame); ++num_steps) {
      const bool is_tried =
          options.step ? num_steps == *options.step : !is_found && frame.num_atoms > 0;
      if (is_tried) {
        Dataset tried;
        step_notes.clear();
        tried.source = source.name();
        reader.read_atoms(frame, share, tried);
        is_found = options.step.has_value() || step_varies(tried, options);
        if (is_found || !has_atoms) {
          has_atoms = true;
          dataset.share = tried.share;
          dataset.positions = std::move(tried.positions);
          dataset.arrays = std::move(tried.arrays);
          dataset.periodic_box = tried.periodic_box;
          dataset.step = num_steps;
          notes = step_notes;
        }
      } else {
        reader.skip_atoms(frame);
      }
      check_num_steps(source.name(), num_steps + 1);
      times.add(frame);
    }
  } catch (const Error&) {
    // A simulation that is still running, or was stopped, leaves part of a frame.
    if (!reader.is_cut() || !has_atoms) throw;
    notes.push_back(fmt::format("{}: the last frame is cut short and left out", source.name()));
  }
  times.give(dataset);
  dataset.num_steps = static_cast<std::int64_t>(dataset.times.size());
  if (options.step) check_step(source.name(), *options.step, dataset.num_steps);
  if (!has_atoms)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no frame with atoms", source.name()));
  if (!options.step && dataset.num_steps > 1)
    notes.push_back(chosen_step_note(source.name(), dataset.step, dataset.num_steps));
  dataset.notes = std::move(notes);
  return dataset;
}

}  // namespace ovoid::io
