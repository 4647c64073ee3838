// SPDX-License-Identifier: Apache-2.0
// XDMF files made here: for tests of the reader, and where fuzzing starts from.
#pragma once

#include <string>

namespace ovoid::io {

inline std::string xdmf_file(const std::string& domain) {
  return "<?xml version=\"1.0\" ?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n"
         "<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><Domain>\n" +
         domain + "</Domain></Xdmf>\n";
}

// Numbers of a type like "Float\" Precision=\"8".
inline std::string xdmf_item(const std::string& dims, const std::string& text,
                             const std::string& attributes = "") {
  return "<DataItem Dimensions=\"" + dims + "\" " + attributes + ">" + text + "</DataItem>";
}

inline std::string xdmf_attribute(const std::string& name, const std::string& item,
                                  const std::string& attributes = "Center=\"Node\"") {
  return "<Attribute Name=\"" + name + "\" " + attributes + ">" + item + "</Attribute>\n";
}

// 4 x 3 x 2 samples, 0.5, 2 and 3 apart, from 10, 20, 30 on.
inline const std::string kXdmfEven =
    "<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"2 3 4\"/>\n"
    "<Geometry GeometryType=\"ORIGIN_DXDYDZ\">" +
    xdmf_item("3", "30 20 10") + xdmf_item("3", "3 2 0.5") + "</Geometry>\n";

// A unit cube and a tetrahedron beside it: 9 nodes.
inline const std::string kXdmfNodes =
    "<Geometry GeometryType=\"XYZ\">" +
    xdmf_item("9 3", "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1 2 0 0") + "</Geometry>\n";

inline const std::string kXdmfMixed =
    "<Topology TopologyType=\"Mixed\" NumberOfElements=\"2\">" +
    xdmf_item("14", "9 0 1 2 3 4 5 6 7 6 1 8 2 5", "NumberType=\"Int\"") + "</Topology>\n" +
    kXdmfNodes;

inline std::string xdmf_grid(const std::string& content, const std::string& attributes = "") {
  return "<Grid " + attributes + ">\n" + content + "</Grid>\n";
}

inline std::string xdmf_counting(int count) {
  std::string text;
  for (int i = 1; i <= count; ++i) text += std::to_string(i) + (i % 8 == 0 ? '\n' : ' ');
  return text;
}

// Two time steps, of which the second takes the first one's nodes and cells.
inline std::string xdmf_series() {
  const std::string include =
      "<xi:include xpointer=\"xpointer(//Grid[@Name=&quot;series&quot;]/Grid[1]/"
      "*[self::Topology or self::Geometry])\"/>";
  const std::string collection =
      "Name=\"series\" GridType=\"Collection\" CollectionType=\"Temporal\"";
  return xdmf_grid(xdmf_grid(kXdmfMixed + "<Time Value=\"0.5\"/>" +
                             xdmf_attribute("u", xdmf_item("9 1", xdmf_counting(9)))) +
                       xdmf_grid(include + "<Time Value=\"1.5\"/>" +
                                 xdmf_attribute("u", xdmf_item("9 1", "9 8 7 6 5 4 3 2 1"))),
                   collection);
}

// The second plane of each of two volumes.
inline std::string xdmf_slab() {
  return "<DataItem ItemType=\"HyperSlab\" Dimensions=\"2 3 2\">" +
         xdmf_item("3 3", "0 1 0  1 1 2  2 3 2", "NumberType=\"Int\"") +
         xdmf_item("2 4 4", xdmf_counting(32)) + "</DataItem>";
}

// Vectors of three arrays.
inline std::string xdmf_join() {
  return "<DataItem ItemType=\"Function\" Function=\"JOIN($0 , $1, $2)\" Dimensions=\"2 3 4 3\">" +
         xdmf_item("2 3 4", xdmf_counting(24)) + xdmf_item("24", xdmf_counting(24)) +
         xdmf_item("24 1", xdmf_counting(24)) + "</DataItem>";
}

}  // namespace ovoid::io
