// SPDX-License-Identifier: Apache-2.0
// What frames that lie at the same places are to each other: other kinds of values, or time steps.
#pragma once

#include <string>
#include <vector>

#include "io/dicom/dicom_series.h"

namespace ovoid::io {

// Frames of one kind by place, lowest first; every place has at least one.
struct DicomKind {
  std::vector<DicomFrames> places;
  std::string what;  // "echo 2 (7.38 ms)", "P"; empty if there is one kind
};

// By echo and by what ImageType says the values are, where frames at the same place differ in these
// and each kind has slices at half of the places or more. In the order of the echoes, then of the
// words.
std::vector<DicomKind> split_dicom_kinds(const std::vector<DicomFile>& files,
                                         std::vector<DicomFrames> places);

// The frames of one kind as steps, [num_steps][num_places], as many as the most frames at one
// place; what a step lacks is missing. `places` has each place's frames by their numbers. What
// tells steps apart is the first of these that takes one value in all of a step and another in
// each: temporal position, the dimensions of enhanced files, trigger time, time of acquisition, of
// content, number of acquisition. Else, in each place, the order of trigger times, of times of
// acquisition, or of instance numbers, whichever varies.
std::vector<DicomFrames> order_dicom_steps(const std::vector<DicomFile>& files,
                                           const std::vector<DicomFrames>& places);

// The same by the order of the frames alone: the first of each place, the second of each ...
std::vector<DicomFrames> rank_dicom_frames(const std::vector<DicomFrames>& places);

// When the steps were: trigger times; seconds of acquisition since the first; else multiples of
// TemporalResolution, or of RepetitionTime where that is the time of a whole volume.
DicomTimes times_of_dicom_steps(const std::vector<DicomFile>& files,
                                const std::vector<DicomFrames>& steps);

// The b-values of the steps, for people; empty if they are all one, or not known.
std::string diffusion_text(const std::vector<DicomFile>& files,
                           const std::vector<DicomFrames>& steps);

}  // namespace ovoid::io
