// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vtk_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/core/work_done.h"
#include "io/core/xml_tags.h"
#include "io/foreign/vtk_header_parts.h"
#include "io/foreign/vtk_xml_arrays.h"
#include "io/vtk/vtk_extent.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Cells of `piece`, a part of `whole`. Where the whole has one sample, so has every piece, and a
// cell; elsewhere a piece of one sample has none.
std::int64_t num_cells_within(const VtkExtent& whole, const VtkExtent& piece) {
  std::int64_t result = 1;
  const auto dims = piece.dims();
  for (std::size_t axis = 0; axis < 3; ++axis)
    result *=
        whole.lo[axis] == whole.hi[axis] ? dims[axis] : std::max<std::int64_t>(dims[axis] - 1, 0);
  return result;
}

// None for what has no size of its own (String, Bit).
std::optional<ScalarType> scalar_type_of(const std::string& type) {
  static const std::map<std::string, ScalarType> kTypes{
      {"Int8", ScalarType::kInt8},       {"UInt8", ScalarType::kUInt8},
      {"Int16", ScalarType::kInt16},     {"UInt16", ScalarType::kUInt16},
      {"Int32", ScalarType::kInt32},     {"UInt32", ScalarType::kUInt32},
      {"Int64", ScalarType::kInt64},     {"UInt64", ScalarType::kUInt64},
      {"Float32", ScalarType::kFloat32}, {"Float64", ScalarType::kFloat64}};
  const auto found = kTypes.find(type);
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

// Bytes of one value; 0 where there is no type.
std::int64_t size_of_xml_type(const std::optional<ScalarType>& type) {
  return type ? static_cast<std::int64_t>(size_of(*type)) : 0;
}

// In the order of VtkGrid.
constexpr std::array<std::string_view, 5> kGridNames{
    "ImageData", "RectilinearGrid", "StructuredGrid", "UnstructuredGrid", "PolyData"};

constexpr std::size_t kMaxPieces = 10000;  // those with extents are compared each with each

class XmlChecker {
 public:
  explicit XmlChecker(const ByteSource& source) : source_(source), stored_(source) {}

  VtkOutline run() {
    scan();
    if (!has_image_) fail(fmt::format("holds no {} element: is the file truncated?", grid_name()));
    if (has_extents()) check_pieces();
    for (StoredArray& array : arrays_) {
      if (array.has_free_size) size_by_offsets(array);
    }
    std::int64_t total = 0;
    for (const StoredArray& array : arrays_) {
      stored_.check(array);
      // Several may mean the same bytes.
      if (array.format != "ascii") total += std::min(array.num_bytes, kMaxNumBytes / 1024);
      stored_.check_ratio("all arrays together", std::min(total, kMaxNumBytes));
    }
    if (stored_.is_compressed) add_work_done(total);  // VTK unpacks it
    outline_.grid = grid_;
    return std::move(outline_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    fail_header(source_, what, code);
  }

  std::string_view grid_name() const { return kGridNames[static_cast<std::size_t>(grid_)]; }

  bool has_extents() const {
    return grid_ != VtkGrid::kUnstructured && grid_ != VtkGrid::kPolyData;
  }

  // The elements of a piece that hold arrays.
  bool is_section(const std::string& name) const {
    if (name == "PointData" || name == "CellData" || name == "FieldData") return true;
    if (grid_ == VtkGrid::kImage) return false;
    if (grid_ == VtkGrid::kRectilinear) return name == "Coordinates";
    return name == "Points" || is_cell_list(name);
  }

  bool is_cell_list(const std::string& name) const {
    if (grid_ == VtkGrid::kUnstructured) return name == "Cells";
    return grid_ == VtkGrid::kPolyData &&
           (name == "Verts" || name == "Lines" || name == "Strips" || name == "Polys");
  }

  void scan() {
    XmlTagReader reader(source_);
    std::string section;  // PointData, CellData, Coordinates, Points ... while inside it
    while (auto tag = reader.next()) {
      const std::string& name = tag->name;
      end_text(tag->begin);
      if (is_section(name)) {
        section = tag->is_empty_element ? "" : name;
        if (name == "Coordinates") begin_coordinates();
        if (name == "Points" || is_cell_list(name)) begin_list(name);
        continue;
      }
      if (name == "/" + section) section.clear();
      if (name == "/Piece") end_piece();
      if (name.starts_with('/')) continue;
      refuse_references(*tag);
      if (name == "VTKFile") read_root(*tag);
      if (name == grid_name()) read_image(*tag);
      if (name == "Piece") read_piece(*tag);
      // To VTK every element here is an array, whatever it is called; these two stand within one.
      if (!section.empty() && name != "InformationKey" && name != "Value")
        read_array(*tag, section);
      if (name == "AppendedData") {
        stored_.is_appended_raw = tag->attribute("encoding") == "raw";
        find_appended(tag->end);
        return;  // bytes that may look like anything follow
      }
    }
    end_text(source_.size());
  }

  // The text of an array within the tags ends where the next tag begins.
  void end_text(std::int64_t position) {
    if (!arrays_.empty() && arrays_.back().text_end == 0) arrays_.back().text_end = position;
  }

  // "&#49;" is 1 to VTK and not to this checker; no writer makes such numbers.
  void refuse_references(const XmlTag& tag) const {
    for (const auto& [key, value] : tag.attributes) {
      if (key == "Name" || value.find('&') == std::string::npos) continue;
      fail(fmt::format("{}: {}=\"{}\": character references are not expected here",
                       tag.name.substr(0, 40), key.substr(0, 40), value.substr(0, 40)));
    }
  }

  // Behind blanks, an underscore stands before the first byte. VTK reads on from any other
  // character, out of step.
  void find_appended(std::int64_t position) {
    constexpr std::int64_t kMostBlanks = 4096;
    const std::string text = source_.text(position, kMostBlanks);
    const auto mark = text.find_first_not_of(" \t\r\n");
    if (mark == std::string::npos || text[mark] != '_') fail("AppendedData: do not begin with '_'");
    stored_.appended_begin = position + static_cast<std::int64_t>(mark) + 1;
  }

  void read_root(const XmlTag& tag) {
    const std::string type = tag.attribute("type");
    const auto found = std::find(kGridNames.begin(), kGridNames.end(), type);
    if (found == kGridNames.end()) {
      fail(fmt::format("VTKFile type '{}': expected ImageData, RectilinearGrid, StructuredGrid, "
                       "UnstructuredGrid or PolyData",
                       type.substr(0, 40)),
           ErrorCode::kUnsupported);
    }
    grid_ = static_cast<VtkGrid>(found - kGridNames.begin());
    stored_.is_big_endian = tag.attribute("byte_order") == "BigEndian";
    stored_.word_size = tag.attribute("header_type", "UInt32") == "UInt64" ? 8 : 4;
    const std::string compressor = tag.attribute("compressor");
    stored_.is_compressed = !compressor.empty();
    // Bytes out per byte in, at most. LZ4: 255 (a match grows by
    // 255 per byte); LZMA: 7090 measured on zeros, doubled.
    stored_.max_ratio = !stored_.is_compressed                  ? 1
                        : compressor == "vtkZLibDataCompressor" ? kZlibRatio
                        : compressor == "vtkLZ4DataCompressor"  ? 255
                                                                : 14180;
  }

  void read_image(const XmlTag& tag) {
    if (has_image_) fail(fmt::format("has two {} elements", grid_name()));
    has_image_ = true;
    if (!has_extents()) return;
    whole_ = parse_vtk_extent(source_, "WholeExtent", tag.attribute("WholeExtent"));
    if (num_points(source_, "WholeExtent", whole_.dims()) == 0)
      fail(fmt::format("WholeExtent=\"{}\": is empty", tag.attribute("WholeExtent")));
    check_numbers(tag, "Origin", 3);
    check_numbers(tag, "Spacing", 3);
    check_numbers(tag, "Direction", 9);
  }

  // VTK takes what it cannot read for its defaults.
  void check_numbers(const XmlTag& tag, const char* key, std::size_t count) const {
    if (!tag.attributes.contains(key)) return;
    const std::string text = tag.attribute(key);
    const auto parts = words(text);
    const bool are_numbers = std::all_of(parts.begin(), parts.end(), [](std::string_view part) {
      return is_number(part, NumberKind::kReal);
    });
    if (parts.size() != count || !are_numbers)
      fail(fmt::format("{}=\"{}\": expected {} numbers", key, text.substr(0, 80), count));
  }

  void read_piece(const XmlTag& tag) {
    lists_.clear();
    if (!has_extents()) return read_counts(tag);
    piece_ = parse_vtk_extent(source_, "Extent", tag.attribute("Extent"));
    num_points_ = num_cells_ = 0;
    if (num_points(source_, "Extent", piece_.dims()) == 0) return;
    if (!whole_.contains(piece_)) {
      fail(fmt::format("Piece Extent=\"{}\": lies outside WholeExtent", tag.attribute("Extent")));
    }
    num_points_ = num_points(source_, "Extent", piece_.dims());
    num_cells_ = num_cells(piece_.dims());
    num_coordinates_ = 0;
    is_piece_open_ = true;
    pieces_.push_back(piece_);
    add_piece();
  }

  // A piece of a mesh says how many points and cells it has.
  void read_counts(const XmlTag& tag) {
    counts_.clear();
    const auto count = [&](const char* key) {
      const std::string text = tag.attribute(key, "0");
      const auto parts = words(text);
      const auto value = parts.size() == 1 ? parse_integer(parts[0]) : std::nullopt;
      if (!value || *value < 0 || *value > kMaxAxisSize)
        fail(fmt::format("Piece: {}=\"{}\": expected 0 to {}", key, text.substr(0, 40),
                         kMaxAxisSize));
      return *value;
    };
    num_points_ = count("NumberOfPoints");
    num_cells_ = 0;
    for (const auto& [list, key] : {std::pair{"Cells", "NumberOfCells"},
                                    {"Verts", "NumberOfVerts"},
                                    {"Lines", "NumberOfLines"},
                                    {"Strips", "NumberOfStrips"},
                                    {"Polys", "NumberOfPolys"}}) {
      if (!is_cell_list(list)) continue;
      counts_[list] = count(key);
      num_cells_ += counts_[list];
    }
    is_piece_open_ = true;
    add_piece();
  }

  // Those of the file as a whole follow from its only piece.
  void add_piece() {
    if (++num_pieces_ > kMaxPieces)
      fail(fmt::format("has more than {} pieces", kMaxPieces), ErrorCode::kUnsupported);
    outline_.is_plain = outline_.is_plain && num_pieces_ == 1;
    outline_.num_points += num_points_;
    outline_.num_cells += num_cells_;
  }

  // Points, or a list of cells.
  void begin_list(const std::string& name) {
    if (!is_piece_open_) fail(fmt::format("{}: stand in no piece", name));
    if (!lists_.insert(name).second) fail(fmt::format("{}: stand twice in a piece", name));
    if (name != "Points") ++num_lists_;
    num_in_list_ = 0;
  }

  void begin_coordinates() {
    if (!is_piece_open_ || num_coordinates_ > 0) fail("Coordinates: stand twice, or in no piece");
  }

  void end_piece() {
    if (is_piece_open_ && grid_ == VtkGrid::kRectilinear && num_coordinates_ != 3) {
      fail(fmt::format("Coordinates: a piece has {} arrays of them: expected 3", num_coordinates_));
    }
    if (is_piece_open_ && grid_ >= VtkGrid::kStructured && num_points_ > 0 &&
        !lists_.contains("Points"))
      fail(fmt::format("a piece of {} points has no Points", num_points_));
    for (const auto& [list, count] : counts_) {
      if (is_piece_open_ && count > 0 && !lists_.contains(list))
        fail(fmt::format("a piece says {} {} and has no such element", count, list));
    }
    is_piece_open_ = false;
  }

  // Along the next axis.
  std::int64_t next_num_coordinates() {
    if (num_coordinates_ == 3) fail("Coordinates: a piece has more than 3 arrays of them");
    return piece_.dims()[num_coordinates_++];
  }

  // VTK leaves the samples of no piece as memory happens to be.
  void check_pieces() const {
    std::int64_t num_covered = 0;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (pieces_[i].shares_cells(pieces_[j]))
          fail(fmt::format("pieces {} and {} overlap", j, i));
      }
      num_covered += num_cells_within(whole_, pieces_[i]);
    }
    const std::int64_t num_whole = num_cells(whole_.dims());
    if (num_covered != num_whole)
      fail(fmt::format("the pieces cover {} of the {} cells of WholeExtent", num_covered,
                       num_whole));
  }

  // VTK 9.1 falls over text that ends early, and takes many times the memory that it takes in the
  // file.
  void leave_text_out(const XmlTag& tag, const std::string& section) {
    const std::string name = tag.attribute("Name"), type = tag.attribute("type");
    if (type != "String") {
      fail(fmt::format("array '{}': type '{}': expected String, Bit or a type of numbers",
                       name.substr(0, 80), type.substr(0, 40)),
           ErrorCode::kUnsupported);
    }
    const bool is_cell_data = section == "CellData";
    const std::string plain = without_entities(name).value_or(name);
    if (!text_names_.emplace(plain, is_cell_data).second) return;
    outline_.texts.push_back({plain, is_cell_data});
    if (text_names_.size() > static_cast<std::size_t>(kMaxVtkArrays))
      fail(fmt::format("has more than {} arrays", kMaxVtkArrays), ErrorCode::kUnsupported);
  }

  void read_array(const XmlTag& tag, const std::string& section) {
    const std::string type = tag.attribute("type");
    const std::optional<ScalarType> scalar = scalar_type_of(type);
    const bool is_bits = type == "Bit";
    if (!scalar && !is_bits && (section == "PointData" || section == "CellData"))
      return leave_text_out(tag, section);
    StoredArray array;
    array.name = tag.attribute("Name").substr(0, 80);
    array.format = tag.attribute("format", "ascii");
    if (array.format != "ascii" && array.format != "binary" && array.format != "appended") {
      fail(fmt::format("array '{}': format=\"{}\": expected ascii, binary or appended", array.name,
                       array.format.substr(0, 40)));
    }
    const auto integer = [&](const char* key, const char* otherwise, std::int64_t least,
                             std::int64_t most) {
      const std::string text = tag.attribute(key, otherwise);
      const auto parts = words(text);
      const auto value = parts.size() == 1 ? parse_integer(parts[0]) : std::nullopt;
      if (!value || *value < least || *value > most) {
        fail(fmt::format("array '{}': {}=\"{}\": expected {} to {}", array.name, key,
                         text.substr(0, 40), least, most));
      }
      return *value;
    };
    const std::int64_t num_components = integer("NumberOfComponents", "1", 1, kMaxVtkComponents);
    const std::int64_t num_tuples = section == "FieldData"
                                        ? integer("NumberOfTuples", "1", 0, kMaxNumBytes)
                                    : section == "Coordinates" ? next_num_coordinates()
                                    : is_cell_list(section)    ? place_in_list(array, section)
                                    : section == "CellData"    ? num_cells_
                                                               : num_points_;
    if (section == "Points" && (num_components != 3 || ++num_in_list_ > 1))
      fail("Points: expected one array of 3 components");
    const std::int64_t value_size = size_of_xml_type(scalar);
    if (section == "Coordinates" && (value_size == 0 || num_components != 1))
      fail(fmt::format("Coordinates: array '{}': expected numbers of one component", array.name));
    if ((section == "Points" || is_cell_list(section)) && value_size == 0)
      fail(fmt::format("{}: array '{}': expected numbers", section, array.name));
    if (is_cell_list(section) && num_components != 1)
      fail(fmt::format("{}: array '{}': expected one component", section, array.name));
    array.value_size = value_size;
    array.is_text = value_size == 0 && !is_bits;
    array.kind = type.starts_with("Float") ? NumberKind::kReal : NumberKind::kInteger;
    array.layout =
        fmt::format("{} tuples of {} {}", num_tuples, num_components, type.substr(0, 40));
    const auto num_values = checked_product(std::array{num_tuples, num_components});
    const auto num_bytes =
        checked_product(std::array{num_values.value_or(-1), std::max<std::int64_t>(value_size, 1)});
    if (!num_bytes || *num_bytes > kMaxNumBytes)
      fail(fmt::format("array '{}': {} are larger than any file", array.name, array.layout));
    if (section == "PointData" || section == "CellData") {
      outline_.is_plain = outline_.is_plain && !array.name.empty();
      if (scalar)
        outline_.arrays.push_back({array.name,
                                   *scalar,
                                   static_cast<int>(num_components),
                                   num_tuples,
                                   "",
                                   section == "CellData",
                                   {}});
    }
    array.num_values = *num_values;
    array.num_bytes = is_bits ? (*num_bytes + 7) / 8 : *num_bytes;
    if (array.format == "appended") {
      array.position = integer("offset", "0", 0, kMaxNumBytes);
      array.text_end = -1;
    } else {
      refuse_brackets(tag);
      array.position = tag.end;
      if (tag.is_empty_element) array.text_end = tag.end;
    }
    arrays_.push_back(array);
    if (arrays_.size() > kMaxVtkArrays)
      fail(fmt::format("has more than {} arrays", kMaxVtkArrays), ErrorCode::kUnsupported);
  }

  // What an array of a list of cells is, and its number of values; 0 where the offsets tell it.
  std::int64_t place_in_list(StoredArray& array, const std::string& section) {
    const std::int64_t count = counts_[section];
    array.cell_list = num_lists_;
    array.are_offsets = array.name == "offsets";
    array.has_free_size = array.name == "connectivity" && count > 0;
    if (array.name == "types" || array.are_offsets || array.name == "faceoffsets") return count;
    // The faces of polyhedra are as many as they are; of others, as VTK 9.4 writes, VTK 9.1 knows
    // nothing.
    return 0;
  }

  // VTK takes as many node numbers as the last offset says.
  void size_by_offsets(StoredArray& array) const {
    const auto offsets =
        std::find_if(arrays_.begin(), arrays_.end(), [&](const StoredArray& other) {
          return other.cell_list == array.cell_list && other.are_offsets;
        });
    if (offsets == arrays_.end()) fail("cells: have connectivity and no offsets");
    stored_.check(*offsets);
    const auto last = stored_.last_value(*offsets);
    std::int64_t num_values = 0;
    if (last) {
      num_values = *last;
    } else {
      num_values = stored_.num_stated(array) / array.value_size;
    }
    if (num_values < 0 || num_values > kMaxNumBytes / 8)
      fail(fmt::format("cells: the last offset is {}: expected the number of node numbers",
                       num_values));
    array.num_values = num_values;
    array.num_bytes = num_values * array.value_size;
    array.layout = fmt::format("{} node numbers of {} bytes", num_values, array.value_size);
  }

  // VTK takes the first '>' for the end of the tag when it looks for the text behind it.
  void refuse_brackets(const XmlTag& tag) const {
    for (const auto& [key, value] : tag.attributes) {
      if (value.find('>') == std::string::npos) continue;
      fail(fmt::format("{}: {}=\"{}\": expected '&gt;' for '>' where the data are within the tags",
                       tag.name.substr(0, 40), key.substr(0, 40), value.substr(0, 40)));
    }
  }

  const ByteSource& source_;
  XmlArrays stored_;
  VtkGrid grid_ = VtkGrid::kImage;
  bool has_image_ = false;
  bool is_piece_open_ = false;
  std::size_t num_coordinates_ = 0;              // arrays of them in this piece
  std::int64_t num_points_ = 0, num_cells_ = 0;  // of the piece
  std::map<std::string, std::int64_t> counts_;   // of its lists of cells
  std::set<std::string> lists_;                  // Points and lists that it has so far
  int num_lists_ = 0;                            // lists of cells in all pieces
  int num_in_list_ = 0;
  std::size_t num_pieces_ = 0;
  VtkOutline outline_;
  std::set<std::pair<std::string, bool>> text_names_;  // of outline_.texts
  VtkExtent whole_;
  VtkExtent piece_;  // the one that the arrays belong to
  std::vector<VtkExtent> pieces_;
  std::vector<StoredArray> arrays_;
};

}  // namespace

VtkOutline check_vtk_xml(const ByteSource& source) { return XmlChecker(source).run(); }

}  // namespace ovoid::io
