// SPDX-License-Identifier: Apache-2.0
// From the frames of many files to volumes: which belong together, in which order, and where they
// lie in the world.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "io/dicom/dicom_file.h"
#include "ovoid/dataset.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// Frame `frame` of files[file].
struct DicomFrame {
  static constexpr std::size_t kMissing = static_cast<std::size_t>(-1);

  std::size_t file = kMissing;
  std::size_t frame = 0;
};

// One volume, or several time steps of one.
struct DicomVolume {
  std::string name;         // unique among the volumes of an input
  std::string description;  // one line for people
  LatticeGeometry lattice;
  Space space = Space::kLps;
  std::vector<std::vector<DicomFrame>> steps;  // [num_steps][lattice.dims[2]], lowest slice first
  std::vector<double> times;                   // of the steps; empty if nothing tells
  std::int64_t num_missing = 0;                // slices of every step that no file holds
  std::vector<std::string> notes;              // what was repaired or assumed
};

// A group of frames before its geometry has been looked at: finding it can fail, and must not keep
// the other volumes of an input from being read.
struct DicomGroup {
  std::string name, description;
  std::vector<std::vector<DicomFrame>> steps;  // of slices in order; one each per place
  std::vector<double> times;
  std::vector<std::string> notes;
};

// Whether two frames hold the same bytes; asked only about frames at the same place.
using SameFrame = std::function<bool(const DicomFrame&, const DicomFrame&)>;

// Sorts all frames of files with pixels into groups: by series, size, type, orientation, sample
// distance; within one by place. Frames at the same place are copies (dropped and counted), time
// steps, or volumes of their own. Ordered by series number. Throws Error(kFileFormat) if the
// orientation of a file is none, or there are more than 1000 groups.
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
