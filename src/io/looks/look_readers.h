// SPDX-License-Identifier: Apache-2.0
// The readers behind read_look(), one for each family of files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/core/json_file.h"
#include "ovoid/look.h"

namespace ovoid::io {

// A file that may hold looks: its content, and the name of the wanted one, empty for the first.
struct LookFile {
  std::string path;
  std::string text;
  std::string wanted;
};

// What a look file is expected to be, for messages about others.
inline constexpr const char* kExpectedLook =
    "expected a look: ParaView JSON or XML, Slicer .vp.json, .vp or MRML presets, Inviwo .itf or "
    "rows of value, opacity and #rrggbb, or a list of numbers";

// Each takes a file of its family and throws Error(kFileFormat, kUnsupported, kInvalidArgument).
// What they return is sorted but not yet validated.
Look read_paraview_json(const LookFile& file, const Json& json);
Look read_slicer_json(const LookFile& file, const Json& json);
Look read_xml_look(const LookFile& file);   // ParaView's colour maps, Inviwo's .itf, Slicer's MRML
Look read_text_look(const LookFile& file);  // Slicer's .vp, Inviwo's rows, lists of numbers

// Slicer's numbers in one line, "COUNT x y x y ..." and "COUNT x r g b ...", as .vp and MRML have
// them. `place` names file and line in errors.
void take_slicer_opacities(TransferFunction& tf, std::string_view line, const std::string& place);
void take_slicer_gradients(TransferFunction& tf, std::string_view line, const std::string& place);
void take_slicer_colors(TransferFunction& tf, std::string_view line, const std::string& place);

// One number, of a Slicer line or an attribute. Throws Error(kFileFormat) unless lo <= it <= hi.
double number_in(std::string_view text, double lo, double hi, const std::string& place);

// Throws Error(kInvalidArgument): the file has looks, but none of the wanted name.
[[noreturn]] void refuse_name(const LookFile& file, const std::vector<std::string>& names);

// The colour space that ParaView calls `name`, or an Error(kFileFormat) that begins with `place`.
// Lab/CIEDE2000 is kLab; the caller then follows the ways of that space.
ColorSpace color_space_called(const std::string& name, const std::string& place);
inline constexpr std::string_view kCiede2000 = "Lab/CIEDE2000";

// What a look has under "TransferFunction2D", read and written. Throws Error(kFileFormat).
TransferFunction2D function_2d_from(const JsonValue& json);
nlohmann::ordered_json json_of(const TransferFunction2D& function);

// follow_ciede2000(), its errors beginning with `place`.
void follow_ciede2000_of(TransferFunction& tf, const std::string& place);

// At most 80 characters of a name from a file, those that would break a line replaced by '?'.
std::string printable(std::string_view name);

}  // namespace ovoid::io
