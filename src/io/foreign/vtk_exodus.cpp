// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include <vtkExodusIIReader.h>
#include <vtkNew.h>

#include <string_view>

#include "io/foreign/mesh_readers.h"
#include "io/foreign/vtk_reading.h"
#include "io/foreign/vtk_timed.h"

namespace ovoid::io {
namespace {

// "Element Blocks/Unnamed block ID: 76 Type: HEX" -> "76"; named blocks keep their name.
std::string block_name(const std::string& name) {
  std::string_view rest = name;
  for (const std::string_view prefix : {"Element Blocks/", "Unnamed block ID: "}) {
    if (!rest.starts_with(prefix)) break;
    rest.remove_prefix(prefix.size());
    if (prefix.starts_with("Unnamed")) rest = rest.substr(0, rest.find(' '));
  }
  return std::string(rest);
}

}  // namespace

Dataset read_exodus(const ByteSource& source, const ReadOptions& options) {
  vtkNew<vtkExodusIIReader> reader;
  reader->SetFileName(path_for_vtk(source).c_str());
  // They cost memory and nothing here shows them.
  reader->GenerateObjectIdCellArrayOff();
  reader->GenerateGlobalElementIdArrayOff();
  reader->GenerateGlobalNodeIdArrayOff();
  const auto set_up = [&] {
    for (const int type : {vtkExodusIIReader::NODAL, vtkExodusIIReader::ELEM_BLOCK})
      reader->SetAllArrayStatus(type, 1);
  };
  return read_timed(source, "Exodus", reader, options, set_up, block_name);
}

}  // namespace ovoid::io

#endif
