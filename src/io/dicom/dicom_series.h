// SPDX-License-Identifier: Apache-2.0
// From the frames of many files to volumes: which belong together, in which order, and where they
// lie in the world.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "io/dicom/dicom_file.h"
#include "ovoid/dataset.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// Slice `frame` of files[file]: a frame, or a tile of one.
struct DicomFrame {
  static constexpr std::size_t kMissing = static_cast<std::size_t>(-1);

  std::size_t file = kMissing;
  std::size_t frame = 0;

  bool is_missing() const noexcept { return file == kMissing; }
  friend bool operator==(const DicomFrame&, const DicomFrame&) = default;
};

using DicomFrames = std::vector<DicomFrame>;

// Of one thing at several times: the times, and their unit. Empty if nothing tells.
struct DicomTimes {
  std::vector<double> values;
  std::string unit;
};

// One volume, or several time steps of one. The slices of a step lie at some places, lowest first;
// every place is a plane of the lattice, which may have planes between them.
struct DicomVolume {
  std::string name;         // unique among the volumes of an input
  std::string description;  // one line for people
  LatticeGeometry lattice;
  Space space = Space::kLps;
  std::vector<DicomFrames> steps;    // [num_steps][num_places]
  std::vector<std::int64_t> planes;  // [num_places], rising; kLeftOut for what is in nobody's plane
  DicomTimes times;
  std::vector<std::string> notes;  // what was repaired or assumed

  static constexpr std::int64_t kLeftOut = -1;

  // Whether some plane of some step has no slice of its own.
  bool is_resampled() const;
};

// What one plane of the lattice is made of: `below` x (1 - weight) + `above` x weight.
struct DicomPlaneParts {
  DicomFrame below, above;
  double weight = 0;
};

// Of the planes of one step, lowest first. The first and the last have slices of their own.
std::vector<DicomPlaneParts> parts_of_planes(const DicomVolume& volume, std::size_t step);

// A group of frames before its geometry has been looked at: finding it can fail, and must not keep
// the other volumes of an input from being read. Its first and last place are there in every step.
struct DicomGroup {
  std::string name, description;
  std::vector<DicomFrames> steps;  // [num_steps][num_places]; some may be missing
  DicomTimes times;
  std::vector<std::string> notes;
};

// Whether two frames hold the same bytes; asked only about frames at the same place.
using SameFrame = std::function<bool(const DicomFrame&, const DicomFrame&)>;

// Sorts all frames of files with pixels into groups: by series, size, type, orientation, sample
// distance; within one by place. Frames at the same place are copies (dropped and counted), other
// kinds of values (echoes, phases), which are volumes of their own, or time steps. Ordered by
// series number. Throws Error(kFileFormat) if the orientation of a file is none, or there are more
// than 1000 groups.
std::vector<DicomGroup> group_dicom_frames(const std::vector<DicomFile>& files,
                                           const SameFrame& is_same);

// Finds a group's lattice. Throws Error(kFileFormat) naming files if its slices do not form one.
DicomVolume place_dicom_group(const std::vector<DicomFile>& files, DicomGroup group);

// Slices may lie this far from their lattice, in slice distances: without a note, and with one.
inline constexpr double kDicomSlack = 0.01;
inline constexpr double kDicomTolerance = 0.1;
// How far directions may be from unit length and from a right angle.
inline constexpr double kDicomOrientationTolerance = 1e-3;

}  // namespace ovoid::io
