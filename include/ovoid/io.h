// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/dataset.h"
#include "ovoid/deep_image.h"
#include "ovoid/export.h"
#include "ovoid/image.h"
#include "ovoid/label_style.h"
#include "ovoid/look.h"
#include "ovoid/transfer_function.h"
#include "ovoid/transfer_function_2d.h"

namespace ovoid {
class ReaderSession;  // the library's own
}

namespace OVOID_API ovoid {

class StepSource;  // ovoid/series.h

// What a headerless file cannot say.
struct RawOptions {
  std::optional<Index3> dims;
  std::optional<ScalarType> type;
  std::optional<Vec3> spacing;
  bool big_endian = false;
  // What the axes of an array are, the slowest first, a letter for each: t, c (channels), z, y, x,
  // as "tczyx". Of NPY, Zarr, netCDF and grids in HDF5; empty: as the format has it.
  std::string axis_order;
};

// Which of an HDF5 file's arrays are read as particles, by their paths in the file.
struct Hdf5Options {
  std::string positions;            // "/PartType1/Coordinates"; empty: found
  std::vector<std::string> values;  // empty: all that lie beside the positions
};

// The `number`-th, from 0, of `count` runs of a file's rows: of n rows, from n * number / count up
// to but without n * (number + 1) / count, rounded down.
struct RowShare {
  int number = 0;
  int count = 1;
};

struct ReadOptions {
  RawOptions raw;
  // Read only this one if the format allows; empty: all. Particles keep all, since others say how
  // large and heavy they are.
  std::string array;
  std::string block;                 // which of Dataset::blocks; empty: the largest, of meshes all
  std::optional<std::int64_t> step;  // which time step; none: the first whose samples vary
  // Samples of a lattice that memory does not hold stay in their file, or are unpacked to a
  // temporary one (in TMPDIR), as docs/formats.md tells, "Larger than memory": of one component,
  // uint8, int8, uint16, int16 or float32, and of the step that is asked for. DataArray::stored has
  // them then.
  bool may_stay_in_file = false;
  // Bytes that such a field may take in memory; 0: most of what there is, divided by the processes
  // of this machine that read beside each other.
  std::int64_t memory_limit = 0;
  int processes_beside = 1;
  // Of what holds both points and faces (PLY, VTK's polygonal data): the faces, as a mesh of flat
  // cells, which is drawn beside a field (geometry.h). Without an array of its own it gets one of
  // zeros.
  bool faces = false;
  Hdf5Options hdf5;
  // Of particles, stored kernels, boxes and the cells of meshes this run of the rows alone: many
  // processes read a file together, and none holds all of it where docs/formats.md says so.
  // Lattices are read whole. What a reader finds out from all rows (notes, a periodic box, which
  // step is the first that varies) is the same in every share, but for notes on the pieces of a
  // mesh; numbers that are damaged are found by the share that holds them.
  std::optional<RowShare> share;
  // Files that the input names (pieces, data files, external storage) may also lie below these
  // folders; without any, in the input's own folder alone, and HDF5 files take nothing from others.
  std::vector<std::string> data_folders;
  // In [0, 1], on the reading thread. An exception that it throws ends the read, which throws it
  // on.
  std::function<void(double fraction)> progress;
  std::stop_token stop;
  // Path of ovoid-read, which reads with other people's libraries. Empty: beside the library, in
  // libexec/ovoid of its prefix, where it was to be installed, or in /usr/libexec/ovoid.
  std::string reader_program;
  // The process that ovoid-read runs in, kept from one read to the next;
  // open_steps() makes one. None: each read starts and ends its own.
  std::shared_ptr<ReaderSession> session;
};

// Whether memory, as far as the options grant it, does not hold a field of such samples of a
// lattice with one component, and they can stay in their file: what read_dataset() does then, if it
// may. For callers that hold samples elsewhere.
bool would_stay_in_file(ScalarType type, std::int64_t num_bytes, const ReadOptions& options);
// Bytes that a field may take before that: those of options.memory_limit, and what memory there is
// at this moment.
std::int64_t memory_for_field(const ReadOptions& options);

// Reads a volume, a mesh, adaptive grids, particles or stored kernels of the formats that
// docs/formats.md lists, some of which need a build with VTK or HDF5. The format is told from
// content, then from the name. A path may be a folder of DICOM files, or of pictures that are
// slices. Several paths are the slices of a DICOM series or of a volume in pictures, a PLOT3D grid
// and its solutions, or else the time steps of one dataset, of which one is read. Peak memory of a
// volume is at most 2.1 times the decoded size; sizes in headers are checked against the file
// before anything is allocated. Throws Error: kFileNotFound, kFileFormat (names file and field),
// kUnsupported, kInvalidArgument (also for a share that is not 0 <= number < count), kCancelled.
Dataset read_dataset(const std::vector<std::string>& paths, const ReadOptions& options = {});

// The time steps of what read_dataset(paths) reads, one of which is read at a time; a single volume
// is a series of one. Of several files the order is the one given, and of .pvd that of the times.
// Times are the input's own where it names them, of several files where every one of them does (the
// field data TimeValue of VTK's XML files, the time step of LAMMPS dumps) and they are not all the
// same; otherwise they are the steps' numbers. `options` are those of every read; options.step,
// stop and progress are not looked at but for the one read that this takes; options.share is that
// of each step's own rows, as in a read of that step. Throws what read_dataset throws for the first
// step, which is read; Error(kFileNotFound) for any file that is not there, and Error(kFileFormat),
// naming file and step, for times that are not finite or do not rise. Cost: one step, and the
// header of every other file.
std::shared_ptr<const StepSource> open_steps(const std::vector<std::string>& paths,
                                             const ReadOptions& options = {});

struct WriteOptions {
  std::stop_token stop;  // triggered: Error(kCancelled), and an existing file stays as it was
  // Told how much is done, rising to 1, by the calling thread. write_gif() alone does so: others
  // are done too soon.
  std::function<void(double fraction)> progress{};
};

// The endings of names under which write_dataset() writes data of this kind: ".nrrd", ".nii.gz".
std::vector<std::string> written_endings(DatasetKind kind);

// Writes a dataset; the name's ending chooses the format (written_endings; .h5 needs HDF5, and
// alone takes body-centred lattices), as a file is written below. The samples of NAME.nhdr go to
// NAME.raw, which is replaced only if it belongs to an existing NAME.nhdr; header and samples are
// replaced as one: whenever the program is stopped, the header names samples that are its own (in a
// file ovoid-*.raw, should it be killed between the two). Throws Error(kFileWrite, kUnsupported,
// kCancelled).
void write_dataset(const Dataset& dataset, const std::string& path,
                   const WriteOptions& options = {});

// What a file of this name will not say about where the samples of a lattice are, in words that
// follow the name; empty if nothing is lost. Throws Error(kUnsupported).
std::string lost_place(const Dataset& dataset, const std::string& path);

// Writes a picture: .png (8 bit, straight alpha; x-ray pictures must be mapped first), .jpg or
// .jpeg (8 bit, on the background, or else on black), .exr (float: R, G, B, A premultiplied, Z the
// front depth, half_opacity.Z the depth, and N.X, N.Y, N.Z if there are normals), .npy (float32
// [height, width, 4], premultiplied). Throws Error(kFileWrite, kUnsupported, kInvalidArgument,
// kCancelled).
void write_image(const Image& image, const std::string& path,
                 const std::optional<Rgb>& background = {}, const WriteOptions& options = {});

// What one of several that share a picture has drawn, as a file (`ovoid render --part`).
struct PicturePart {
  DeepImage seen;
  int number = 1, count = 1;  // part `number` of `count`, from 1
  // What the parts of one picture have in common, in lines "NAME VALUE": parts with other lines are
  // of other pictures.
  std::string picture;
  Look look;  // gives values their colours, where the mode keeps values
};

// Write and read a part: deep OpenEXR (.exr), each pixel's runs from front to back. Channels R, G,
// B, A (premultiplied), Z (front depth), half_opacity.Z (depth), coverage, and the whole numbers
// sheet.first and sheet.last. Compositing programs that know deep pictures can show it. Throw
// Error: kFileWrite, kFileNotFound, kFileFormat (names file and what is wrong), kOutOfMemory,
// kCancelled.
void write_picture_part(const PicturePart& part, const std::string& path,
                        const WriteOptions& options = {});
PicturePart read_picture_part(const std::string& path, std::stop_token stop = {});

// Speeds of GIF films. Delays are hundredths of a second in 16 bits, and viewers take less than two
// of them for a tenth of a second.
inline constexpr double kMinGifFps = 0.002;
inline constexpr double kMaxGifFps = 50;

// Writes a film without end, an animated GIF, of PNG pictures of one size, as a file is written
// below. Each picture is read twice, one at a time: memory is that of one picture and of some 100
// MiB. All frames share 256 colours, which are those that fit all of them best; pixels of others
// are mixed of two in a pattern that stands still. Pixels of less than half opacity are
// transparent, all others opaque. Times are rounded to hundredths of a second from the film's
// start, so a frame's own is wrong by less than one, at 50, 25, 20, 12.5 or 10 fps by none. Throws
// Error(kInvalidArgument) for no pictures, pictures of several sizes and a speed that is not in
// kMinGifFps to kMaxGifFps; kFileFormat, kUnsupported, kFileWrite, kCancelled.
void write_gif(const std::vector<std::string>& pictures, const std::string& path, double fps,
               const WriteOptions& options = {});

// Writes `bytes` as the whole content of `path`, as everything here is written: to a file of a
// random name in the same folder, made anew, which is put on the disk and then renamed. An existing
// file stays whole until the new one is; its owner, group, mode and access list are kept as far as
// the system lets the caller. A path that is a symbolic link stays one, and the file that it points
// to is replaced. Devices and pipes are written directly. Throws Error(kFileWrite).
void write_file(const std::string& path, std::string_view bytes);

// Puts the file `from` in the place of `to` in the same manner; a copy of it, if they lie in
// different file systems. Throws Error(kFileWrite); then `from` is left.
void replace_file(const std::string& from, const std::string& to);

// The files that read_dataset would read for `path`: it and those that it names (NRRD, MetaImage, a
// pair of NIfTI, pieces and steps of VTK's sets, EnSight, XDMF, Enzo), up to the first that is not
// there, or the DICOM files or pictures of a folder. A file that cannot be read stands alone;
// reading it tells why.
std::vector<std::string> files_read_for(const std::string& path);

// The files that write_dataset would write for `path`: it and the samples of a .nhdr.
std::vector<std::string> files_written_for(const std::string& path);

// Check, before long work, that write_image, write_dataset or write_file would accept the path: its
// ending is known, the system takes its name, and its folder can be written. They create nothing.
// Throw Error(kUnsupported, kFileWrite).
void check_image_path(const std::string& path);
void check_dataset_path(const std::string& path);
void check_file_path(const std::string& path);

// Removes what unfinished writers of this process have written so far; for a program's Ctrl-C
// handler, which must exit afterwards. Async-signal-safe.
void remove_partial_files() noexcept;

// The type called `name` as name_of(ScalarType) writes it or as C and numpy do ("uchar", "float",
// "f4"); empty if there is none.
std::optional<ScalarType> find_scalar_type(const std::string& name) noexcept;

// A look from a file, its kind told from its content (docs/looks.md, "Files"): ParaView's JSON and
// XML colour maps, 3D Slicer's volume properties (.vp.json, .vp, presets in MRML), Inviwo's
// transfer functions (.itf, rows of value, opacity and #rrggbb), and lists of numbers. Of a file
// with several it takes the first, or the one called `name`. What the file does not say keeps
// Look's defaults; its unit distance is the transfer function's. The look is valid. At most 16 MiB
// are read. Throws Error: kFileNotFound; kFileFormat (names file and place, or what the file looks
// like); kUnsupported; kInvalidArgument for an unknown name.
Look read_look(const std::string& path, const std::string& name = {});

// The same of a text that is in memory. `source_name` stands for the file in messages.
Look look_from_text(const std::string& text, const std::string& source_name = "text",
                    const std::string& name = {});

// Writes the transfer function, shading, material and unit distance as a ParaView JSON preset with
// keys of our own for what ParaView has none; read_look() gives all of them back, to the bit. The
// look's unit distance comes back as the transfer function's, which it beats; the linear width is
// kept of kSymlog alone, which uses it. Mode, isovalue, light direction and the color_function are
// left out. Throws Error(kFileWrite), kInvalidArgument for what is not valid.
void write_look(const Look& look, const std::string& path);

// What write_look() writes. Throws Error(kInvalidArgument).
std::string to_text(const Look& look);

// A 2-D transfer function from a file (docs/looks2d.md, "Files"): JSON of our own, by itself or in
// a look's; the first boxes of a ParaView state (.pvsm); a PNG picture, whose lowest row has the
// least gradient; or a grid of 4 components whose x is the value and whose y the gradient, in any
// format of read_dataset() that is told by its first bytes (VTK, NRRD). `ranges`: of a picture
// alone, which has none; where the middles of its outermost pixels lie. At most 16 MiB are read.
// Throws Error: kFileNotFound; kFileFormat, naming file and place; kInvalidArgument for ranges that
// are missing or too many.
struct Ranges2D {
  std::array<double, 2> values{0, 1};
  std::array<double, 2> gradients{0, 1};  // value per world length
};
TransferFunction2D read_transfer_function_2d(const std::string& path,
                                             const std::optional<Ranges2D>& ranges = {});

// The same of JSON in memory. `source_name` stands for the file in messages.
TransferFunction2D transfer_function_2d_from_text(const std::string& text,
                                                  const std::string& source_name = "text");

// The same for transfer functions alone.
TransferFunction read_transfer_function(const std::string& path, const std::string& preset = {});
void write_transfer_function(const TransferFunction& tf, const std::string& path);

// The numbers of a list "v,r,g,b,v,r,g,b,..." as colours, or of "v,a,v,a,..." as opacities; values
// rise, colours and opacities lie in [0, 1]. Throws Error(kInvalidArgument) that says what is
// wrong.
std::vector<ColorPoint> colors_from_list(const std::vector<double>& numbers);
std::vector<OpacityPoint> opacities_from_list(const std::vector<double>& numbers);

// The content of a small text file, as looks, cameras and states are read: of a regular file. Pipes
// and devices, which could block or never end, are not read. Throws Error: kFileNotFound for what
// is missing or unreadable; kUnsupported for a folder, a device or a pipe; kFileFormat for more
// than `max_bytes`.
std::string read_text_file(const std::string& path, std::size_t max_bytes);

// Names and colours of labels, its kind told from its content (docs/labels.md, "Names and
// colours"): 3D Slicer's colour tables (.ctbl) and segmentations (.seg.nrrd, whose header is read
// alone), ITK-SNAP's label descriptions, FreeSurfer's look-up tables, BIDS' dseg.tsv, rows of a
// number and a name, and JSON of our own. Of a label that is there twice the last counts. `layer`:
// of a segmentation whose segments overlap, each layer of which has labels of its own. At most 16
// MiB are read. Throws Error: kFileNotFound; kFileFormat, naming file and line, and for a file
// without labels.
std::vector<LabelEntry> read_label_table(const std::string& path, int layer = 0);

// The same of a text that is in memory, of any kind but segmentations. `source_name` stands for the
// file in messages.
std::vector<LabelEntry> label_table_from_text(const std::string& text,
                                              const std::string& source_name = "text");

// Camera files (JSON, VTK's words; docs/conventions.md). Missing members keep VTK's defaults. What
// was written is read to the bit. Throws Error.
Camera read_camera(const std::string& path);
void write_camera(const Camera& camera, const std::string& path);

// The same of a text that is in memory. `source_name` stands for the file in messages.
Camera camera_from_text(const std::string& text, const std::string& source_name = "text");

// What write_camera() writes. Throws Error(kInvalidArgument).
std::string to_text(const Camera& camera);

}  // namespace ovoid
