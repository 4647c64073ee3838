// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/kernel_team.h"
#include "ovoid/relevant.h"
#include "ovoid/surface.h"

namespace OVOID_API ovoid {

class KernelTeam;  // ovoid/kernel_team.h

class StepSource;  // ovoid/series.h

// How a dataset's array becomes a field.
struct LatticeModelOptions {
  std::string array;  // empty: Dataset::array()'s default
  int component = 0;  // of the array's tuples; kMagnitude: Euclidean norm
  // None: the cubic B-spline, prefiltered; but for labels, which it would overshoot, and for
  // relevant samples alone the published Gaussian as it is (docs/kernels.md, "Lattices").
  std::optional<LatticeKernel> kernel{};
  Reconstruction reconstruction = Reconstruction::kNormalized;
  // Coefficients such that the field takes the samples' values at the samples. None: of B-splines
  // alone.
  std::optional<bool> prefilter{};
  std::optional<RelevantSamples> relevant{};  // these alone, as runs, in memory of their own
  int threads = 0;                            // 0: one per hardware thread
  // Of samples in a file: processes that make the same field, all of them this call, and look at
  // samples in shares, here and where looks are made of the field. Kept by the field. Null: none.
  std::shared_ptr<KernelTeam> team{};

  static constexpr int kMagnitude = -1;
};

// What the model stage found; reported by `ovoid info` and in notes.
struct LatticeModelReport {
  std::string array;
  std::int64_t num_missing = 0;    // NaN and infinite samples: no kernel there
  bool is_prefiltered = false;     // the field takes the samples' values at the samples
  std::size_t resident_bytes = 0;  // of the field, samples and ranges
  std::size_t source_bytes = 0;    // of the stored samples in the dataset
  std::vector<std::string> notes;
};

// Chooses kernels for a dataset: one ball per sample, shared shape. Samples are borrowed from the
// dataset (whose buffers stay alive with the field) when their type is one a BrickView can show;
// 32-bit and 64-bit integers and doubles become float32, and a prefiltered field holds float32
// coefficients beside its samples. Values beyond float32's range are missing. Throws Error: unknown
// array, component or type, kernel out of range, `prefilter` with a kernel whose samples cannot be
// interpolated or with `relevant`. Cost: one pass for the value ranges, of integers one to see
// whether they are labels, which soon ends; a prefiltered field three more [METHOD 7.3.2: separable
// banded solve], body-centred some fifteen.
LatticeField make_lattice_field(const Dataset& dataset, const LatticeModelOptions& options = {},
                                LatticeModelReport* report = nullptr, std::stop_token stop = {});

// How the neighbourhood of a node is found that shapes its kernel.
enum class Neighborhood {
  kEdges,    // the mesh's own edges (cell data: cells that share a face)
  kVoronoi,  // Voronoi cells of the nodes; for boxes and scattered points
};

// How meshes, boxes, particles and stored kernels become kernels (docs/kernels.md).
struct KernelModelOptions {
  std::string array{};        // gives opacity and surfaces; empty: Dataset::array()'s default
  std::string color_array{};  // gives colour; empty: the same
  int component = 0;          // of both arrays' tuples; LatticeModelOptions::kMagnitude: the norm
  // None: the dataset's own; of those that have none sum for densities and stored kernels, else
  // normalized.
  std::optional<Reconstruction> reconstruction{};
  // Sigmas; none: 4 for stored kernels and particles, 3.5 for meshes.
  std::optional<double> cutoff{};
  int threads = 0;  // 0: one per hardware thread

  // Meshes
  Neighborhood neighborhood = Neighborhood::kEdges;
  int amplitude_passes = 3;  // w /= F^0.7 at the centres, F the sum of weights

  // Particles
  // Whether the field is mass per volume, of `mass_array`, and not an attribute. None: as
  // draws_density() finds best.
  std::optional<bool> is_density{};
  // Smoothing lengths h; empty: one that is called like one (h, hsml, SmoothingLength,
  // smoothing_length), else from neighbours.
  std::string radius_array{};
  // Kernels end at so many h of that array, > 0; none: as the code that the dataset's format names
  // has it, else 2.
  std::optional<double> smoothing_reach{};
  std::string mass_array{};  // empty: one that is called like one (m, mass, Masses), else `mass`
  std::optional<double> mass{};  // of every particle; none: 1
  int neighbors = 32;            // particles within 2 h where h comes from neighbours, 4 to 512
  bool anisotropic = false;      // ellipsoids from the covariance of the neighbours
  KernelProfile profile = KernelProfile::kGaussian;
};

// Whether particles are drawn by their mass, or number, per volume: as the options say, and where
// they name no array and say nothing if the particles have a mass without a density of their own,
// or no array that says something by itself: numbers, places and parts of vectors do not.
bool draws_density(const Dataset& dataset, const KernelModelOptions& options = {});

// What the model stage found; reported by `ovoid info` and in notes.
struct KernelModelReport {
  std::string array, color_array;
  std::int64_t num_sites = 0;      // nodes, cells or particles of the dataset
  std::int64_t num_kernels = 0;    // that became kernels
  std::int64_t num_missing = 0;    // value NaN or infinite: no kernel
  std::int64_t num_misplaced = 0;  // position NaN or infinite: no kernel
  // Nodes at the same place as another, or particles with `neighbors` or more at their place: one
  // kernel stands for all.
  std::int64_t num_merged = 0;
  std::int64_t num_dangling = 0;    // nodes of no cell: no kernel
  std::int64_t num_copies = 0;      // of kernels that cross a face of a periodic box
  std::int64_t num_degenerate = 0;  // shapes that had to be made thicker to be ellipsoids at all
  // Quantiles 0, 0.05, 0.5, 0.95, 1.
  std::array<double, 5> spacings{};     // twice the geometric mean of the sigmas, world units
  std::array<double, 5> axis_ratios{};  // greatest over smallest sigma
  // Sum of weights (the reproduction of f = 1) at the kernels' centres, of those inside only where
  // that is known.
  double constant_mean = 0, constant_deviation = 0;
  bool is_normalized = true;  // as reconstructed
  std::size_t resident_bytes = 0;
  std::vector<std::string> notes;
};

// Chooses kernels for a mesh, boxes, particles or stored kernels: an ellipsoid per node or cell, a
// ball or ellipsoid per particle. Throws Error: unknown array or component, a dataset without
// positions, cells or finite values, radii that are not positive, arrays of wrong length; names
// array and index. kCancelled. Cost: for meshes some microseconds per node.
KernelField make_kernel_field(const Dataset& dataset, const KernelModelOptions& options = {},
                              KernelModelReport* report = nullptr, std::stop_token stop = {});

// make_kernel_field() of a dataset of which each process has a share (ReadOptions::share; all
// shares, in the order of the processes' numbers): the same field in all of them, with the bricks
// that one process alone would make. Each process keeps about as many kernels as the others; those
// of other bricks it fetches when they are acquired, and keeps the last used ones. Of the report,
// counts are those of all. Everything but what can_be_shared() refuses. Throws what
// make_kernel_field() throws, in the process that finds it, what the team throws in others;
// Error(kUnsupported) for options that can_be_shared() refuses. Memory: the share's kernels twice
// while they are sorted, before that a mesh's cells twice; then its kernels, about a byte for each
// kernel of all (their bricks), and what it has fetched. Cost: every kernel is sent once or twice,
// and so are nodes and cells; what is near the edge of a share is looked for in others.
struct TeamFieldOptions {
  KernelModelOptions kernels{};
  // Of the kernels that it has fetched, as many bytes are kept; 0: as its own take, at least
  // 64 MiB.
  std::int64_t kept_bytes = 0;
  // Of meshes and boxes: what make_surface() makes of the whole, with its options those above, goes
  // there in each process; null: is not made. All give it, or none.
  std::shared_ptr<const Surface>* surface = nullptr;
};
KernelField make_team_field(const Dataset& share, const TeamFieldOptions& options,
                            const std::shared_ptr<KernelTeam>& team,
                            KernelModelReport* report = nullptr, std::stop_token stop = {});

// Whether such kernels can be made of shares: not of particles drawn out by their neighbours
// (anisotropic), nor by Voronoi cells.
bool can_be_shared(const KernelModelOptions& options) noexcept;

// Of lattices the one, of everything else the other.
struct FieldModelOptions {
  LatticeModelOptions lattice{};
  KernelModelOptions kernels{};
};

// A dataset of any kind as a field: make_lattice_field() or make_kernel_field(). Throws what they
// throw.
Field make_field(const Dataset& dataset, const FieldModelOptions& options = {},
                 std::stop_token stop = {});

// The kernels of a field as a dataset of kind kKernels, for files: positions, "scale", "rotation",
// "weight" and the attributes, all float32; positions are float64 if float32 would move a kernel by
// more than KernelBrick::kMaxOffsetError. Rotations turn the longest axis to x, the shortest to z.
// Throws what the source throws. Cost: an eigenvalue problem per ellipsoid.
Dataset make_kernel_dataset(const KernelField& field);

// Bytes, at most, of a file (.ply) of so many kernels like the field's, as make_kernel_dataset()
// gives them to write_dataset().
std::int64_t kernel_file_bytes(const KernelField& field, std::int64_t num_kernels);

// The faces of a mesh's solid cells, or of boxes, that no other one shares, and its flat cells,
// with the values that make_kernel_field() with the same options would give colour by: of nodes, or
// of the cell behind each face. Nodes at one place are one node. Cells of type kOther have no faces
// that are known. Null if the dataset is neither, or has no faces. Throws what make_kernel_field()
// throws of the mesh and its arrays; Error(kCancelled) if stopped. Cost: a sort of all faces; peak
// memory about 40 bytes per face of a cell.
std::shared_ptr<const Surface> make_surface(const Dataset& dataset,
                                            const KernelModelOptions& options = {},
                                            std::stop_token stop = {});

// The lines of a mesh (cells of types kLine and kPolyLine) as tubes around them, and its points
// (kVertex; all, of particles) as balls, with the values that make_surface() gives corners. Lines
// that go on from cell to cell are one. `radius`: world; 0: 1/300 of the diagonal of their bounds,
// or 1 if that is 0. Null: there are none of both. Throws as make_surface(), and
// Error: kInvalidArgument for a negative radius, kUnsupported for more than 2^28 triangles.
// Cost: 24 triangles for each node of a line; 288 for each point, of more than 20 000 points 72.
std::shared_ptr<const Surface> make_tubes(const Dataset& dataset, double radius,
                                          const KernelModelOptions& options = {},
                                          std::stop_token stop = {});

// Sample data by formula (`ovoid make`): lattices with one array, centred on the origin; a mesh
// ("fin"), particles ("galaxy") and stored kernels ("blobs").
struct MakeOptions {
  // Samples of a Cartesian lattice, or of that for which a body-centred one stands
  // (body_centred_like); zeros: the name's own default.
  Index3 size{0, 0, 0};
  LatticeKind lattice = LatticeKind::kCartesian;
  double time = 0;                         // of names that move, in [0, 1]
  ScalarType type = ScalarType::kFloat32;  // kUInt8 and kUInt16 are scaled to the type's full range
  std::uint64_t seed = 1;                  // for names that use random numbers
  // Nodes (about so many), particles or kernels, of names that are no lattice and have no `size`.
  std::int64_t count = 0;  // 0: the name's own default
};
std::vector<std::string> sample_names();  // what make_sample() knows, with defaults in its page
std::string describe_sample(const std::string& name);  // one line for the help text
Dataset make_sample(const std::string& name,
                    const MakeOptions& options = {});  // throws Error(kInvalidArgument)

// Steps of a name that moves ("tornado", "jet"), each made when it is read: from time 0 to 1 of the
// formula, `num_steps` of them at times 0, 1, 2, ..., or, staggered, on the four-dimensional
// body-centred lattice (D4*) that stands for those, up to the last of their times. `options.size`
// is that of the Cartesian lattice, `lattice` that of each step, which for staggered ones is
// Cartesian. Throws Error(kInvalidArgument).
std::shared_ptr<const StepSource> make_sample_steps(const std::string& name, std::int64_t num_steps,
                                                    SeriesKind kind,
                                                    const MakeOptions& options = {});
bool sample_moves(const std::string& name);  // false for unknown names, too

}  // namespace ovoid
